// The reference of the felt force, and the file in which it is kept.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>

#include "evenstep/campaigns/felt_study.h"
#include "evenstep/reports/run_failure.h"
#include "src/felt/reference.h"
#include "study_scenes.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::test;
using Catch::Contains;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

fs::path only_file(const TemporaryFolder& folder) {
  REQUIRE(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
  return fs::directory_iterator(folder.path())->path();
}

Scenario small_block(const std::vector<std::string>& set = {}) {
  std::vector<std::string> all{"study.error=felt-force",
                               "study.duration=\"20 ms\"",
                               "run.duration=\"60 ms\"",
                               "run.warmup=\"32 ms\"",
                               "study.methods=[\"symplectic-euler\"]",
                               "study.solvers=[\"cpu-double\"]",
                               "study.step_sizes=[\"0.5 ms\"]"};
  all.insert(all.end(), set.begin(), set.end());
  return small_study(all);
}

struct Told {
  FeltStudyRecord study;
  std::string lines;
};
Told study_with(const fs::path& cache, const std::vector<std::string>& set = {}) {
  Told told;
  FeltStudyControl control;
  control.cache_folder = cache.string();
  control.announce = [&](const std::string& line) { told.lines += line + "\n"; };
  told.study = run_felt_study(small_block(set), control);
  return told;
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void put(const fs::path& file, const std::string& content) { std::ofstream(file, std::ios::binary) << content; }

}  // namespace

TEST_CASE("A reference is computed once: the next study reads it, with the same errors bit for bit") {
  const TemporaryFolder folder;
  const Told first = study_with(folder.path()), again = study_with(folder.path());
  CHECK_FALSE(first.study.reference.stored);
  CHECK_THAT(first.lines, Contains("reference   ") && !Contains("stored"));
  CHECK(again.study.reference.stored);
  CHECK(again.study.reference.file == only_file(folder).string());
  CHECK_THAT(again.lines, Contains("reference   stored: "));
  CHECK(again.study.reference.estimate_N == first.study.reference.estimate_N);
  CHECK(again.study.reference.cpu_s == first.study.reference.cpu_s);  // what the stored computation took
  REQUIRE(again.study.points.size() == first.study.points.size());
  for (std::size_t i = 0; i < first.study.points.size(); ++i)
    CHECK(again.study.points[i].total.rms_N == first.study.points[i].total.rms_N);
}

TEST_CASE("A stored reference that is damaged anywhere is noticed, said, and computed again") {
  const TemporaryFolder folder;
  const Told first = study_with(folder.path());
  const fs::path file = only_file(folder);
  const std::string good = content_of(file);
  for (const std::size_t at : {std::size_t{0}, std::size_t{40}, good.size() / 2, good.size() - 3}) {
    std::string bad = good;
    bad[at] = bad[at] == '7' ? '8' : '7';
    put(file, bad);
    const Told again = study_with(folder.path());
    INFO("byte " << at);
    CHECK_THAT(again.lines, Contains("is not used: its checksum is wrong; it is computed again"));
    CHECK_FALSE(again.study.reference.stored);
    CHECK(again.study.points[0].total.rms_N == first.study.points[0].total.rms_N);
    CHECK(study_with(folder.path()).study.reference.stored);  // the file has been replaced by a good one
  }
  put(file, good.substr(0, good.size() / 2));
  CHECK_THAT(study_with(folder.path()).lines, Contains("its checksum is wrong"));
  put(file, "");
  CHECK_THAT(study_with(folder.path()).lines, Contains("its checksum is wrong"));
}

TEST_CASE("A reference is not taken for that of another scene, motion, span or version") {
  const Scenario scenario = small_block();
  const ReferencePlan plan = plan_reference(scenario, 2);
  const std::string key = reference_key(scenario, plan);
  const auto differs = [&](const std::vector<std::string>& set) {
    const Scenario other = small_block(set);
    return reference_key(other, plan_reference(other, 2)) != key;
  };
  CHECK_FALSE(differs({}));
  CHECK_FALSE(differs({"scene.method=rk4"}));  // the reference has its own method
  CHECK_FALSE(differs({"run.seed=7"}));        // and no timing
  for (const char* set :
       {"scene.stiffness=\"21 N/m\"", "scene.mass=\"0.11 g\"", "scene.spacing=\"6 mm\"", "scene.lattice=[5, 5, 6]",
        "scene.axial_damping=\"5 mN s/m\"", "scene.damping=\"1e-4 N s/m\"", "scene.fixed=left",
        "scene.gravity=[\"0 m/s2\", \"0 m/s2\", \"-1 m/s2\"]", "device.left.grab.radius=\"7.5 mm\"",
        "device.left.motion.velocity=[\"0.1 m/s\", \"0 m/s\", \"0.06 m/s\"]", "study.duration=\"21 ms\""}) {
    INFO(set);
    CHECK(differs({set}));
  }
  CHECK_THAT(key, Contains("version "));
  // The file of this name may have another key: two keys may have the same digest, or somebody may have renamed a file.
  const TemporaryFolder folder;
  FeltReference reference;
  reference.forces.read = {RealTime{0}};
  reference.forces.force_N.resize(1);
  const std::string file = reference_file(folder.path().string(), key);
  REQUIRE(write_reference(file, key + "other\n", reference).empty());
  std::string objection;
  FeltReference read;
  // This key is the begin of the other one, so the rest of the other key must not be read as numbers.
  CHECK_FALSE(read_reference(file, key, read, objection));
  CHECK_FALSE(objection.empty());
  objection.clear();
  REQUIRE(write_reference(file, "other\n", reference).empty());
  CHECK_FALSE(read_reference(file, key, read, objection));
  CHECK_THAT(objection, Contains("another scene, motion or version"));
}

TEST_CASE("Where a reference cannot be kept the study goes on, and says so") {
  const TemporaryFolder folder;
  const Told told = study_with(folder.write("cache", "a file where the folder would be"));
  CHECK_THAT(told.lines, Contains("the reference could not be kept"));
  CHECK(told.study.points[0].state == StudyCell::State::measured);
}

TEST_CASE("The reference of the felt force agrees with one of a quarter of its steps to within the error that it states",
          "[sweep]") {
  const Scenario scenario = small_block();
  const ReferencePlan coarse_plan = plan_reference(scenario, 1), fine_plan = plan_reference(scenario, 64);
  REQUIRE(period_s(fine_plan.rate) < period_s(coarse_plan.rate) / 2);
  const FeltReference coarse = solve_felt_reference(scenario, coarse_plan, {}),
                      fine = solve_felt_reference(scenario, fine_plan, {});
  double sum = 0;
  int count = 0;
  for (double t = 0.032; t < 0.052; t += 0.00037, ++count) {
    const glm::dvec3 d = coarse.at_N(0, t) - fine.at_N(0, t);
    sum += glm::dot(d, d);
  }
  CHECK(std::sqrt(sum / count) <= coarse.info.estimate_N);
  CHECK(fine.info.estimate_N <= coarse.info.estimate_N);
  CHECK(glm::length(fine.at_N(0, 0.05)) > 1e4 * coarse.info.estimate_N);  // or there is nothing to compare
}

TEST_CASE("Between its instants the reference is a cubic, and before the first it is at rest") {
  FeltReference reference;
  const auto cubic = [](double t) { return 1 + t * (2 + t * (3 + t * 4)); };
  for (int j = 0; j < 8; ++j) {
    reference.forces.read.push_back({j * 100'000'000});
    reference.forces.force_N.push_back({glm::dvec3(cubic(0.1 * j), 0, 0), glm::dvec3(0)});
  }
  for (double t = 0; t < 0.7; t += 0.013) CHECK(reference.at_N(0, t).x == Approx(cubic(t)).epsilon(1e-12));
  CHECK(reference.at_N(0, -0.5).x == 1);
}
