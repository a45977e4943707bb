// Merges of generated parts of a study: as many as no process can have open, and as many items as there may be.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "files.h"
#include "json_parts.h"
#include "merge_cost.h"

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

std::vector<std::string> generate(const test::Folder& folder, const internal::JsonParts& study, int shards) {
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

TEST_CASE("More parts of a study than a process may open merge to the lines of one and the missing ones are named") {
  const test::Folder folder;
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

TEST_CASE("Ten million cells of ten thousand shards merge in half a gigabyte of memory", "[million]") {
  const test::Folder folder;
  const internal::JsonParts study = generated(10'000'000);
  const std::vector<std::string> parts = generate(folder, study, 10'000);
  const std::string out = folder / "merged.jsonl";
  PartOutcome merged;
  test::report_merge(folder / ".", out, 10, [&] { merged = merge_parts(parts, out); });
  CHECK(merged.errors.empty());
  CHECK(merged.done == 10'000'000);
}
