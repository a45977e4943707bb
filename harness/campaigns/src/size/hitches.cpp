#include "hitches.h"

#include <algorithm>
#include <cstdlib>
#include <tuple>

#include "mend.h"

namespace evenstep::internal {
namespace {

using What = SizeHitches::What;

constexpr double kDeviations = 6, kDeviationsOfNormal = 1.4826;  // a robust deviation is that many median deviations
constexpr std::int64_t kLeastPart = 20, kIdlePart = 100;         // of the median segment
constexpr double kAlike = 1.5, kSpread = 4;  // from one to the next shorter one of a kind; to the last one
constexpr std::size_t kLeastSegments = 3;    // fewer have no usual segment

/// What has a usual length of its own.
enum PieceClass : std::size_t {
  kVisualization,
  kFirstStep,
  kStep,
  kGapBeforeVisualization,
  kGapBeforeSteps,
  kGapBetweenSteps,
  kGapAtBoundary,
  kClasses
};

struct Piece {
  std::int64_t number = 0;
  PieceClass cls = kStep;
  std::size_t segment = 0;  ///< a gap at a boundary belongs to the segment that begins there
  Interval time;
};

/// A wait is a gap too.
What what_of(PieceClass cls) {
  if (cls == kVisualization) return What::visualization;
  return cls == kFirstStep || cls == kStep ? What::step : What::gap;
}

/// Visits the pieces of a recording in order of time: before each visualization and each step the gap before it, which may
/// be empty, and a gap at each boundary.
template <class Visit>
void each_piece(const std::vector<SegmentTiming>& segments, Visit visit) {
  std::int64_t number = 0;
  RealTime busy_until;
  const auto piece = [&](PieceClass cls, std::size_t segment, Interval time) {
    visit(Piece{number++, cls, segment, time});
    busy_until = std::max(busy_until, time.end);
  };
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const SegmentTiming& segment = segments[k];
    if (k == 0) busy_until = segment.begin;
    piece(kGapAtBoundary, k, {std::min(busy_until, segment.begin), segment.begin});
    bool visualized = !segment.visualization.has_value();
    const auto visualize = [&] {
      const Interval& time = *segment.visualization;
      piece(kGapBeforeVisualization, k, {std::min(busy_until, time.begin), time.begin});
      piece(kVisualization, k, time);
      visualized = true;
    };
    for (std::size_t i = 0; i < segment.steps.size(); ++i) {
      const Interval& step = segment.steps[i];
      if (!visualized && segment.visualization->begin <= step.begin) visualize();
      piece(i == 0 ? kGapBeforeSteps : kGapBetweenSteps, k, {std::min(busy_until, step.begin), step.begin});
      piece(i == 0 ? kFirstStep : kStep, k, step);
    }
    if (!visualized) visualize();
  }
}

/// The same where visualizations have a thread of their own: the steps, and the gaps between them.
template <class Visit>
void each_piece_beside(const std::vector<SegmentTiming>& segments, Visit visit) {
  std::int64_t number = 0;
  std::optional<RealTime> busy_until;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    for (const Interval& step : segments[k].steps) {
      visit(Piece{number++, kGapBetweenSteps, k, {busy_until.value_or(step.begin), step.begin}});
      visit(Piece{number++, kStep, k, step});
      busy_until = step.end;
    }
  }
}

Duration length(const Interval& time) { return time.end - time.begin; }

/// The median absolute deviation; `values` are spent.
Duration deviation(std::vector<std::int64_t>& values, Duration usual) {
  for (std::int64_t& value : values) value = std::abs(value - usual.ns);
  return median(values);
}

/// Sorts by excess, and begins a new kind where the next one is clearly shorter.
void add_kinds(std::vector<SeenHitch> hitches, std::vector<HitchKind>& kinds) {
  std::sort(hitches.begin(), hitches.end(), [](const SeenHitch& a, const SeenHitch& b) {
    return std::tie(a.what, b.excess, a.piece) < std::tie(b.what, a.excess, b.piece);
  });
  for (std::size_t i = 0; i < hitches.size(); ++i) {
    const SeenHitch& hitch = hitches[i];
    const auto within = [&](const SeenHitch& longer, double factor) {
      return hitch.what == longer.what &&
             static_cast<double>(longer.excess.ns) <= factor * static_cast<double>(hitch.excess.ns);
    };
    if (i == 0 || !within(hitches[i - 1], kAlike) || !within(kinds.back().front(), kSpread)) kinds.emplace_back();
    kinds.back().push_back(hitch);
  }
  std::sort(kinds.begin(), kinds.end(), [](const HitchKind& a, const HitchKind& b) {
    return std::tie(b.front().excess, a.front().what) < std::tie(a.front().excess, b.front().what);
  });
  for (HitchKind& kind : kinds)
    std::sort(kind.begin(), kind.end(), [](const SeenHitch& a, const SeenHitch& b) { return a.piece < b.piece; });
}

/// The excess that is cut out of a piece; they are asked for in order of time.
class Cuts {
 public:
  explicit Cuts(const std::vector<SeenHitch>& hitches) : hitches_(hitches) {}
  Duration of(const Piece& piece) {
    if (next_ == hitches_.size() || hitches_[next_].piece != piece.number) return {};
    return hitches_[next_++].excess;
  }

 private:
  const std::vector<SeenHitch>& hitches_;
  std::size_t next_ = 0;
};

}  // namespace

Hitches::Hitches(const std::vector<SegmentTiming>& segments) : segments_(segments) {
  for (const SegmentTiming& segment : segments) {
    sees_visualizations_ = sees_visualizations_ || segment.visualization.has_value();
    concurrent_ = concurrent_ || segment.overlaps();
  }
  std::vector<SeenHitch> hitches = find();
  if (segments.size() >= kLeastSegments) add_kinds(std::move(hitches), kinds_);
}

std::vector<SeenHitch> Hitches::find() {
  const auto each = [&](auto visit) { concurrent_ ? each_piece_beside(segments_, visit) : each_piece(segments_, visit); };
  std::vector<std::int64_t> lengths;
  for (std::size_t k = 1; k < segments_.size(); ++k) lengths.push_back((segments_[k].begin - segments_[k - 1].begin).ns);
  segment_ = median(lengths);
  const bool keeps_time = deviation(lengths, segment_).ns < segment_.ns / kIdlePart;

  std::array<std::vector<std::int64_t>, kClasses> all;
  each([&](const Piece& piece) {
    if (piece.cls != kGapAtBoundary || piece.segment > 0) all[piece.cls].push_back(length(piece.time).ns);
  });
  std::array<double, kClasses> bound{};
  for (std::size_t c = 0; c < kClasses; ++c) {
    usual_[c] = median(all[c]);
    const double robust = kDeviationsOfNormal * static_cast<double>(deviation(all[c], usual_[c]).ns);
    bound[c] = std::max(kDeviations * robust, static_cast<double>(segment_.ns / kLeastPart));
  }
  paced_ = keeps_time && usual_[kGapAtBoundary].ns > segment_.ns / kIdlePart;

  std::vector<SeenHitch> hitches;
  each([&](const Piece& piece) {
    Duration excess = length(piece.time) - usual_[piece.cls];
    if (piece.cls == kGapAtBoundary) {
      if (piece.segment == 0) return;
      const Duration whole = segments_[piece.segment].begin - segments_[piece.segment - 1].begin;
      excess = std::min(excess, whole - segment_);
    }
    if (static_cast<double>(excess.ns) <= bound[piece.cls]) return;
    What what = what_of(piece.cls);
    if (piece.cls == kGapAtBoundary && 2 * (segments_[piece.segment - 1].end - piece.time.begin).ns > length(piece.time).ns)
      what = What::waiting;
    hitches.push_back({piece.number, what, piece.time.begin, length(piece.time), usual_[piece.cls], excess});
  });
  return hitches;
}

std::vector<SegmentTiming> Hitches::mended(std::size_t first, std::size_t count) const {
  std::vector<SeenHitch> cuts;
  for (std::size_t i = first; i < first + count; ++i) cuts.insert(cuts.end(), kinds_[i].begin(), kinds_[i].end());
  std::sort(cuts.begin(), cuts.end(), [](const SeenHitch& a, const SeenHitch& b) { return a.piece < b.piece; });
  return concurrent_ ? moved_beside(cuts) : moved(cuts);
}

std::vector<SegmentTiming> Hitches::moved(const std::vector<SeenHitch>& hitches) const {
  std::vector<SegmentTiming> out;
  out.reserve(segments_.size());
  Cuts cuts(hitches);
  Duration by;
  const Duration idle_from{segment_.ns / kIdlePart};
  each_piece(segments_, [&](const Piece& piece) {
    const bool is_gap = what_of(piece.cls) == What::gap;
    const bool waits = sees_visualizations_ && usual_[piece.cls] > idle_from && length(piece.time) > idle_from;
    if (is_gap && waits) by = {};
    const RealTime begin = piece.time.begin - by;
    by = by + cuts.of(piece);
    if (piece.cls == kGapAtBoundary) {
      const SegmentTiming& segment = segments_[piece.segment];
      // A segment's turn comes a usual segment after the one before; one that was late may have come later than that.
      if (paced_ && piece.segment > 0) by = std::min(by, std::max(segment.begin - out.back().begin - segment_, Duration{}));
      out.push_back({segment.index, segment.begin - by, std::nullopt, {}, segment.end - by, segment.concurrent});
    } else if (!is_gap) {
      const Interval time{begin, piece.time.end - by};
      if (piece.cls == kVisualization)
        out.back().visualization = time;
      else
        out.back().steps.push_back(time);
      out.back().end = std::max(segments_[piece.segment].end - by, time.end);
    }
  });
  return out;
}

/// Steps may now begin in an earlier segment, because the segments follow the visualizations, which stay.
std::vector<SegmentTiming> Hitches::moved_beside(const std::vector<SeenHitch>& hitches) const {
  std::vector<SegmentTiming> out = segments_;
  for (SegmentTiming& segment : out) segment.steps.clear();
  Cuts cuts(hitches);
  Duration by;
  std::size_t k = 0;
  each_piece_beside(segments_, [&](const Piece& piece) {
    const RealTime begin = piece.time.begin - by;
    by = by + cuts.of(piece);
    if (piece.cls != kStep) return;
    while (k + 1 < out.size() && out[k + 1].begin <= begin) ++k;
    out[k].steps.push_back({begin, piece.time.end - by});
  });
  return out;
}

}  // namespace evenstep::internal
