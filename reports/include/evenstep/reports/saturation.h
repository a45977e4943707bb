#pragma once
/// Which samples of a signal are saturated: a limit made them other than the hand and the scene did. A force at its clamp is
/// perfectly smooth whatever drives it, so the shape of a saturated signal says nothing (docs/reference/metrics.md).
///
/// A force sample is saturated if the guard or the device limited it, or if a step whose force it may be made of was given a
/// saturated position. An interaction sample is saturated if a sample of the device that it is made of was at the end of the
/// device's range. `ideal` reads the programmed motion itself, so its interaction never is.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/reports/run_record.h"

namespace evenstep {

/// "clamp", "slew", "cut", "non_finite", "device_force", "device_position"
std::string_view name_of(SaturationCause cause);

/// The judged samples of a signal that met a limit.
struct Saturation {
  struct Part {
    SaturationCause cause = SaturationCause::clamp;
    RealTime first;  ///< time of its first sample: of a step its begin, of a tick when it was sent
    std::int64_t count = 0;
  };
  std::int64_t judged = 0;     ///< samples judged
  std::int64_t saturated = 0;  ///< of them, those that met any limit
  std::vector<Part> parts;     ///< by their first time
  double share() const { return static_cast<double>(saturated) / static_cast<double>(judged); }
};

/// "800 of 4000 judged samples (20 %), clamp first at 5.106 s"
std::string text(const Saturation& saturation);

/// By signal ("<device>.interaction.<strategy>", "<device>.force.<strategy>"); signals that met no limit are left out.
std::map<std::string, Saturation> saturations(const RunRecord& run);

}  // namespace evenstep
