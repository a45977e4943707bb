#pragma once
// Scenarios for tests: shipped files or small ones written here, never copies of shipped ones.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "catch.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/run.h"
#include "evenstep/harness/sizing.h"

namespace evenstep::test {

inline std::string shipped(const std::string& name) { return std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/" + name; }

inline Scenario read(const std::string& name, const std::vector<std::string>& set = {}) {
  const ReadResult result = read_scenario(shipped(name), {set, std::nullopt});
  for (const Diagnostic& error : result.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(result);
  return *result;
}

inline RunRecord run_all(const Scenario& scenario, RunOptions options = {}) {
  const RunOutcome outcome = run_scenario(scenario, options);
  for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
  INFO(outcome.failure);
  REQUIRE(outcome.errors.empty());
  REQUIRE(outcome.failure.empty());
  return outcome.record;
}

inline std::vector<MappedStep> steps_of(const Scenario& scenario, const StrategyPlan& plan) {
  std::vector<MappedStep> all;
  each_run_step(scenario, plan, [&](std::span<const MappedStep> some) { all.insert(all.end(), some.begin(), some.end()); });
  return all;
}

inline double metric_of(const RunOutcome& outcome, const std::string& signal, const std::string& name) {
  INFO(signal << " " << name << " " << outcome.failure);
  REQUIRE(outcome.metrics.count(signal) == 1);
  REQUIRE(outcome.metrics.at(signal).count(name) == 1);
  return outcome.metrics.at(signal).at(name);
}

inline const StrategyRecord& strategy(const RunRecord& run, std::string_view name) {
  for (const StrategyRecord& record : run.strategies) {
    if (record.name == name) return record;
  }
  FAIL("no strategy " << name);
  throw 0;
}

/// A block small enough for many runs: 8 x 7 x 9 cut to 490 particles, two devices, everything else as in the paper.
inline std::vector<std::string> small_tissue(const std::string& solver) {
  return {"scene.solver=\"" + solver + "\"",
          "scene.lattice=[8, 7, 9]",
          "scene.particles=490",
          "run.duration=\"0.5 s\"",
          "device.left.grab={ center = [\"10 mm\", \"15 mm\", \"40 mm\"], radius = \"6 mm\" }",
          "device.right.grab={ center = [\"25 mm\", \"15 mm\", \"40 mm\"], radius = \"6 mm\" }"};
}

}  // namespace evenstep::test
