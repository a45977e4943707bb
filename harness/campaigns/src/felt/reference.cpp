#include "reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/text/rational.h"
#include "src/study/trace.h"

namespace evenstep::internal {
namespace {

/// Of a scene that is no tissue: instants per step of the scene, between which a cubic is drawn.
constexpr int kInstantsPerStep = 16;
/// Steps of a foreign reference per step of the finest cell.
constexpr int kFinerThanCells = 4;

Rate finer(Rate rate, int parts) { return reduced_rate(static_cast<__int128>(rate.num) * parts, rate.den); }

double length(const glm::dvec3& v) { return glm::length(v); }

/// What the extrapolation cannot see, because all of its runs share it: between two instants the tools of a solver move
/// straight, and an instant is a whole number of nanoseconds. Both as a distance of a tool from its motion, m.
double path_error_m(const Scenario& scenario, const ReferencePlan& plan) {
  double most_m = 0;
  for (const DeviceSpec& device : scenario.devices) {
    for (std::int64_t j = 0; tick_time(plan.rate, j) < plan.until; ++j) {
      const RealTime begin = tick_time(plan.rate, j), end = tick_time(plan.rate, j + 1);
      const RealTime middle{begin.ns + (end.ns - begin.ns) / 2};
      const glm::dvec3 a = position_m(device.motion, begin), b = position_m(device.motion, end);
      const double straight_m = length(position_m(device.motion, middle) - (a + b) / 2.0);
      most_m = std::max(most_m, straight_m + length(b - a) / static_cast<double>(end.ns - begin.ns));
    }
  }
  return most_m;
}

/// Force per metre of a tool: the greatest force over the greatest distance from where the motion begins.
double stiffness_felt(const Scenario& scenario, const EvenForces& forces) {
  double most_N = 0, most_m = 0;
  for (std::size_t j = 0; j < forces.read.size(); ++j) {
    for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool) {
      const ProgrammedMotion& motion = scenario.devices[tool].motion;
      most_N = std::max(most_N, length(forces.force_N[j][tool]));
      most_m = std::max(most_m, length(position_m(motion, forces.read[j]) - position_m(motion, RealTime{0})));
    }
  }
  return most_m > 0 ? most_N / most_m : 0;
}

/// The cubic through the instants a, b, c, d, at time t_s.
glm::dvec3 cubic_N(const EvenForces& forces, std::size_t tool, const std::array<std::size_t, 4>& nodes, double t_s) {
  glm::dvec3 sum(0);
  for (const std::size_t a : nodes) {
    double weight = 1;
    for (const std::size_t b : nodes) {
      if (b != a) weight *= (t_s - seconds(forces.read[b])) / (seconds(forces.read[a]) - seconds(forces.read[b]));
    }
    sum += forces.force_N[a][tool] * weight;
  }
  return sum;
}

/// The rms error of the cubics between the instants. Cubics through every second instant have 2^4 times this error, and it
/// shows at the instants left out. An eighth of that is on the safe side.
double cubic_error_N(const EvenForces& forces, std::size_t tools) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t j = 3; j + 3 < forces.read.size(); ++j) {
    for (std::size_t tool = 0; tool < tools; ++tool, ++count) {
      const double missed_N =
          length(cubic_N(forces, tool, {j - 3, j - 1, j + 1, j + 3}, seconds(forces.read[j])) - forces.force_N[j][tool]);
      sum += missed_N * missed_N;
    }
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1))) / 8;
}

EvenForces run_parts(const Scenario& scenario, const ReferencePlan& plan, int parts, const RunControl& control) {
  const std::unique_ptr<Solver> solver = make_reference_solver(scenario, plan, parts);
  EvenForces forces = step_evenly(*solver, scenario, plan.rate, {}, plan.until, control);
  for (const auto& force_N : forces.force_N) {
    if (std::all_of(force_N.begin(), force_N.end(), [](const glm::dvec3& f) { return std::isfinite(length(f)); })) continue;
    throw RunFailure("diverged", fmt::format("the reference ({}) is not finite", name_of(plan.method)),
                     "a motion that the scene can follow: see the scenario's hands");
  }
  return forces;
}

/// The forces at the instants of the plan, from steps of half the length.
EvenForces run_half_steps(const Scenario& scenario, ReferencePlan plan, const RunControl& control) {
  plan.rate = finer(plan.rate, 2);
  const EvenForces all = run_parts(scenario, plan, 1, control);
  EvenForces even;
  for (std::size_t j = 0; j < all.read.size(); j += 2) {
    even.read.push_back(all.read[j]);
    even.force_N.push_back(all.force_N[j]);
  }
  return even;
}

/// Replaces `coarse` by fine + (fine - coarse) / (2^order - 1).
void extrapolate(EvenForces& coarse, const EvenForces& fine, int order) {
  const double share = 1 / (std::pow(2.0, order) - 1);
  const std::size_t common = std::min(coarse.force_N.size(), fine.force_N.size());  // differ if interrupted
  for (std::size_t j = 0; j < common; ++j) {
    for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
      const glm::dvec3 f = fine.force_N[j][tool];
      coarse.force_N[j][tool] = f + (f - coarse.force_N[j][tool]) * share;
    }
  }
}

double rms_difference_N(const EvenForces& a, const EvenForces& b, std::size_t tools) {
  double sum = 0;
  const std::size_t common = std::min(a.force_N.size(), b.force_N.size());
  for (std::size_t j = 0; j < common; ++j) {
    for (std::size_t tool = 0; tool < tools; ++tool) {
      const glm::dvec3 d = a.force_N[j][tool] - b.force_N[j][tool];
      sum += glm::dot(d, d);
    }
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(common * tools, 1)));
}

}  // namespace

glm::dvec3 FeltReference::at_N(std::size_t tool, double t_s) const {
  const std::size_t count = forces.read.size();
  const auto after = std::upper_bound(forces.read.begin(), forces.read.end(), t_s,
                                      [](double t, RealTime read) { return t < seconds(read); });
  const auto i = static_cast<std::size_t>(after - forces.read.begin());
  if (i == 0) return forces.force_N.front()[tool];  // at rest
  if (count < 4) return played_N(forces, tool, t_s, Emission::linear);
  const std::size_t first = std::min(i >= 2 ? i - 2 : 0, count - 4);
  return cubic_N(forces, tool, {first, first + 1, first + 2, first + 3}, t_s);
}

ReferencePlan plan_reference(const Scenario& scenario, int finest) {
  ReferencePlan plan;
  plan.until = judged_span(scenario).end;
  plan.rate = finer(scenario.scene.step_rate, kInstantsPerStep);
  if (std::holds_alternative<ForeignScene>(scenario.scene.body))
    plan.rate = finer(scenario.scene.step_rate, std::max(kInstantsPerStep, kFinerThanCells * finest));
  if (!std::holds_alternative<TissueScene>(scenario.scene.body)) return plan;
  std::string reasons, remedy;
  for (const ReferenceMethod& candidate : kReferenceMethods) {
    try {
      plan.method = candidate.method;
      plan.order = candidate.order;
      plan.rate = finer(scenario.scene.step_rate, coarsest_substeps(scenario, candidate, finest));
      make_reference_solver(scenario, plan, 1);
      return plan;
    } catch (const SolverError& error) {
      reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", name_of(candidate.method), error.what());
      remedy = error.remedy();
    }
  }
  throw RunFailure("solver", "there is no reference: " + reasons, remedy);
}

std::unique_ptr<Solver> make_reference_solver(const Scenario& scenario, const ReferencePlan& plan, int parts) {
  Scenario finer_scene = scenario;
  finer_scene.scene.step_rate = plan.rate;
  return make_study_solver(finer_scene, {SolverKind::cpu_double, plan.method, 0, {parts, 1}}, false);
}

FeltReference solve_felt_reference(const Scenario& scenario, const ReferencePlan& plan, const RunControl& control) {
  const double began_s = process_cpu_seconds();
  FeltReference reference;
  reference.info.coarsest_step_s = period_s(plan.rate);
  reference.info.estimate_N = 0;
  try {
    EvenForces first = run_parts(scenario, plan, 1, control);
    if (plan.order > 0) {
      EvenForces second = run_parts(scenario, plan, 2, control);
      const EvenForces third = run_parts(scenario, plan, 4, control);
      extrapolate(first, second, plan.order);
      extrapolate(second, third, plan.order);
      reference.info.estimate_N = kReferenceSafety * rms_difference_N(first, second, scenario.devices.size());
      first = std::move(second);
    }
    // The order of a solver that the program brings along is unknown. If it is at least 1, the error that is left at half
    // the step is at most the change that halving makes.
    if (std::holds_alternative<ForeignScene>(scenario.scene.body)) {
      const EvenForces half = run_half_steps(scenario, plan, control);
      reference.info.estimate_N = kReferenceSafety * rms_difference_N(first, half, scenario.devices.size());
      first = half;
      reference.info.coarsest_step_s /= 2;
    }
    reference.forces = std::move(first);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
  reference.info.method = plan.order > 0 ? name_of(plan.method) : "none";
  reference.info.method_order = plan.order;
  reference.info.estimate_N += cubic_error_N(reference.forces, scenario.devices.size()) +
                               path_error_m(scenario, plan) * stiffness_felt(scenario, reference.forces);
  reference.info.cpu_s = process_cpu_seconds() - began_s;
  return reference;
}

}  // namespace evenstep::internal
