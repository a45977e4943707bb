#include "evenstep/scheduler/frame_governor.h"

#include <algorithm>
#include <cassert>
#include <deque>
#include <numeric>
#include <utility>

namespace evenstep {
namespace {

constexpr std::int64_t kIdleShare = 100;  // a gap is idle time if it is longer than this part of the period
constexpr std::size_t kUsualOf = 8;       // a held pause is as long as the mean of this many parts
constexpr std::size_t kLearnedFrom = 8;   // segments of a recording, for its usual period and number of steps

RealTime work_end(const SegmentTiming& segment) {
  RealTime end = segment.begin;
  if (segment.visualization) end = std::max(end, segment.visualization->end);
  return segment.steps.empty() ? end : std::max(end, segment.steps.back().end);
}

Interval moved(const Interval& interval, Duration by) { return {interval.begin + by, interval.end + by}; }

/// Decides what is drawn: which drawings begin, and how much of a drawing in each pause.
class Drawings {
 public:
  explicit Drawings(const FrameGovernor& governor) : governor_(governor) {}

  /// A drawing of this length is due, in so many parts. False: it is left out.
  bool begin(Duration length, int parts) {
    const Duration part{(length.ns + parts - 1) / parts};
    const bool merged = rest_.ns > 0;
    if (!merged && fits(part)) {
      rest_ = length;
      part_ = part;
      remember(part);
      return true;
    }
    if (!merged) remember({});
    return false;
  }
  bool under_way() const { return rest_.ns > 0; }
  /// The part of the drawing for the next pause.
  Duration next() {
    last_ = std::min(rest_, part_);
    if (const auto most = at_most()) last_ = std::min(last_, *most);
    rest_ = rest_ - last_;
    return last_;
  }
  std::optional<Duration> at_most() const {
    return governor_.over_budget == OverBudget::merge ? governor_.budget : std::nullopt;
  }
  /// The least length of a pause in which less is drawn than usual.
  Duration held() const {
    if (!governor_.budget || governor_.over_budget == OverBudget::skip) return {};
    if (usual_.empty()) return *governor_.budget;
    std::int64_t sum = 0;
    for (const Duration part : usual_) sum += part.ns;
    return std::min(Duration{sum / std::ssize(usual_)}, *governor_.budget);
  }
  void measured(Duration took, bool finished) {
    if (part_begun_) usual_.back() = took;
    if (!expected_.empty()) expected_.back() = std::max(took, part_begun_ ? Duration{} : expected_.back());
    part_begun_ = false;
    if (finished) rest_ = {};
    if (!finished && rest_.ns == 0) rest_ = std::max(last_, Duration{1});
  }

 private:
  bool fits(Duration part) const {
    if (!governor_.budget || governor_.over_budget == OverBudget::merge) return true;
    if (governor_.forecast == 0) return part <= *governor_.budget;
    return expected_.empty() || *std::max_element(expected_.begin(), expected_.end()) <= *governor_.budget;
  }
  void remember(Duration part) {
    part_begun_ = part.ns > 0;
    if (part_begun_) {
      usual_.push_back(part);
      if (usual_.size() > kUsualOf) usual_.pop_front();
    }
    expected_.push_back(part);
    if (expected_.size() > static_cast<std::size_t>(std::max(governor_.forecast, 1))) expected_.pop_front();
  }

  FrameGovernor governor_;
  Duration rest_, part_, last_;    // of the drawing under way: what is left, its part per pause, its last part
  std::deque<Duration> usual_;     // the last parts drawn
  std::deque<Duration> expected_;  // the longest part of each of the last drawings; 0: left out
  bool part_begun_ = false;        // no part of the last drawing has been measured yet
};

/// What the segments of a recording usually are, from the last ones.
class UsualSegment {
 public:
  /// A segment of this length is over, and the source waited for the next one so long.
  void add(Duration length, Duration idle, std::size_t steps) {
    segments_.push_back({length, idle.ns > length.ns / kIdleShare, steps});
    if (segments_.size() > kLearnedFrom) segments_.pop_front();
  }
  /// Empty: it runs freely, or there was none.
  std::optional<Duration> period() const {
    std::vector<Duration> lengths;
    std::size_t waiting = 0;
    for (const Past& segment : segments_) {
      lengths.push_back(segment.length);
      waiting += segment.waited ? 1 : 0;
    }
    if (lengths.empty() || 2 * waiting < lengths.size()) return std::nullopt;
    const auto middle = lengths.begin() + (std::ssize(lengths) - 1) / 2;
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
  }
  std::size_t most_steps() const {
    std::size_t most = 0;
    for (const Past& segment : segments_) most = std::max(most, segment.steps);
    return most;
  }

 private:
  struct Past {
    Duration length;
    bool waited = false;
    std::size_t steps = 0;
  };
  std::deque<Past> segments_;
};

class GovernedTiming final : public StepTiming {
 public:
  /// `learns`: T, P and N are what was usual, once a segment is over.
  GovernedTiming(std::unique_ptr<StepTiming> source, const FrameGovernor& governor, std::optional<Duration> grid,
                 bool learns)
      : source_(std::move(source)), governor_(governor), grid_(grid), learns_(learns), drawings_(governor) {
    more_ = source_->next(following_);
  }

  bool next(SegmentTiming& segment) override {
    do {
      while (opportunity_ == opportunities_.size()) {
        if (!fetch()) return false;
      }
      take(segment);
    } while (!segment.visualization && segment.steps.empty() && segment.end == segment.begin && !segment.drawing.left_out);
    segment.index = index_++;
    return true;
  }
  void visualized(Duration took, bool finished) override { drawings_.measured(took, finished); }

 private:
  struct Opportunity {
    std::size_t first_step = 0, end_step = 0;  // of the given segment
    int part = 0;
    bool draws = true;
  };

  void take(SegmentTiming& segment) {
    segment.begin = begin_of(opportunities_[opportunity_]);
    segment.concurrent = given_.concurrent;
    segment.visualization.reset();
    segment.steps.clear();
    segment.drawing = {};
    if (given_.overlaps()) {
      pass(segment);
    } else {
      fill(opportunities_[opportunity_], segment);
    }
    segment.end = end_;
    ++opportunity_;
  }

  /// Takes the next segment of the source, and shares out its steps.
  bool fetch() {
    if (!more_) return false;
    const RealTime ended = given_end_;
    if (learns_ && number_ >= 0) {
      usual_.add(following_.begin - given_.begin, following_.begin - ended, given_.steps.size());
      grid_ = usual_.period();
    }
    std::swap(given_, following_);
    more_ = source_->next(following_);
    place(ended);
    given_end_ = work_end(given_);
    opportunities_.clear();
    opportunity_ = 0;
    const std::vector<Interval>& steps = given_.steps;
    std::size_t before = 0;
    while (given_.visualization && before < steps.size() && steps[before].begin < given_.visualization->begin) ++before;
    steps_first_ = before > 0 && before == steps.size();
    if (given_.overlaps()) {
      opportunities_.push_back({0, steps.size()});
      return true;
    }
    if (steps_first_ || before == 0) {
      before = 0;
    } else {
      opportunities_.push_back({0, before, 0, false});
    }
    const auto share = [&](int part) {
      return before + (steps.size() - before) * static_cast<std::size_t>(part) / static_cast<std::size_t>(governor_.split);
    };
    for (int part = 0; part < governor_.split; ++part) opportunities_.push_back({share(part), share(part + 1), part});
    return true;
  }

  /// Finds the turn of the given segment and the gap before it; the work before it ended at `ended` in the source.
  void place(RealTime ended) {
    ++number_;
    if (number_ == 0) {
      origin_ = turn_ = end_ = given_.begin;
      gap_ = {};
      return;
    }
    gap_ = given_.begin - ended;
    const bool waited = grid_ && gap_.ns > grid_->ns / kIdleShare;
    turn_ = waited || !grid_ ? given_.begin : std::min(turn_ + *grid_, given_.begin);
    if (waited) gap_ = {};
  }

  RealTime begin_of(const Opportunity& opportunity) const {
    const RealTime earliest = opportunity_ == 0 ? end_ + gap_ : end_;
    if (!governor_.pace && !grid_) return earliest;
    const std::optional<RealTime> first_slot = opportunity.part > 0 ? slot(opportunity.first_step) : std::nullopt;
    return std::max(earliest, first_slot ? *first_slot : turn(opportunity.part, governor_.split));
  }

  /// The turn of the given segment plus i/n of a period; there is a pace or a grid.
  RealTime turn(std::int64_t i, std::int64_t n) const {
    if (governor_.pace) return origin_ + Duration{floor_mul_div(governor_.pace->ns, number_ * n + i, n)};
    return turn_ + Duration{floor_mul_div(grid_->ns, i, n)};
  }

  /// When step i of the given segment may begin; empty: at once.
  std::optional<RealTime> slot(std::size_t i) const {
    const bool unknown = learns_ && (number_ > 0 || governor_.split == 1);  // who shares steps out knows how many there are
    const std::size_t n = unknown ? usual_.most_steps() : given_.steps.size();
    if (!governor_.spread || (!governor_.pace && !grid_) || n == 0) return std::nullopt;
    const RealTime slot = turn(static_cast<std::int64_t>(std::min(i, n - 1)), static_cast<std::int64_t>(n));
    return more_ && !governor_.pace ? std::min(slot, following_.begin) : slot;
  }

  /// The given segment unchanged but moved to where it now begins.
  void pass(SegmentTiming& segment) {
    const Duration by = segment.begin - given_.begin;
    if (given_.visualization) segment.visualization = moved(*given_.visualization, by);
    for (const Interval& step : given_.steps) segment.steps.push_back(moved(step, by));
    end_ = work_end(given_) + by;
  }

  void fill(const Opportunity& opportunity, SegmentTiming& segment) {
    end_ = segment.begin;
    if (opportunity.draws && opportunity.part == 0) {
      left_out_ =
          given_.visualization && !drawings_.begin(given_.visualization->end - given_.visualization->begin, governor_.split);
      segment.drawing.left_out = left_out_;
    }
    if (steps_first_) add_steps(opportunity, segment);
    if (opportunity.draws) add_pause(segment);
    if (!steps_first_) add_steps(opportunity, segment);
  }

  void add_pause(SegmentTiming& segment) {
    const bool begun_empty = given_.visualization && !left_out_ &&
                             given_.visualization->begin == given_.visualization->end &&
                             opportunities_[opportunity_].part == 0;
    if (!drawings_.under_way() && !begun_empty) {
      if (left_out_) end_ = end_ + drawings_.held();
      return;
    }
    // Idle time comes before the drawing, unless the steps have it.
    const bool in_place = steps_first_ && governor_.split == 1 && !governor_.pace && !governor_.spread;
    if (in_place) end_ = end_ + (given_.visualization->begin - given_.steps.back().end);
    segment.visualization = Interval{end_, end_ + drawings_.next()};
    end_ = segment.visualization->end;
    if (left_out_) end_ = std::max(end_, segment.visualization->begin + drawings_.held());  // a rest is shorter than usual
    segment.drawing.parts = governor_.split;
    segment.drawing.at_most = drawings_.at_most();
    segment.drawing.finishes = !drawings_.under_way();
  }

  void add_steps(const Opportunity& opportunity, SegmentTiming& segment) {
    for (std::size_t i = opportunity.first_step; i < opportunity.end_step; ++i) {
      const Interval& step = given_.steps[i];
      RealTime before = i > 0 ? given_.steps[i - 1].end : given_.begin;
      if (!steps_first_ && given_.visualization && given_.visualization->end <= step.begin)
        before = std::max(before, given_.visualization->end);
      RealTime begin = end_ + (step.begin - before);
      if (const std::optional<RealTime> earliest = slot(i)) begin = std::max(begin, *earliest);
      end_ = begin + (step.end - step.begin);
      segment.steps.push_back({begin, end_});
    }
  }

  std::unique_ptr<StepTiming> source_;
  FrameGovernor governor_;
  std::optional<Duration> grid_;
  bool learns_;
  UsualSegment usual_;
  Drawings drawings_;
  SegmentTiming given_;      // of the source
  SegmentTiming following_;  // the next one of the source, if there are more
  bool more_ = false;
  RealTime given_end_;            // of its work
  std::int64_t number_ = -1;      // its number
  RealTime origin_, turn_, end_;  // the first begin; the turn of the given segment; where the governed work ended
  Duration gap_;                  // before the given segment, unless it waited for the grid
  std::vector<Opportunity> opportunities_;
  std::size_t opportunity_ = 0;
  bool steps_first_ = false, left_out_ = false;
  std::int64_t index_ = 0;
};

}  // namespace

std::optional<Duration> grid_period(std::span<const SegmentTiming> segments) {
  if (segments.size() < 3) return std::nullopt;
  std::vector<std::int64_t> lengths, off;
  for (std::size_t k = 1; k < segments.size(); ++k) lengths.push_back((segments[k].begin - segments[k - 1].begin).ns);
  const auto median = [](std::vector<std::int64_t>& values) {
    const auto middle = values.begin() + std::ssize(values) / 2;
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  std::vector<std::int64_t> sorted = lengths;
  const std::int64_t period = median(sorted);
  for (const std::int64_t length : lengths) off.push_back(std::abs(length - period));
  const auto waits = [&](std::size_t k) { return (segments[k].begin - work_end(segments[k - 1])).ns > period / kIdleShare; };
  std::size_t waiting = 0;
  for (std::size_t k = 1; k < segments.size(); ++k) waiting += waits(k) ? 1 : 0;
  if (median(off) > period / 100 || 2 * waiting < lengths.size()) return std::nullopt;
  return Duration{period};
}

std::optional<Duration> grid_period(const ProgrammedTiming& timing) {
  const Duration period{instant_ns(timing.segment, 1)};
  const bool rests =
      is_periodic(timing) && timing.step && timing.visualization + *timing.step * timing.steps.front() < period;
  return timing.paced || rests ? std::optional(period) : std::nullopt;
}

std::unique_ptr<StepTiming> make_governed_timing(std::unique_ptr<StepTiming> source, const FrameGovernor& governor,
                                                 std::optional<Duration> grid) {
  assert(governor.split >= 1 && (!governor.budget || governor.budget->ns > 0) && governor.forecast >= 0);
  assert(!governor.pace || governor.pace->ns > 0);
  return std::make_unique<GovernedTiming>(std::move(source), governor, grid, false);
}

std::unique_ptr<StepTiming> make_governed_replay(std::vector<SegmentTiming> recording, const FrameGovernor& governor) {
  const bool known = !governor.spread || governor.split > 1;  // who shares idle time out between parts knows the grid
  const std::optional<Duration> grid = known ? grid_period(recording) : std::nullopt;
  return std::make_unique<GovernedTiming>(make_replayed_timing(std::move(recording)), governor, grid, governor.spread);
}

}  // namespace evenstep
