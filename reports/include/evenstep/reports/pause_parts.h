#pragma once
/// What the pause between two steps consists of that a loop has to bridge: drawing, waiting, other work. Only what a pause
/// mostly consists of is worth making shorter.

#include <optional>
#include <span>
#include <string>

#include "evenstep/time/time.h"

namespace evenstep {

struct StrategyRecord;

struct PauseParts {
  Duration length;          ///< from the end of a step to the begin of the next one; 0: there is no pause
  Duration drawing;         ///< visualizations in it
  Duration waiting;         ///< idle time of its segments after their work
  Duration unrecorded;      ///< the rest: nothing says whether the simulator waited or did other work
  Duration steps, segment;  ///< what the steps of the segment before take, and the segment

  /// Whether a part is a tenth of the pause or more.
  bool is_material(Duration part) const { return part.ns > 0 && part * 10 >= length; }
};

/// "Of the longest pause, 30.8 ms, 2.12 are drawing, 28.7 are waiting. The steps take 2.4 of 33.33 ms."; empty if nothing is
/// known of it.
std::string text(const PauseParts& pause);

/// Finds the pause that sets the pause bound (remap/jump_bound.h): that of the step that ends latest after the step before
/// it began. Times are those of a recording, a programmed timing or a run; memory does not grow.
class LongestPause {
 public:
  /// In order of time. `beside`: the drawing has a lane of its own, and no step waits for it.
  void add_segment(const Interval& segment, const std::optional<Interval>& drawing, std::span<const Interval> steps,
                   bool beside);
  PauseParts parts() const;

 private:
  PauseParts longest_;
  Duration needs_;  // from the begin of a step to the end of the next one
  std::optional<Interval> step_before_;
  std::optional<RealTime> segment_before_;               // its begin
  Duration drawing_, waiting_, steps_, segment_length_;  // since the step before; of the segment before
};

/// The same of a run, from its rows; nothing if they were not kept.
PauseParts longest_pause(const StrategyRecord& strategy);

}  // namespace evenstep
