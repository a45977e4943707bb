#pragma once
/// Finds the hitches of a recording, groups them into kinds, and mends all of a kind at once.
///
/// A recording is taken apart into pieces: visualizations, steps, and the gaps between them. Pieces of one class (the first
/// step of a segment is a class of its own, and so is each place of a gap) are usually as long as their median. A piece is a
/// hitch if it is longer than that by more than 6 robust deviations (1.4826 times the median absolute deviation) and by more
/// than a twentieth of the median segment. A gap before a boundary counts only as far as it makes the segment longer than
/// the median segment, because idle time makes up for work that was short. Hitches of visualizations, of steps and of gaps
/// are sorted by their excess, the longest first; another kind begins where the excess before is more than 1.5 times as
/// long, or the first one of the kind more than 4 times.
///
/// If visualizations have a thread of their own, they delay no step: only the steps and the gaps between them are looked at.

#include <array>
#include <vector>

#include "evenstep/reports/size_record.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

struct SeenHitch {
  std::int64_t piece = 0;  ///< its number in the order of time
  SizeHitches::What what = SizeHitches::What::gap;
  RealTime begin;
  Duration length, usual;
  Duration excess;  ///< what mending takes away: length - usual, or less at a boundary
};

/// Of one kind, in order of time.
using HitchKind = std::vector<SeenHitch>;

class Hitches {
 public:
  /// `segments` must outlive this object.
  explicit Hitches(const std::vector<SegmentTiming>& segments);

  Duration usual_segment() const { return segment_; }  ///< the median; 0 for a single segment
  /// In order of the longest excess of each.
  const std::vector<HitchKind>& kinds() const { return kinds_; }

  /// The recording if the first `count` kinds from `first` on had been as usual. What follows a hitch moves up by its
  /// excess, until something waits: a gap that is usually longer than 1 % of a segment, or, where segments keep time (median
  /// |T - median T| below 1 %) and have idle time at their end, the segment's turn.
  std::vector<SegmentTiming> mended(std::size_t first, std::size_t count) const;

 private:
  std::vector<SeenHitch> find();
  std::vector<SegmentTiming> moved(const std::vector<SeenHitch>& cuts) const;
  std::vector<SegmentTiming> moved_beside(const std::vector<SeenHitch>& cuts) const;

  const std::vector<SegmentTiming>& segments_;
  std::vector<HitchKind> kinds_;
  std::array<Duration, 7> usual_;  // the median of each class of pieces
  Duration segment_;               // the median
  bool concurrent_ = false, sees_visualizations_ = false, paced_ = false;
};

}  // namespace evenstep::internal
