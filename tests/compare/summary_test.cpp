#include "evenstep/campaigns/summary.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cases.h"
#include "catch.h"
#include "evenstep/reports/writers.h"
#include "samples.h"
#include "temporary_folder.h"

using namespace evenstep;
using Catch::Contains;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::string sample() {
  RunRecord run = synthetic::nasty_run();
  run.digest = 0xabcdef;
  run.origin = {"2026-11-23T11:05:13Z", std::string(40, '7')};
  return summary_json(run, measure(run), synthetic::nasty_results(), "0.2.0", "fail");
}

RunSummary read_one(const std::string& text) {
  const auto read = parse_summaries(text, "s.json");
  if (!read) INFO(evenstep::text(read.error().front()));
  REQUIRE(read.ok());
  REQUIRE(read->size() == 1);
  return read->front();
}

std::string summary_error(const std::string& text) {
  const auto read = parse_summaries(text, "s.json");
  REQUIRE_FALSE(read.ok());
  REQUIRE(read.error().size() == 1);
  return evenstep::text(read.error().front());
}

/// The sample with one member replaced.
std::string with(const char* pointer, const nlohmann::json& value) {
  nlohmann::json tree = nlohmann::json::parse(sample());
  tree[nlohmann::json::json_pointer(pointer)] = value;
  return tree.dump();
}
std::string without(const std::string& key) {
  nlohmann::json tree = nlohmann::json::parse(sample());
  tree.erase(key);
  return tree.dump();
}

}  // namespace

TEST_CASE("what summary_json writes is read back") {
  const RunSummary run = read_one(sample());
  CHECK(run.scenario == synthetic::kNastyText);
  CHECK(run.digest == "0000000000abcdef");
  CHECK(run.date == "2026-11-23T11:05:13Z");
  CHECK(run.commit == std::string(40, '7'));
  CHECK(run.seed == 18446744073709551615ULL);
  CHECK(run.verdict == "fail");
  CHECK(run.expectations.size() == synthetic::nasty_results().size());
  CHECK(run.expectations[0].min == 4);
  CHECK_FALSE(run.expectations[0].max);
  CHECK(run.expectations[0].pattern == "left.interaction.direct");
  CHECK(run.expectations[0].file == "scenarios/a&b.toml");
  CHECK(run.expectations[0].line == 12);
  CHECK_FALSE(run.metrics.at("left.interaction.direct").at("velocity_jump"));  // a NaN position
  CHECK(run.metrics.at("left.interaction.paper").at("velocity_jump").value() < 1e-9);
  CHECK(run.strategies.at("paper").solver == synthetic::kNastyText);
}

TEST_CASE("the list that run --json prints of several files is read, each run under its file's name") {
  const auto read = parse_summaries("[" + sample() + ",\n" + sample() + "]", "list.json");
  REQUIRE(read.ok());
  CHECK(read->size() == 2);
  CHECK(read->front().name == "scenarios/a&b.toml");
  CHECK_THAT(summary_error("[]"), Contains("has no runs"));
}

TEST_CASE("a summary of an older evenstep lacks date, commit and digest, and is read, and another format is refused") {
  for (const char* key : {"date", "commit", "scenario_digest"}) {
    const RunSummary run = read_one(without(key));
    CHECK((run.date.empty() || run.commit.empty() || run.digest.empty()));
  }
  CHECK_THAT(summary_error(with("/format", 7)), Contains("is of format 7, and this evenstep reads format 1"));
  CHECK_THAT(summary_error(without("format")), Contains("must be an object with \"format\""));
}

TEST_CASE("what is wrong has a place: line and column of a mistake in JSON, the path of a wrong value") {
  CHECK_THAT(summary_error("{\"format\":1,\n  oops}"), Contains("s.json:2:3: error: is not JSON"));
  CHECK_THAT(summary_error(""), Contains("s.json:1:1: error: is not JSON"));
  CHECK_THAT(summary_error("{\"format\":1e999}"), Contains("is not JSON"));
  CHECK_THAT(summary_error(with("/expectations/1/min", "x")), Contains("/expectations/1/min must be a number or null"));
  CHECK_THAT(summary_error(with("/verdict", "maybe")), Contains("/verdict must be \"pass\", \"none\""));
  CHECK_THAT(summary_error(with("/seed", -1)), Contains("/seed must be a whole number"));
  CHECK_THAT(summary_error("3"), Contains("the file must be an object with \"format\""));
  CHECK_THAT(summary_error(with("/metrics/\x1b[31m", 3)), Contains("/metrics/\u27e8U+001B\u27e9[31m must be an object"));
}

TEST_CASE("depth is limited, however deep a file is") {
  CHECK_THAT(summary_error(std::string(2'000'000, '[')), Contains("is deeper than 16 levels"));
  CHECK_THAT(summary_error(std::string(16, '[') + std::string(16, ']')), Contains("must be an object with \"format\""));
}

TEST_CASE("1,000 damaged summaries are read or refused, and none ends the program") {
  const std::string good = sample();
  const std::string letters = "{}[]\",:0123456789.eE+-truefalsnu\\\x01\xff\x80 ";
  std::mt19937 random(11);
  std::size_t refused = 0;
  for (std::uint64_t i = 0; i < evenstep::testing::cases(1000); ++i) {
    std::string text = good;
    for (std::size_t changes = 1 + random() % 4; changes > 0 && !text.empty(); --changes) {
      const std::size_t at = random() % text.size();
      switch (random() % 5) {
        case 0:
          text.erase(at, 1 + random() % 200);
          break;
        case 1:
          text.insert(at, good.substr(random() % good.size(), 1 + random() % 200));
          break;
        case 2:
          text.resize(at);
          break;
        default:
          text[at] = letters[random() % letters.size()];
      }
    }
    const auto read = parse_summaries(text, "s.json");
    refused += read ? 0 : 1;
    if (!read) CHECK(read.error().size() == 1);
  }
  CHECK(refused > evenstep::testing::cases(1000) / 2);
}

TEST_CASE("1,000 summaries with values of a wrong kind are read or refused") {
  const nlohmann::json good = nlohmann::json::parse(sample());
  const nlohmann::json flat = good.flatten();
  const std::vector<nlohmann::json> values{nullptr, true, -1, 1e308, "x", nlohmann::json::array(), nlohmann::json::object()};
  std::mt19937 random(12);
  for (std::uint64_t i = 0; i < evenstep::testing::cases(1000); ++i) {
    auto at = flat.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(random() % flat.size()));
    nlohmann::json damaged = good;
    nlohmann::json::json_pointer place(at.key());
    for (std::size_t up = random() % 3; up > 0 && !place.empty(); --up) place = place.parent_pointer();
    damaged[place] = values[random() % values.size()];
    const auto read = parse_summaries(damaged.dump(), "s.json");
    if (!read) CHECK(read.error().size() == 1);
  }
}

TEST_CASE("all run folders below a folder are read in order, but for hidden ones, and the first wrong one is named") {
  const TemporaryFolder folder;
  CHECK_THAT(text(read_summaries(folder.path().string()).errors.at(0)), Contains("has no run (summary.json) in it"));
  CHECK_THAT(text(read_summaries(folder / "gone").errors.at(0)), Contains("no such file"));
  folder.write("b/summary.json", sample());
  folder.write("a/deep/summary.json", sample());
  folder.write("a/deep/resolved.toml", "[run]\nseed = 1\n");
  folder.write(".a.writing-7/summary.json", "{");
  fs::create_directory_symlink(folder / "b", folder / "link");
  SummariesRead read = read_summaries(folder.path().string());
  REQUIRE(read.errors.empty());
  REQUIRE(read.runs.size() == 2);
  CHECK(read.runs[0].name == "a/deep");
  CHECK(read.runs[0].resolved == std::vector<std::string>{"[run]", "seed = 1"});
  CHECK(read.runs[1].name == "b");
  CHECK(read_summaries(folder / "b").runs.size() == 1);
  CHECK(read_summaries(folder / "b/summary.json").runs.size() == 1);
  folder.write("c/summary.json", "{");
  read = read_summaries(folder.path().string());
  CHECK(read.runs.size() == 2);
  REQUIRE(read.errors.size() == 1);
  CHECK_THAT(text(read.errors[0]), Contains("c/summary.json:1:2: error: is not JSON"));
}

TEST_CASE("a margin is a share of its limit") {
  ExpectationResult result;
  result.value = 0.9;
  result.max = 1;
  CHECK(relative_margin(result).value() == Approx(0.1));
  result.value = 1.2;
  CHECK(relative_margin(result).value() == Approx(-0.2));
  result.min = 1.1;
  result.max = 2;
  CHECK(relative_margin(result).value() == Approx(0.1 / 1.1));
  result.min = -2;
  result.max = -1;
  result.value = -1.1;
  CHECK(relative_margin(result).value() == Approx(0.1));
  result.min = result.max = 0;  // an `equals`
  CHECK_FALSE(relative_margin(result));
  result.min = std::nullopt;  // a share of nothing
  CHECK_FALSE(relative_margin(result));
  result.max = 1;
  result.value = std::nullopt;
  CHECK_FALSE(relative_margin(result));
}
