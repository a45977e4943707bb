// Merges of generated parts of a study, with more parts than a process can have open, and with as many items as allowed.
#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "catch.h"
#include "files.h"
#include "merge_cost.h"
#include "src/shards/json_parts.h"

using namespace evenstep;

namespace {

internal::JsonParts generated(std::int64_t items) {
  return {{"study", "generated", "generated.toml", {}, "0123456789abcdef"}, items, {{"kind", "state"}}, {}};
}

std::string line_of(std::int64_t index) {
  const double value = 1e-9 * static_cast<double>(index);
  return internal::item_line(index,
                             {{"cell", {{"solver", "cpu"}, {"method", "rk4"}, {"substep_s", 0.001}, {"error", value}}},
                              {"measured", {{"cpu_s_per_s", {value, value, value}}, {"machine", "generated"}}}});
}

std::vector<std::string> generate(const testing::TemporaryFolder& folder, const internal::JsonParts& study, int shards) {
  std::vector<std::string> parts;
  for (int shard = 1; shard <= shards; ++shard) {
    parts.push_back(folder / fmt::format("study-{}-of-{}.jsonl", shard, shards));
    std::ofstream part(parts.back(), std::ios::binary);
    part << study.header_line({shard, shards}) << '\n';
    for (std::int64_t index = shard - 1; index < study.items(); index += shards) part << line_of(index) << '\n';
  }
  return parts;
}

}  // namespace

TEST_CASE("More parts of a study than a process may open merge to the lines of one and the missing ones are named",
          "[sweep]") {
  const testing::TemporaryFolder folder;
  const internal::JsonParts study = generated(6000);
  std::vector<std::string> parts = generate(folder, study, 2000);
  std::string whole = study.header_line({}) + '\n';
  for (std::int64_t index = 0; index < study.items(); ++index) whole += line_of(index) + '\n';
  const std::string out = folder / "merged.jsonl";
  const PartOutcome merged = merge_parts(parts, out);
  CHECK(merged.exit == ExitCode::pass);
  CHECK(merged.items == 6000);
  CHECK(test::contents(out) == whole);
  parts.erase(parts.begin() + 1233);
  parts.erase(parts.begin() + 2);
  const PartOutcome gap = merge_parts(parts, out + "2");
  REQUIRE(gap.errors.size() == 1);
  CHECK_THAT(gap.errors.front().message, Catch::Contains("lack 6 of 6000 points: 2, 1233, 2002, 3233, 4002, 5233; "
                                                         "shards 3, 1234 of 2000 are missing"));
}

TEST_CASE("A merge replaces none of its parts and nothing that is no file") {
  const testing::TemporaryFolder folder;
  const std::vector<std::string> parts = generate(folder, generated(9), 3);
  const std::string second = test::contents(parts[1]);
  std::filesystem::create_symlink(parts[1], folder / "link.jsonl");
  for (const std::string& out : {parts[1], folder / "./study-2-of-3.jsonl", folder / "link.jsonl"}) {
    const PartOutcome onto_a_part = merge_parts(parts, out);
    CHECK(onto_a_part.exit == ExitCode::usage);
    REQUIRE(onto_a_part.errors.size() == 1);
    CHECK_THAT(onto_a_part.errors.front().message, Catch::Contains("is one of the parts"));
    CHECK(test::contents(parts[1]) == second);
  }
  const std::string pipe = folder / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const PartOutcome onto_a_pipe = merge_parts(parts, pipe);
  CHECK(onto_a_pipe.exit == ExitCode::usage);
  REQUIRE(onto_a_pipe.errors.size() == 1);
  CHECK_THAT(onto_a_pipe.errors.front().message, Catch::Contains("is no file"));
  CHECK(std::filesystem::is_fifo(pipe));
  CHECK(merge_parts(parts, folder / "merged.jsonl").exit == ExitCode::pass);
  CHECK(merge_parts(parts, folder / "merged.jsonl").exit == ExitCode::pass);  // a merge may be repeated
}

TEST_CASE("Ten million cells of ten thousand shards merge in half a gigabyte of memory", "[million]") {
  const testing::TemporaryFolder folder;
  const internal::JsonParts study = generated(10'000'000);
  const std::vector<std::string> parts = generate(folder, study, 10'000);
  const std::string out = folder / "merged.jsonl";
  PartOutcome merged;
  test::report_merge(folder / ".", out, 10, [&] { merged = merge_parts(parts, out); });
  CHECK(merged.errors.empty());
  CHECK(merged.done == 10'000'000);
}
