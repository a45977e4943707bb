#pragma once
/// The runs of a felt-force study (evenstep/reports/felt_study_record.h): what the force of a device is at each of its
/// judged ticks, with an ideal device or with that of the scenario; and the forces of a method on even steps.

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_run.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {

/// From the end of the warm-up on; ticks at `end` are not judged.
struct JudgedSpan {
  RealTime from, end;
};
/// What the study judges: the span that the run judges, or as much of its begin as [study] duration says.
JudgedSpan judged_span(const Scenario& scenario);

/// What is between the strategy and the hand.
enum class DeviceModel {
  ideal,     ///< answers with the exact position whenever it is asked, and plays every force as it is
  sampling,  ///< answers with the exact position of its last tick, and plays every force as it is
  scenario   ///< the one of the scenario: guard, driver, reports, motors
};

struct FeltTick {
  RealTime at;
  glm::dvec3 force_N{0};
  bool saturated = false;
};
/// The judged ticks of each device.
using FeltTicks = std::vector<std::vector<FeltTick>>;

/// Runs one strategy up to the end of the judged span, with the scenario's scene, method and step. Throws RunFailure.
FeltTicks felt_ticks(const Scenario& scenario, const StrategyPlan& plan, DeviceModel model, const RunControl& control);

/// Per device, the mean age of the forces at its judged ticks, s: the time of the tick minus the time at which the hand was
/// where the force has it. To find it, the strategy runs on a spring with a hand that moves evenly, whose force tells the
/// time; so the age includes whatever the strategy does to the signal. Without [[device]] delay: a tick is when the motors
/// get a force.
std::vector<double> mean_ages_s(const Scenario& scenario, const StrategyPlan& plan, DeviceModel model,
                                const RunControl& control);

/// The forces of a solver that is stepped evenly, each with the time of the hand's position that it answers.
struct EvenForces {
  std::vector<RealTime> read;
  std::vector<std::array<glm::dvec3, kMaxTools>> force_N;
};
/// Steps of `rate` from the instant `-lead` on, up to one at `until` or later, that read the programmed motions themselves.
/// When it is interrupted, it ends early with what there is.
EvenForces step_evenly(Solver& solver, const Scenario& scenario, Rate rate, Duration lead, RealTime until,
                       const RunControl& control);
/// What a device plays of these forces when it answers the hand of `t_s`: a line between two neighbours, or the earlier one.
/// Before the first force and after the last, that force.
glm::dvec3 played_N(const EvenForces& forces, std::size_t tool, double t_s, Emission emission);

}  // namespace evenstep::internal
