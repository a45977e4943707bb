#pragma once
/// Recovery: how long after its last programmed fault a run is as good again as it was before the first one. In
/// TigerBeetle's simulator faults stop at some time, and the system must then make progress (its "liveness mode"); here it
/// must be as good as it was. From the instant of recovery until the end of the run all of these hold for a device and a
/// strategy:
///
///   underruns  no step misses its sample (or acquires), and no force is late
///   latency    the age of the force that a tick sends, t - R(n), is at most `recovery_latency` above the greatest before
///              the first fault (where the latency adapts: above the greatest of the last window before it)
///   jump       |x(n+1) - 2 x(n) + x(n-1)| of what the solver is given, and of the force at the ticks, is at most
///              recovery_jump * mean |x(n+1) - x(n)| above the greatest before the first fault (and a nanometre or a
///              micronewton, where nothing moved); and no limit of guard or device meets a force that met none before
///
/// "Before the first fault" is the judged time until then, which must be a window long: eight segments, and at least 250 ms.
/// Recovery is unknown if a run ends less than a window after its last fault; that a run never recovers is known only after
/// two windows. The time of a jump is that of the last of its three samples.

#include <array>
#include <optional>
#include <string>

#include "evenstep/reports/run_record.h"

namespace evenstep {

struct Recovery {
  enum class State : std::uint8_t {
    no_fault,   ///< none is programmed: there is nothing to recover from
    no_calm,    ///< too little is judged before the first fault
    too_short,  ///< the run ends too early to say
    recovered,
    never  ///< something does not hold at the end of the run, or a fault lasts until then
  } state = State::no_fault;
  /// For `recovered` and `never`: how long each of the three takes, in the order above; infinite: it does not hold at the
  /// end.
  std::array<double, 3> part_s{};
  double time_s() const;
  RealTime faults_end;  ///< for `recovered`, and for `never` unless a fault lasts until the end
  Duration watched;     ///< from then until a window before the end: a recovery that takes longer is not seen
  std::string why;      ///< of every state but `recovered`
};
inline constexpr std::array kRecoveryParts{"underruns", "latency", "jump"};

/// When a fault is over on a schedule of segments. Empty: not before its end.
std::optional<RealTime> fault_end(const ProgrammedFault& fault, const Rows<SegmentRow>& segments);

/// The recovery of the device with this index.
Recovery recovery_of(const RunRecord& run, const StrategyRecord& strategy, std::size_t device);

/// What a window is in this run.
Duration recovery_window(const Nominal& nominal);

}  // namespace evenstep
