#pragma once
/// Which piece of a recording made a step late, and the recording without that lateness.

#include <vector>

#include "evenstep/reports/size_record.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

/// Late is what took longer than usual by more than 1 % of a usual step. Usual is the median, apart for the first steps of
/// segments and for all others: of the run time, and of the pause before a step (before the first of a segment: from the
/// visualization's begin, or from the end of the step before where the recording has no visualization there).
class Mending {
 public:
  /// Changes the segments while a mended schedule is looked at; they must outlive it.
  explicit Mending(std::vector<SegmentTiming>& segments);

  /// The step, counted over all segments, and the one that was held up most in its segment and the two before it.
  SizeCulprit blame(std::int64_t step) const;
  /// The step itself, and how much longer than usual it ran.
  SizeCulprit blame_run_time(std::int64_t step) const;

  /// Calls `look` with the excess of culprit.late_step cut out. What follows moves up by it as far as the next idle time: a
  /// gap of more than 1 % of the median segment. Pauses of a recording without visualizations are not idle, unless its
  /// segments keep time (median |T - median T| < 1 %): then the next segment begins as it did. So it does where the
  /// visualization has a thread of its own. False: there is nothing to mend.
  template <class Look>
  bool mended(const SizeCulprit& culprit, Look look) {
    if (!cut(culprit)) return false;
    look();
    restore();
    return true;
  }

 private:
  struct At { std::size_t segment = 0, index = 0; };
  struct Usual { Duration pause, run; };

  At at(std::int64_t step) const;
  const Interval& step(At at) const { return segments_[at.segment].steps[at.index]; }
  RealTime pause_begin(At at) const;
  Duration pause_excess(At at) const;
  Duration run_excess(At at) const;
  SizeCulprit culprit(std::int64_t step) const;
  void find_usual();
  void find_pace();
  bool cut(const SizeCulprit& culprit);
  void move(Duration by);
  bool waits(std::size_t k) const;
  void restore();

  std::vector<SegmentTiming>& segments_;
  std::vector<std::int64_t> first_step_;    // of each segment; one more entry: all steps
  Usual first_, other_;
  Duration idle_from_, late_from_;
  bool sees_visualizations_ = false, concurrent_ = false, keeps_time_ = false;
  SegmentTiming kept_;                      // the late step's segment as it was
  std::size_t moved_from_ = 0, moved_to_ = 0;   // the segments behind it that have moved, and by how much
  Duration moved_by_;
};

}  // namespace evenstep::internal
