#pragma once
/// What is known about a run in virtual time before it starts: the expectations that must fail, and what its schedule will
/// do.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/pace.h"
#include "evenstep/reports/pause_parts.h"
#include "evenstep/reports/verdict.h"

namespace evenstep {

/// The expectations that cannot hold, by the sizing pass alone: on underruns and late forces, and on latencies, lead and
/// rings, of the strategies that remap. Of any other expectation nothing is said. Nothing is foreseen for a run that
/// [expect_stop] ends early, for a [case], or for expectations on the wall clock.
std::vector<ExpectationResult> foresee_failures(const Scenario& scenario, const std::vector<StrategyPlan>& plans);

/// A programmed fault (docs/timings/recovery.md), by the schedule of the timing. In a run it ends at the same time, unless
/// steps wait for samples (`gate`) or the run is on a wall clock.
struct ForetoldFault {
  std::string name;
  RealTime from;
  std::optional<RealTime> to;  ///< empty: it is not over when the run ends
  bool lasts = false;          ///< by its definition it lasts until the end of the run
};
/// Drawings in the judged span, as `drawing_rate` and `drawings_left_out` count them.
struct ForetoldDrawings {
  std::int64_t finished = 0, left_out = 0;
};
struct ForetoldSchedule {
  std::vector<ForetoldFault> faults;  ///< those that begin before the end of the run, as they are written
  ForetoldDrawings drawings;
  PauseParts longest_pause;
  Pace pace;  ///< of the steps that begin in the run
  /// What recovery_time counts from; empty: there is no fault, or one is not over when the run ends.
  std::optional<RealTime> last_end() const;
};
/// Of a scenario with a timing, not of a [case].
ForetoldSchedule foretell_schedule(const Scenario& scenario);

}  // namespace evenstep
