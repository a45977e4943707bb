// Merges of generated points, with more parts than a process can have open, and with as many points as a sweep may have.
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <numeric>

#include "catch.h"
#include "evenstep/campaigns/sweep.h"
#include "files.h"
#include "merge_cost.h"
#include "src/sweep/lines.h"

using namespace evenstep;

namespace {

SweepHeader header_of(std::int64_t points) {
  SweepHeader header;
  header.name = "generated";
  header.file = "generated.toml";
  header.scenario = "0123456789abcdef";
  header.build = "0.2.0-0123456789abcdef";
  header.seeds.resize(static_cast<std::size_t>(points / 2));
  std::iota(header.seeds.begin(), header.seeds.end(), std::uint64_t{0});
  header.grid = {{"remap.latency", {"\"13 ms\"", "\"14 ms\""}}};
  header.expectations = {{"left.force.phase_locked", "underruns", ""}, {"left.force.phase_locked", "velocity_jump", "step"}};
  return header;
}

/// One point in 97 fails, with more underruns the later it comes.
std::string line_of(const SweepHeader& header, std::int64_t index) {
  const auto verdict = index % 97 == 5 ? SweepVerdict::fail : SweepVerdict::pass;
  SweepPoint point{
      .index = index, .verdict = verdict, .trace_hash = static_cast<std::uint64_t>(index) * 0x9e3779b97f4a7c15U};
  const double underruns = verdict == SweepVerdict::fail ? static_cast<double>(index) : 0;
  point.expect = {{underruns, 0.0, 0.0, verdict},
                  {0.0625 + 1e-9 * static_cast<double>(index), {}, 0.25, SweepVerdict::pass}};
  return internal::point_line(header, point);
}

/// Writes the parts of this many shards. If `whole` is given, what a single process would write is appended to it.
std::vector<std::string> generate(const testing::TemporaryFolder& folder, const SweepHeader& header, int shards,
                                  std::string* whole) {
  std::vector<std::string> parts;
  for (int shard = 1; shard <= shards; ++shard) {
    parts.push_back(folder / fmt::format("sweep-{}-of-{}.jsonl", shard, shards));
    std::ofstream part(parts.back(), std::ios::binary);
    part << internal::header_line(header, {shard, shards}) << '\n';
    for (std::int64_t index = shard - 1; index < header.points(); index += shards) part << line_of(header, index) << '\n';
  }
  if (whole == nullptr) return parts;
  *whole = internal::header_line(header, {}) + '\n';
  for (std::int64_t index = 0; index < header.points(); ++index) *whole += line_of(header, index) + '\n';
  return parts;
}

}  // namespace

TEST_CASE("More parts than a process may open merge to the bytes of one process and the missing ones are named") {
  const testing::TemporaryFolder folder;
  const SweepHeader header = header_of(6000);
  std::string whole;
  std::vector<std::string> parts = generate(folder, header, 2000, &whole);
  const std::string out = folder / "merged.jsonl";
  const SweepOutcome merged = merge_sweep(parts, out);
  CHECK(merged.exit == ExitCode::expectation_failed);
  CHECK(merged.summary.all.failed == 62);
  REQUIRE(merged.summary.worst.size() == 5);
  CHECK(merged.summary.worst.front().point.index == 61 * 97 + 5);
  CHECK(test::contents(out) == whole);
  parts.erase(parts.begin() + 1233);
  parts.erase(parts.begin() + 2);
  const SweepOutcome gap = merge_sweep(parts, out + "2");
  REQUIRE(gap.errors.size() == 1);
  CHECK_THAT(gap.errors.front().message, Catch::Contains("lack 6 of 6000 points: 2, 1233, 2002, 3233, 4002, 5233; "
                                                         "shards 3, 1234 of 2000 are missing"));
}

TEST_CASE("A folder in the place of its parts is refused with their names") {
  const testing::TemporaryFolder folder, empty;
  const std::vector<std::string> parts = generate(folder, header_of(10), 2, nullptr);
  const SweepOutcome merged = merge_sweep({folder.path().string()}, folder / "merged.jsonl");
  CHECK(merged.exit == ExitCode::usage);
  REQUIRE(merged.errors.size() == 1);
  CHECK_THAT(merged.errors[0].message,
             Catch::EndsWith("it is a folder; give the files of the parts in it: " + parts[0] + " " + parts[1]));
  const SweepOutcome none = merge_sweep({empty.path().string()}, folder / "merged.jsonl");
  REQUIRE(none.errors.size() == 1);
  CHECK_THAT(none.errors[0].message, Catch::Contains("none of its files ends with .jsonl"));
}

TEST_CASE("Ten million points of ten thousand shards merge in half a gigabyte of memory", "[million]") {
  const testing::TemporaryFolder folder;
  const SweepHeader header = header_of(10'000'000);
  const std::vector<std::string> parts = generate(folder, header, 10'000, nullptr);
  const std::string out = folder / "merged.jsonl";
  SweepOutcome merged;
  test::report_merge(folder / ".", out, 10, [&] { merged = merge_sweep(parts, out); });
  CHECK(merged.errors.empty());
  CHECK(merged.summary.all.runs() == 10'000'000);
  CHECK(merged.summary.all.failed == 103'093);
}
