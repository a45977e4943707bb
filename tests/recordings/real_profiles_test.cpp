// Real files from profilers of others.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "catch.h"
#include "evenstep/recordings/recording.h"
#include "real_files.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

Profile read(const std::string& path) {
  const ProfileResult profile = read_profile(path);
  INFO((profile ? "" : text(profile.error().front())));
  REQUIRE(profile);
  return *profile;
}

using Named = std::tuple<std::int64_t, std::int64_t, std::string>;

std::vector<Named> kernels_of(const Profile& profile) {
  std::vector<Named> all;
  for (const ProfileInterval& one : profile.intervals) {
    const std::string& name = profile.names[one.name].text;
    if (name.starts_with("par_")) all.emplace_back(one.begin.ns, one.end.ns, name);
  }
  std::sort(all.begin(), all.end());
  return all;
}

using Cells = std::map<std::string, std::string>;

/// The rows of a CSV without quotes, by the names of its header.
std::vector<Cells> rows_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> names;
  std::vector<Cells> rows;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream cells(line);
    std::size_t n = 0;
    if (!names.empty()) rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) {
      if (rows.empty()) names.push_back(cell);
      if (!rows.empty() && n < names.size()) rows.back()[names[n++]] = cell;
    }
  }
  return rows;
}

}  // namespace

TEST_CASE("Nsight's SQLite has the kernels of the Enter and Leave rows of the same capture, each to the nanosecond",
          "[real]") {
  const auto database = real_file("nsys-cloverleaf-a100.sqlite"), csv = real_file("nsys-cloverleaf-a100-gputrace.csv");
  if (!database || !csv) return;
  const Profile profile = read(*database);
  CHECK(profile.format == "Nsight Systems SQLite, schema 3.13.2");
  const std::vector<Named> kernels = kernels_of(profile);
  CHECK(kernels.size() == 1312);
  CHECK(kernels == kernels_of(read(*csv)));
}

TEST_CASE("CloverLeaf on an A100: its reduce kernel as the visualization gives the 12 gaps of its 31 Hz cycle", "[real]") {
  const auto database = real_file("nsys-cloverleaf-a100.sqlite");
  if (!database) return;
  const Profile profile = read(*database);
  Roles roles;
  roles.visualization = "par_reduce";
  roles.step = "par_ranged";
  const AssignedRolesResult assigned = assign_roles(profile, roles);
  REQUIRE(assigned);
  REQUIRE(assigned->segments.size() == 12);
  // Gaps between the begins of the reduce kernel, measured in the file by hand, in units of 10 us.
  constexpr std::int64_t kGaps[] = {511, 3208, 3251, 3231, 3249, 3259, 3245, 3243, 3278, 3208, 3001, 311};
  for (std::size_t i = 0; i < 11; ++i) {
    const Duration gap = assigned->segments[i + 1].begin - assigned->segments[i].begin;
    CHECK(std::abs(gap.ns - kGaps[i] * 10'000) <= 5'000);
  }
  const AssignedRolesResult guessed = assign_roles(profile, {});
  REQUIRE(guessed);
  CHECK(guessed->roles.visualization == "^par_reduce_kernel$");
  CHECK(guessed->segments.size() == 12);
}

TEST_CASE("PresentMon's default and v2 metrics of one capture begin alike on all rows, v1 on half of them", "[real]") {
  const auto plain = real_file("presentmon-gold-0.csv"), v1 = real_file("presentmon-gold-0_v1.csv"),
             v2 = real_file("presentmon-gold-0_v2.csv");
  if (!plain || !v1 || !v2) return;
  const auto begins = [](const Profile& profile) {
    std::multiset<std::pair<std::string, std::int64_t>> all;
    for (const ProfileInterval& one : profile.intervals) {
      // The address of a swap chain is written with and without leading zeros.
      std::string source = profile.sources[profile.source_of(one)];
      all.insert({source.substr(0, source.find(", swap")), one.begin.ns});
    }
    return all;
  };
  const auto of_plain = begins(read(*plain)), of_v1 = begins(read(*v1)), of_v2 = begins(read(*v2));
  CHECK(of_plain.size() == 357);
  std::size_t same_v1 = 0;
  for (const auto& one : of_v1) same_v1 += of_plain.contains(one);
  CHECK(of_plain == of_v2);
  CHECK(same_v1 == 180);
}

TEST_CASE("Where PresentMon's v1 begins another time, the default has a latency of 0: the GPU began before the CPU did",
          "[real]") {
  const auto plain = real_file("presentmon-gold-0.csv"), v1 = real_file("presentmon-gold-0_v1.csv");
  if (!plain || !v1) return;
  const auto of_present = [](const Cells& row, const char* at) { return row.at("ProcessID") + " " + row.at(at); };
  std::map<std::string, Cells> of_v1;
  for (const Cells& row : rows_of(*v1)) of_v1.emplace(of_present(row, "QPCTime"), row);
  std::size_t equal = 0, before_cpu = 0, without_begin = 0, others = 0;
  for (const Cells& row : rows_of(*plain)) {
    const Cells& other = of_v1.at(of_present(row, "TimeInQPC"));
    const auto at_ms = [](const Cells& cells, const char* name) { return std::stod(cells.at(name)); };
    const double cpu_ms = at_ms(row, "CPUStartQPC") * 1e-4, latency_ms = at_ms(row, "MsGPULatency");
    const double until_ms = at_ms(other, "msUntilRenderStart");
    const double begin_ms = at_ms(other, "QPCTime") * 1e-4 + until_ms;
    const bool same = std::abs(begin_ms - (cpu_ms + latency_ms)) < 0.5e-4;  // half a tick
    ++(same                                   ? equal
       : latency_ms == 0 && until_ms == 0     ? without_begin
       : latency_ms == 0 && begin_ms < cpu_ms ? before_cpu
                                              : others);
  }
  CHECK(equal == 180);
  CHECK(before_cpu == 176);
  CHECK(without_begin == 1);  // v1 has no begin of the GPU's work
  CHECK(others == 0);
}

TEST_CASE("PresentMon's capture of ten processes asks which, and one of them gives its segments", "[real]") {
  const auto plain = real_file("presentmon-gold-0.csv");
  if (!plain) return;
  const Profile profile = read(*plain);
  const AssignedRolesResult all = assign_roles(profile, {});
  REQUIRE_FALSE(all);
  CHECK_THAT(text(all.error().front()), Contains("--process REGEX") && Contains("dwm.exe, process 1268"));
  Roles roles;
  roles.visualization = ".";
  roles.process = "dwm";
  const AssignedRolesResult one = assign_roles(profile, roles);
  REQUIRE(one);
  CHECK(one->segments.size() > 150);
}

TEST_CASE("A tool's header before PresentMon's rows is skipped", "[real]") {
  const auto file = real_file("presentmon-capframex-header.csv");
  if (!file) return;
  const Profile profile = read(*file);
  CHECK(profile.intervals.size() == 7285);
}

TEST_CASE("PyTorch's profile, gzipped, has its kernels and its steps as segments", "[real]") {
  const auto file = real_file("chrome-pytorch-ns.json.gz");
  if (!file) return;
  const Profile profile = read(*file);
  std::size_t kernels = 0;
  for (const ProfileInterval& one : profile.intervals) kernels += profile.names[one.name].category == "kernel";
  CHECK(kernels == 4350);
  Roles roles;
  roles.segment = "^ProfilerStep#";
  roles.step = "kernel:.";
  const AssignedRolesResult assigned = assign_roles(profile, roles);
  INFO((assigned ? "" : text(assigned.error().front())));
  REQUIRE(assigned);
  CHECK(assigned->segments.size() == 5);
}

TEST_CASE("Chrome's own traces are read: an array with X, B and E, and fractions of a microsecond", "[real]") {
  const auto events = real_file("chrome-x_event_trace.json"), fractions = real_file("chrome-nanoseconds.json");
  if (!events || !fractions) return;
  // 2,799 complete events and 442 pairs.
  const Profile profile = read(*events);
  std::int64_t left_out = 0;
  for (const LeftOut& left : profile.left_out) left_out += left.count;
  CHECK(static_cast<std::int64_t>(profile.intervals.size()) + left_out == 2799 + 442);
  const Profile fine = read(*fractions);
  REQUIRE(fine.intervals.size() == 8);
  CHECK(fine.intervals.back().begin.ns == 3017);
  CHECK(fine.intervals.back().end.ns == 3021);
}

TEST_CASE("Nsight's CSV of NVTX ranges is read", "[real]") {
  const auto file = real_file("nsys-nbody-nvtx-trace.csv");
  if (!file) return;
  Roles roles;
  roles.step = "^computeNBody";
  const auto recording = read_recording(*file, {roles, {}});
  REQUIRE(recording);
  CHECK(recording->size() == 1);
  CHECK(recording->front().steps.size() >= 10);
}
