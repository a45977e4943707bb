#include <random>

#include "cases.h"
#include "catch.h"
#include "evenstep/format/scenario.h"
#include "evenstep/recordings/timing_csv.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// A scenario with every model of [timing].
std::string with_models() {
  std::string text = kSpring;
  text.insert(text.find("[scene]"),
              "order = \"steps-first\"\npaced = true\nstep = \"0.5 ms\"\nfirst_step = \"+20 %\"\ndrift = \"-2 %/s\"\n"
              "spikes = { rate = \"2 Hz\", cost = \"4 ms\" }\nregimes = { factor = 1.6, mean_length = \"8 segments\" }\n"
              "preemption = { rate = \"2 Hz\", cost = \"pareto 3 ms cap 40 ms\", tail = 1.2 }\n"
              "dropped_visualization = \"2 %\"\nmerged_visualization = \"3 %\"\n"
              "changes = [{ at = \"2 s\", visualization = \"9 ms\" }, { at = \"3 s\", steps = [3, 4], step = \"1 ms\" }]\n");
  return text;
}

/// The text after one to three mutations: bytes are changed, removed, added or copied from elsewhere in the text.
std::string mutated(std::string text, std::mt19937_64& random) {
  const int changes = 1 + static_cast<int>(random() % 3);
  for (int i = 0; i < changes && !text.empty(); ++i) {
    const std::size_t at = random() % text.size();
    switch (random() % 5) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text[at] = "0123456789.-+eE\"'[]{}=,# \n"[random() % 26];
        break;
      case 2:
        text.erase(at, 1 + random() % 8);
        break;
      case 3:
        text.insert(at, 1, static_cast<char>(random()));
        break;
      default:
        text.insert(at, text.substr(random() % text.size(), 1 + random() % 40));
        break;
    }
  }
  return text;
}

}  // namespace

TEST_CASE("Ten thousand damaged scenarios are each read or refused with a place, and what is read reads back") {
  std::mt19937_64 random(20'070'101);  // fixed seed: the same files on every run
  const TemporaryFolder folder;
  const std::string bases[] = {kSpring, kTissue, with_models()};
  int read = 0, refused = 0;
  for (int i = 0; i < evenstep::testing::cases(10'000); ++i) {
    const std::string text = mutated(bases[i % 3], random);
    const ReadResult result = read_scenario(folder.write("s.toml", text));
    if (!result && result.error().empty()) FAIL("neither read nor refused:\n" << text);
    for (const Diagnostic& error : result.error_or({})) {
      if (error.message.empty() || error.line < 1 || error.column < 1)
        FAIL("an error without a place:\n" << text << evenstep::text(error));
    }
    if (!result) {
      ++refused;
    } else {
      ++read;
      if (read % 10 != 0) continue;
      const ReadResult again = read_scenario(folder.write("r.toml", result->resolved_toml));
      if (!again || describe(*again) != describe(*result)) FAIL("does not read back:\n" << text << errors_of(again));
    }
  }
  // Both outcomes occur, and most damage is found.
  CHECK(read > evenstep::testing::cases(100));
  CHECK(refused > evenstep::testing::cases(5000));
}

TEST_CASE("Ten thousand damaged recordings are each read or refused") {
  std::mt19937_64 random(30);
  const std::string good =
      "segment,kind,index,begin_ns,end_ns\n0,visualization,0,100,10100\n0,step,0,10100,14100\n0,idle,0,18200,30100\n"
      "1,visualization,0,30100,42100\n1,step,0,42100,46100\n1,step,1,46100,50100\n";
  int read = 0;
  for (int i = 0; i < evenstep::testing::cases(10'000); ++i) {
    const TimingCsv csv = parse_timing_csv(mutated(good, random), "x.csv");
    if (!csv) continue;
    ++read;
    REQUIRE_FALSE(csv->empty());
    CHECK(csv->front().begin.ns == 0);
  }
  CHECK(read > evenstep::testing::cases(100));
}

TEST_CASE("Any character beyond ASCII after a value is refused with its place") {
  // toml++ 3.3 declares a branch unreachable which U+00A1 to U+0499 reach here. All of these are tried, and every 31st
  // character beyond.
  const TemporaryFolder folder;
  for (std::uint32_t c = 0x80; c < 0xfff0; c += c < 0x500 ? 1 : 31) {
    if (c >= 0xd800 && c < 0xe000) continue;
    std::string letter;
    if (c < 0x800) {
      letter = {static_cast<char>(0xc0 | c >> 6), static_cast<char>(0x80 | (c & 0x3f))};
    } else {
      letter = {static_cast<char>(0xe0 | c >> 12), static_cast<char>(0x80 | (c >> 6 & 0x3f)),
                static_cast<char>(0x80 | (c & 0x3f))};
    }
    const ReadResult result = read_scenario(folder.write("s.toml", "format = 1" + letter + "\n"));
    INFO("U+" << std::hex << c);
    REQUIRE(result.error_or({}).size() == 1);
    REQUIRE(result.error()[0].line == 1);
    REQUIRE(result.error()[0].column == 11);
  }
}

TEST_CASE("A key nested without end is refused before it can overflow the stack") {
  std::string dotted = "format = 1\n";
  for (int i = 0; i < 500'000; ++i) dotted += "a.";
  CHECK_FALSE(read_text(dotted + "a = 1\n"));
  // The deepest nesting that the line limit lets pass: 32 dots in each of as many nested lists as toml++ allows, and more.
  for (const int levels : {7, 200, 2000}) {
    std::string nested = "format = 1\n";
    const std::string key = "a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a";
    for (int i = 0; i < levels; ++i) nested += (i == 0 ? "" : "{") + key + " = [\n";
    CHECK_FALSE(read_text(nested));
    for (int i = 0; i < levels; ++i) nested += (i + 1 == levels ? "]" : "]}\n");
    CHECK_FALSE(read_text(nested));
  }
}
