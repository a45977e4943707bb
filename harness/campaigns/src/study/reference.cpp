// The reference of a study: Richardson extrapolation in double.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/reports/run_failure.h"
#include "evenstep/sim/stability.h"
#include "trace.h"

namespace evenstep::internal {
namespace {

StudyTrace run_reference(const Scenario& scenario, const StudyPlan& plan, Method method, int substeps,
                         const std::atomic<bool>* interrupted) {
  const StudyStep step{substeps, 1};
  const auto solver = make_study_solver(scenario, {SolverKind::cpu_double, method, 0, step}, true);
  StudyTrace trace = trace_of(*solver, scenario, plan, step, interrupted);
  if (trace.first_bad_sample >= 0) {
    throw RunFailure("diverged", fmt::format("the reference ({}, {} substeps) is not finite", name_of(method), substeps),
                     "a motion that the tissue can follow: see the scenario's hands");
  }
  return trace;
}

/// Replaces `coarse` by fine + (fine - coarse) / (2^order - 1).
void extrapolate(StudyTrace& coarse, const StudyTrace& fine, int order) {
  const double share = 1 / (std::pow(2.0, order) - 1);
  const auto mix = [&](auto& c, const auto& f) { c = f + (f - c) * share; };
  for (std::size_t s = 0; s < coarse.energy_J.size(); ++s) {
    for (std::size_t p = 0; p < coarse.displacement_m[s].size(); ++p)
      mix(coarse.displacement_m[s][p], fine.displacement_m[s][p]);
    for (std::size_t tool = 0; tool < coarse.force_N[s].size(); ++tool) mix(coarse.force_N[s][tool], fine.force_N[s][tool]);
    mix(coarse.energy_J[s], fine.energy_J[s]);
  }
}

StudyReferenceRun extrapolated(const Scenario& scenario, const StudyPlan& plan, const ReferenceMethod& candidate,
                               int substeps, const std::atomic<bool>* interrupted) {
  StudyTrace first = run_reference(scenario, plan, candidate.method, substeps, interrupted);
  StudyTrace second = run_reference(scenario, plan, candidate.method, substeps * 2, interrupted);
  const StudyTrace third = run_reference(scenario, plan, candidate.method, substeps * 4, interrupted);
  const StudyValues step = rms(first, &second), next_step = rms(second, &third);
  extrapolate(first, second, candidate.order);
  extrapolate(second, third, candidate.order);
  StudyReference info{name_of(candidate.method), candidate.order, period_s(scenario.scene.step_rate) / substeps};
  info.scale = rms(second, nullptr);
  info.estimate = error_of(first, second, info.scale);
  for (const StudyQuantity q : kStudyQuantities) info.estimate[q] *= kReferenceSafety;
  for (const StudyQuantity q : kStudyQuantities) {
    if (step[q] > 0 && next_step[q] > 0) info.order[q] = std::log2(step[q] / next_step[q]);
  }
  return {std::move(second), info};
}

}  // namespace

int coarsest_substeps(const Scenario& scenario, const ReferenceMethod& candidate, int finest_cell) {
  TissueScene tissue = std::get<TissueScene>(scenario.scene.body);
  tissue.method = candidate.method;
  const double needed = std::ceil(period_s(scenario.scene.step_rate) * candidate.limit_parts / step_limit(tissue).step_s);
  if (needed * 4 > kMaxSubsteps) {
    throw RunFailure("limit",
                     fmt::format("a reference needs {:g} substeps per step of the scene, at most {} are possible",
                                 needed * 4, kMaxSubsteps),
                     "a shorter [scene] step_size, less stiffness or more mass");
  }
  return std::min(std::max(static_cast<int>(needed), finest_cell), kMaxSubsteps / 4);
}

StudyReferenceRun solve_reference(const Scenario& scenario, const StudyPlan& plan, int finest,
                                  const std::atomic<bool>* interrupted) {
  std::string reasons, remedy;
  for (const ReferenceMethod& candidate : kReferenceMethods) {
    try {
      return extrapolated(scenario, plan, candidate, coarsest_substeps(scenario, candidate, finest), interrupted);
    } catch (const SolverError& error) {
      reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", name_of(candidate.method), error.what());
      remedy = error.remedy();
    }
  }
  throw RunFailure("solver", "there is no reference: " + reasons, remedy);
}

}  // namespace evenstep::internal
