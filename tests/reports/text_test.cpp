#include "src/text.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace evenstep;
using namespace evenstep::internal;

TEST_CASE("every code point survives a round through UTF-8") {
  for (char32_t c = 0; c <= 0x10FFFF; ++c) {
    if (c >= 0xD800 && c <= 0xDFFF) continue;
    std::string text;
    append_utf8(text, c);
    std::string_view rest = text;
    REQUIRE(take_code_point(rest) == c);
    REQUIRE(rest.empty());
  }
}

TEST_CASE("whatever two or three bytes stand there, JSON and XML text stays valid UTF-8") {
  const auto valid = [](std::string_view text) {
    while (!text.empty()) {
      const std::string_view before = text;
      if (take_code_point(text) == 0xFFFD && before.substr(0, 3) != "\xEF\xBF\xBD") return false;
    }
    return true;
  };
  for (unsigned a = 0; a < 256; ++a) {
    for (unsigned b = 0; b < 256; ++b) {
      const std::string two{static_cast<char>(a), static_cast<char>(b)};
      REQUIRE(valid(json_string(two)));
      REQUIRE(valid(xml_escape(two + "\x80")));
    }
  }
  CHECK(json_string("\xC0\xAF") == "\"\xEF\xBF\xBD\xEF\xBF\xBD\"");      // overlong '/'
  CHECK(json_string("\xED\xA0\x80").find("\xED") == std::string::npos);  // a surrogate
}

TEST_CASE("JSON text escapes quotes, backslashes and control characters only") {
  CHECK(json_string("a\"b\\c\n\t\x01µ") == "\"a\\\"b\\\\c\\u000a\\u0009\\u0001µ\"");
  CHECK(json_number(0.1) == "0.1");
  CHECK(json_number(-0.0) == "-0");
  CHECK(json_number(1e-6) == "1e-06");
  CHECK(json_number(NAN) == "null");
  CHECK(json_number(-INFINITY) == "null");
}

TEST_CASE("XML text has no character that XML 1.0 forbids") {
  CHECK(xml_escape("a<b>&\"c\x01\x1B\n") == "a&lt;b&gt;&amp;&quot;c&#10;");
  CHECK(xml_escape("\xEF\xBF\xBE") == "");
}

TEST_CASE("display width counts columns, not bytes") {
  CHECK(display_width("abc") == 3);
  CHECK(display_width("µm") == 2);
  CHECK(display_width("e\xCC\x81") == 1);     // e + combining acute
  CHECK(display_width("\xE6\x97\xA5") == 2);  // one wide character
}

TEST_CASE("seconds of an instant are exact") {
  CHECK(exact_seconds({0}) == "0.000000000");
  CHECK(exact_seconds({1'234'567'890}) == "1.234567890");
  CHECK(exact_seconds({-1}) == "-0.000000001");
  CHECK(exact_seconds({INT64_MIN}) == "-9223372036.854775808");
}
