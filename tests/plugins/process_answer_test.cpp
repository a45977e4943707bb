// The bytes of docs/parts/process-protocol.md.
#include "src/process_answer.h"
#include "catch.h"
#include "src/excerpt.h"

using namespace evenstep;
using namespace evenstep::internal;

TEST_CASE("A request has its numbers at the offsets that the protocol says, the least byte first") {
  const std::string bytes =
      request_record(RequestKind::step, 0x0102030405060708, 1.0, std::array{glm::dvec3(1, -2, 0), glm::dvec3(0)});
  REQUIRE(bytes.size() == 24 + 2 * 24);
  CHECK(bytes.substr(0, 8) == std::string("\x01\0\0\0\0\0\0\0", 8));
  CHECK(bytes.substr(8, 8) == "\x08\x07\x06\x05\x04\x03\x02\x01");
  CHECK(bytes.substr(16, 8) == std::string("\0\0\0\0\0\0\xf0\x3f", 8));
  CHECK(bytes.substr(32, 8) == std::string("\0\0\0\0\0\0\0\xc0", 8));
}

TEST_CASE("An answer is read from the offsets that the protocol says") {
  std::string bytes(32 + 24 + 136, '\0');
  const auto set = [&](std::size_t at, std::string_view what) { bytes.replace(at, what.size(), what); };
  const std::string one("\0\0\0\0\0\0\xf0\x3f", 8);
  REQUIRE(answer_size(1, true) == bytes.size());
  set(0, "\x01");
  set(4, "\x03");
  set(8, "\x05");
  set(16, "\xff");
  for (const std::size_t at : {24, 40, 56 + 8, 56 + 32, 56 + 56, 56 + 64 + 32}) set(at, one);
  set(56, "\x01");
  const auto answer = read_answer(bytes, 1, true, RequestKind::step, 5);
  REQUIRE(answer);
  CHECK(answer->status == 3);
  CHECK(answer->state_digest == 0xff);
  CHECK(answer->energy_J == 1);
  CHECK(answer->response.force_N[0] == glm::dvec3(0, 1, 0));
  const ToolContact& contact = answer->contacts.at(0);
  CHECK(contact.touching);
  CHECK_FALSE(contact.unilateral);
  CHECK(contact.point_m == glm::dvec3(1, 0, 0));
  CHECK(contact.normal == glm::dvec3(1, 0, 0));
  CHECK(contact.gap_m == 1);
  CHECK(contact.stiffness_N_per_m[1][1] == 1);
  CHECK_FALSE(read_answer(bytes, 1, true, RequestKind::step, 6));
  CHECK_FALSE(read_answer(bytes, 1, true, RequestKind::reset, 5));
}

TEST_CASE("The first line says what it is made for, and the answer what it can") {
  CHECK(greeting({.options = "{\"k\":1}", .step_s = 0.1, .tool_count = 2, .seed = 3}) ==
        "{\"protocol\":1,\"tools\":2,\"step_s\":0.1,\"variable_step\":false,\"local_model\":\"none\",\"seed\":3,"
        "\"options\":{\"k\":1}}\n");
  const auto has = read_greeting("{\"protocol\": 1, \"has\": [\"contacts\", \"energy\"]}\r");
  REQUIRE(has);
  CHECK(has->contacts);
  CHECK(has->energy);
  CHECK_FALSE(has->reset);
  CHECK(read_greeting("{\"protocol\": 1}"));
  for (const char* line :
       {"", "3", "[]", "{}", "{\"protocol\": \"1\"}", "{\"protocol\": 1, \"has\": 3}", "{\"protocol\": 1, \"has\": [3]}",
        "{\"protocol\": 1, \"hass\": []}", "{\"protocol\": 1} x", "{\"protocol\": 1, \"has\": [\"particles\"]}", "\xff"}) {
    INFO(line);
    CHECK_FALSE(read_greeting(line));
  }
}

TEST_CASE("Of what others wrote, whole characters of UTF-8 are shown, and of anything else a question mark for each byte") {
  CHECK(excerpt("a ü 力 🙂", 40) == "a ü 力 🙂");
  for (const auto& [text, shown] : std::vector<std::pair<std::string, std::string>>{
           {"a\x1b[2J\n\x7f", "a?[2J??"},
           {"\xc2\x9b", "??"},          // U+009B, with which a terminal's commands begin, too
           {"\xc2\xa0|", "\xc2\xa0|"},  // the first that is none
           {"\xc0\xaf", "??"},          // overlong forms of '/'
           {"\xe0\x80\xaf", "???"},
           {"\xf0\x80\x80\xaf", "????"},
           {"\xed\xa0\x80", "???"},                   // a surrogate
           {"\xed\x9f\xbf", "\xed\x9f\xbf"},          // U+D7FF, the last before them
           {"\xf4\x8f\xbf\xbf", "\xf4\x8f\xbf\xbf"},  // U+10FFFF, the last of all
           {"\xf4\x90\x80\x80", "????"},
           {"\xf5\x80\x80\x80", "????"},
           {"\xe5\x8a", "??"},  // cut off
           {"\xe5\x8az", "??z"},
           {"\x80", "?"}}) {
    INFO(shown);
    CHECK(excerpt(text, 40) == shown);
  }
  CHECK(excerpt("力力", 5) == "力...");  // no half of a character
  CHECK(excerpt("abc", 3) == "abc");
}
