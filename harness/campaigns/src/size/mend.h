#pragma once
/// Finds the piece of a recording that made a step late, and mends the recording so that this piece is as usual.

#include <vector>

#include "evenstep/reports/size_record.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

/// Changes the order of the values; 0 if there are none.
Duration median(std::vector<std::int64_t>& values);

/// A run time or a pause is late if it is longer than usual by more than 1 % of a usual step. The usual value is the median,
/// separately for the first steps of segments and for all others, of the run time and of the pause before a step. (The pause
/// before the first step of a segment begins with the visualization, or with the end of the step before if the recording has
/// no visualization there.)
class Mending {
 public:
  /// The segments are changed while a mended schedule is being looked at; they must outlive this object.
  explicit Mending(std::vector<SegmentTiming>& segments);

  /// For a step, counted over all segments, finds the one in its segment or the two before it that was delayed most.
  SizeCulprit blame(std::int64_t step) const;
  /// Blames the step itself, with the time by which it ran longer than usual.
  SizeCulprit blame_run_time(std::int64_t step) const;

  /// Calls `look` while the excess of culprit.late_step is cut out. Everything after it moves up by the excess, as far as
  /// the next idle time: a gap of more than 1 % of the median segment. In a recording without visualizations, pauses do not
  /// count as idle, unless its segments keep time (median |T - median T| < 1 %): then the next segment begins where it did
  /// before. The same holds if the visualization has a thread of its own. Returns false if there is nothing to mend.
  template <class Look>
  bool mended(const SizeCulprit& culprit, Look look) {
    if (!cut(culprit)) return false;
    look();
    restore();
    return true;
  }

 private:
  struct At {
    std::size_t segment = 0, index = 0;
  };
  struct Usual {
    Duration pause, run;
  };

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
  std::vector<std::int64_t> first_step_;  // number of each segment's first step; the last entry is the number of all steps
  Usual first_, other_;
  Duration idle_from_, late_from_;
  bool sees_visualizations_ = false, concurrent_ = false, keeps_time_ = false;
  SegmentTiming kept_;                         // the original segment of the late step
  std::size_t moved_from_ = 0, moved_to_ = 0;  // the later segments that have moved, and by how much
  Duration moved_by_;
};

}  // namespace evenstep::internal
