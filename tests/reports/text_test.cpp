#include "writers/texts/text.h"
#include "cases.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "catch.h"
#include "evenstep/reports/json.h"

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
      REQUIRE(valid(json_text(two)));
      REQUIRE(Json::accept(json_text(two)));
      REQUIRE(valid(xml_escape(two + "\x80")));
    }
  }
  CHECK(json_text("\xC0\xAF") == "\"\xEF\xBF\xBD\xEF\xBF\xBD\"");      // overlong '/'
  CHECK(json_text("\xED\xA0\x80").find("\xED") == std::string::npos);  // a surrogate
}

TEST_CASE("every character survives JSON: control characters, quotes and what is not ASCII") {
  for (char32_t c = 0; c <= 0x10FFFF; c += c < 0x3000 ? 1 : 97) {
    if (c >= 0xD800 && c <= 0xDFFF) continue;
    std::string text = "a";
    append_utf8(text, c);
    REQUIRE(Json::parse(json_text(text + "\"\\b")).get<std::string>() == text + "\"\\b");
  }
}

TEST_CASE("a number in JSON reads back to the same double, whole ones have no point, what is no number is null") {
  CHECK(json_text(json_number(0.1)) == "0.1");
  CHECK(json_text(json_number(1e-6)) == "1e-06");
  CHECK(json_text(json_number(4)) == "4");
  CHECK(json_text(json_number(-1e15)) == "-1000000000000000");
  CHECK(json_text(json_number(1e300)) == "1e+300");
  CHECK(json_text(json_number(NAN)) == "null");
  CHECK(json_text(json_number(-INFINITY)) == "null");
  CHECK(json_text(json_number(std::optional<double>())) == "null");
  std::mt19937_64 random(1);
  for (int i = 0; i < evenstep::testing::cases(100'000); ++i) {
    double value = 0;
    const std::uint64_t bits = random();
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    REQUIRE(Json::parse(json_text(json_number(value))).get<double>() == value);
  }
  CHECK(std::signbit(Json::parse(json_text(json_number(-0.0))).get<double>()));
}

TEST_CASE("the rows of one array may have a line each, and read back as they do on one") {
  const Json json = {{"a", "1,2"}, {"rows", {{{"b", "\n"}}, {{"b", 2}}}}, {"none", Json::array()}};
  CHECK(json_text(json, "rows") == "{\"a\":\"1,2\",\"rows\":[\n{\"b\":\"\\n\"},\n{\"b\":2}],\"none\":[]}");
  for (const char* rows : {"rows", "none", "absent"}) CHECK(Json::parse(json_text(json, rows)) == json);
}

TEST_CASE("XML text has no character that XML 1.0 forbids") {
  CHECK(xml_escape("a<b>&\"c\x01\x1B\n") == "a&lt;b&gt;&amp;&quot;c\uFFFD\uFFFD&#10;");  // seen, not lost
  CHECK(xml_escape("\xEF\xBF\xBE") == "\uFFFD");
  CHECK(xml_escape("]]>\u202E") == "]]&gt;\u202E");
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

TEST_CASE("words are broken into lines that are as wide as they may be, and none is lost") {
  const std::string text = "one two three four five six";
  CHECK(in_lines(text, 9, "  ") == "  one two\n  three\n  four\n  five\n  six\n");
  CHECK(in_lines(text, 120) == text + "\n");
  CHECK(in_lines("incontrovertible a", 4) == "incontrovertible\na\n");
  CHECK(in_lines("\xE6\x97\xA5\xE6\x97\xA5 b", 6) == "\xE6\x97\xA5\xE6\x97\xA5 b\n");
  CHECK(in_lines("\xE6\x97\xA5\xE6\x97\xA5 b", 5) == "\xE6\x97\xA5\xE6\x97\xA5\nb\n");  // two columns each
  CHECK(in_lines("", 5) == "\n");
  for (std::size_t columns = 1; columns < 40; ++columns) {
    std::string words = in_lines(text, columns);
    std::replace(words.begin(), words.end(), '\n', ' ');
    CHECK(words == text + " ");
  }
}
