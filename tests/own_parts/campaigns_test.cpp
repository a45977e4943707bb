// Many runs with parts that the program adds: study, sweep and shrink.
#include <unistd.h>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "evenstep/campaigns/felt_study.h"
#include "evenstep/campaigns/shrink.h"
#include "evenstep/campaigns/sweep.h"
#include "support.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;
using evenstep::testing::TemporaryFolder;

namespace {

const std::string kSine = R"(device.left.motion={ kind = "sine", amplitude = ["2 cm", "0 m", "0 m"], frequency = "2 Hz" })";

FeltStudyRecord study(const std::string& scene, const Registry& mine, const std::string& steps = "study.repeats=1") {
  const ReadResult scenario = read({scene, kSine, R"(run.strategies=["direct", "phase_locked"])", steps}, mine);
  INFO(text_of(scenario.error_or({})));
  REQUIRE(scenario);
  return run_felt_study(*scenario);
}

/// F = -k u with u' = (x - u) / T, so what is felt lags behind the tool. Explicit Euler, order 1.
struct Lag : ForeignSolver {
  ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    u_m += (x_m - u_m) * (step_s / 20e-3);
    x_m = positions_m[0];
    return {{u_m * -200.0}};
  }
  glm::dvec3 u_m{0}, x_m{0};
};

/// Copies the scenarios of this test folder.
void copy_scenarios(const TemporaryFolder& folder) {
  for (const char* name : {"own_parts.toml", "too_late.toml"})
    std::filesystem::copy_file(std::filesystem::path(EVENSTEP_SOURCE_DIR) / "tests/own_parts" / name, folder / name);
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("The study of the felt force with a spring of the program's is that with evenstep's own") {
  const FeltStudyRecord mine = study(kMySpring, registry(), R"(study.step_sizes=["450 Hz"])"),
                        own = study("scene.kind=\"spring\"", {});
  REQUIRE(mine.points.size() == own.points.size());
  for (std::size_t i = 0; i < own.points.size(); ++i) {
    CHECK(mine.points[i].total.rms_N == Approx(own.points[i].total.rms_N).epsilon(1e-6));
    CHECK(mine.points[i].remap.rms_N == Approx(own.points[i].remap.rms_N).epsilon(1e-6));
  }
}

TEST_CASE("The reference of a foreign solver of order 1 is as near to its equation as it says") {
  Registry mine;
  mine.add_solver("lag", [](const SolverRequest&) { return std::make_unique<Lag>(); });
  const FeltStudyRecord record = study(scene_of("lag"), mine);
  // The error that the study states is twice the change that half the step makes. Steps of 1/450 s are 16 times as long as
  // those that it compares, so their error is 16 times as large. The study must see it as theirs.
  CHECK(record.reference.estimate_N > 0);
  CHECK(record.reference.estimate_N < 0.02 * record.reference.scale_N);
  for (const FeltPoint& point : record.points) CHECK(point.discretisation.rms_N > 3 * record.reference.estimate_N);
}

TEST_CASE("A study cuts the steps of a solver of the program, whose error falls with them") {
  Registry mine;
  mine.add_solver("lag", [](const SolverRequest&) { return std::make_unique<Lag>(); });
  const FeltStudyRecord record = study(scene_of("lag"), mine, R"(study.step_sizes=["450 Hz", "900 Hz", "1800 Hz"])");
  REQUIRE(record.points.size() == 6);  // three for each of two strategies
  for (const std::size_t first : {0, 3}) {
    for (std::size_t i = first; i < first + 2; ++i) {
      CHECK(record.points[i + 1].substep_s == Approx(record.points[i].substep_s / 2));
      // Explicit Euler has order 1. Less than half of the error is left because the straight paths of the tools err the
      // other way.
      CHECK(record.points[i + 1].discretisation.rms_N < 0.6 * record.points[i].discretisation.rms_N);
    }
    CHECK(record.points[first].method == "own");
    CHECK(record.points[first].solver == "lag");
  }
  CHECK_THAT(errors_of({scene_of("lag"), R"(study.methods=["rk4"])"}, mine), Contains("has no such thing to choose"));
}

TEST_CASE("A sweep over the options of a solver writes the same bytes on one thread and on two") {
  const TemporaryFolder work;
  copy_scenarios(work);
  SweepOptions options;
  options.registry = registry();
  std::array<std::string, 2> lines;
  for (const int threads : {1, 2}) {
    options.threads = threads;
    options.folder = work / (threads == 1 ? "one" : "two");
    const SweepOutcome outcome = run_sweep(work / ("own_parts.toml"), options);
    INFO(text_of(outcome.errors) << outcome.failure);
    CHECK(outcome.exit == ExitCode::pass);
    CHECK(outcome.summary.all.runs() == 4);
    lines[static_cast<std::size_t>(threads - 1)] = bytes_of(outcome.file);
  }
  CHECK(lines[0] == lines[1]);
  std::vector<std::string> traces;
  const std::string key = "\"trace\":\"";
  for (std::size_t at = 0; (at = lines[0].find(key, at)) != std::string::npos; at += key.size())
    traces.push_back(lines[0].substr(at + key.size(), 16));
  REQUIRE(traces.size() == 4);
  CHECK(traces[0] != traces[2]);                                         // another stiffness
  CHECK_FALSE(run_sweep(work / ("own_parts.toml"), {}).errors.empty());  // without the parts
}

TEST_CASE("A failing run over a timing source shrinks to a scenario with a recording and the program's other parts") {
  const TemporaryFolder work;
  copy_scenarios(work);
  ShrinkOptions options;
  options.registry = registry();
  options.folder = work / ("shrunk");
  options.max_runs = 60;
  const ShrinkOutcome outcome = shrink_scenario(work / ("too_late.toml"), options);
  INFO(text_of(outcome.errors) << outcome.failure);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.perturbations.size() < outcome.perturbations_before);
  const std::string shrunk = bytes_of(outcome.file);
  CHECK_THAT(shrunk, Contains("my-arm") && Contains("my-spring") && Contains("trace") && !Contains("my-gpu"));
}
