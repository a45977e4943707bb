#pragma once
/// The saturation that the motion of a scenario will cause, computed without a run from the programmed positions at the
/// ticks of each device and the force that the scene has there without delay. The force that is really sent comes later, by
/// its latency. Nothing is foretold for a hand that feels the force, for the forces of a tissue (whose steps are expensive),
/// or for what only the bursts of a strategy cause (`direct` may need more slew), nor for what comes after the first ten
/// million ticks of a device.

#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/saturation.h"

namespace evenstep {

struct ForetoldSaturation {
  std::string device;
  SaturationCause cause = SaturationCause::clamp;
  RealTime first;         ///< first judged tick at which the limit is met
  double limit = 0;       ///< in SI units: N, N/s, m/s, m
  bool expected = false;  ///< the device expects saturation
};
/// By device and cause; only limits that are met.
std::vector<ForetoldSaturation> foretell_saturation(const Scenario& scenario);
/// "left: clamp at 100 N, first at 5.1 s"
std::string text(const ForetoldSaturation& foretold);

/// The expectations that cannot be judged because of what is foretold: they are about the shape of a signal that will be
/// saturated before the run ends.
std::vector<Diagnostic> foretold_errors(const Scenario& scenario, const std::vector<StrategyPlan>& plans,
                                        const std::vector<ForetoldSaturation>& foretold);

}  // namespace evenstep
