#include "foreign_needs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {

std::vector<Diagnostic> lacking_for_expectations(const Scenario& scenario) {
  const auto* foreign = std::get_if<ForeignScene>(&scenario.scene.body);
  if (!foreign || (!scenario.scene.needs_energy && scenario.scene.local_model == LocalModel::none)) return {};
  std::vector<Diagnostic> errors;
  const auto error = [&](const Place& place, std::string message) {
    errors.push_back({place.file, place.line, place.column, std::move(message)});
  };
  try {
    const std::vector<std::string> lacks = make_solver(scenario.solver, scenario.scene)->info().lacks;
    if (std::find(lacks.begin(), lacks.end(), "energy") == lacks.end()) return {};
    for (const Expectation& expectation : scenario.expectations) {
      if (!expectation.metric.starts_with("energy_") || expectation.signal.starts_with("closed_loop.")) continue;
      error(expectation.written.metric,
            fmt::format("'{}' has no value here: the solver '{}' has no energy (it lacks {}); remove the expectation, or "
                        "let the solver tell its energy",
                        expectation.metric, foreign->name, fmt::join(lacks, ", ")));
    }
  } catch (const SolverError& refusal) {
    error(scenario.scene_place, fmt::format("{}; {}", refusal.what(), refusal.remedy()));
  }
  return errors;
}

}  // namespace evenstep::internal
