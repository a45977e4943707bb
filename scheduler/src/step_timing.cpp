#include "evenstep/scheduler/step_timing.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>
#include <utility>

#include "timing_models.h"

namespace evenstep {
namespace {

class PeriodicTiming final : public StepTiming {
 public:
  explicit PeriodicTiming(const ProgrammedTiming& timing)
      : segment_rate_(timing.segment),
        visualization_(timing.visualization),
        step_count_(timing.steps.front()),
        step_(timing.step),
        steps_first_(timing.order == SegmentOrder::steps_first) {
    // Every T_k is floor(T) or ceil(T), and whole nanoseconds that fit in T fit in floor(T).
    const Duration shortest_segment{instant_ns(segment_rate_, 1)};
    assert(visualization_ + step_.value_or(Duration{1}) * step_count_ <= shortest_segment);
    static_cast<void>(shortest_segment);
  }

  bool next(SegmentTiming& segment) override {
    segment.index = index_;
    segment.begin = tick_time(segment_rate_, index_);
    segment.end = tick_time(segment_rate_, index_ + 1);
    segment.concurrent = false;
    ++index_;

    const RealTime first_step = steps_first_ ? segment.begin : segment.begin + visualization_;
    const RealTime visualization = steps_first_ ? segment.end - visualization_ : segment.begin;
    segment.visualization.reset();
    if (visualization_.ns > 0) segment.visualization = Interval{visualization, visualization + visualization_};

    const Duration room = segment.end - segment.begin - visualization_;
    segment.steps.clear();
    for (std::int64_t i = 0; i < step_count_; ++i) {
      segment.steps.push_back({first_step + offset(i, room), first_step + offset(i + 1, room)});
    }
    return true;
  }

 private:
  Duration offset(std::int64_t i, Duration room) const {
    return step_ ? *step_ * i : Duration{floor_mul_div(room.ns, i, step_count_)};
  }

  Rate segment_rate_;
  Duration visualization_;
  std::int64_t step_count_;
  std::optional<Duration> step_;
  bool steps_first_;
  std::int64_t index_ = 0;
};

/// Visualization and steps take turns: free-running, or paced, where each segment waits for its tick of the grid.
class TakingTurns final : public StepTiming {
 public:
  explicit TakingTurns(const ProgrammedTiming& timing)
      : order_(timing.order),
        grid_(timing.paced ? std::optional<Rate>(timing.segment) : std::nullopt),
        wake_(timing.wake),
        drift_per_s_(timing.drift_per_s),
        means_(timing),
        visualizations_(timing),
        turns_(timing),
        step_counts_(timing.seed, "timing.step_count") {
    assert(timing.slowdown == 1);
  }

  bool next(SegmentTiming& segment) override {
    segment.index = index_;
    segment.begin = turns_.end;
    segment.visualization.reset();
    segment.steps.clear();
    segment.concurrent = false;
    const internal::MeansInForce::Means& means = means_.at(segment.begin);
    const double drift = internal::drift_factor(drift_per_s_, segment.begin);
    const std::optional<Duration> visualization = visualizations_.next(segment.begin, means.visualization, drift);

    if (order_ == SegmentOrder::visualization_first) turns_.append_visualization(segment, visualization);
    const int count = means.steps[step_counts_.below(static_cast<std::uint64_t>(index_), means.steps.size())];
    for (int i = 0; i < count; ++i) turns_.append_step(segment, means.step, drift);
    if (order_ == SegmentOrder::steps_first) {
      if (grid_ && visualization) turns_.end = std::max(turns_.end, tick_time(*grid_, index_ + 1) - *visualization);
      turns_.append_visualization(segment, visualization);
    }
    ++index_;
    if (grid_) turns_.end = wake_up(*grid_, segment.begin);
    segment.end = turns_.end;
    return true;
  }

 private:
  /// When the next segment begins, if this one began at `began`.
  RealTime wake_up(Rate grid, RealTime began) const {
    if (wake_ == WakeUp::absolute_grid)
      return tick_time(grid, first_tick_at_or_after(grid, std::max(turns_.end, began + Duration{1})));
    if (wake_ == WakeUp::from_last_update) return std::max(turns_.end, began + Duration{instant_ns(grid, 1)});
    return std::max(turns_.end, tick_time(grid, index_));
  }

  SegmentOrder order_;
  std::optional<Rate> grid_;
  WakeUp wake_;
  double drift_per_s_;
  internal::MeansInForce means_;
  internal::VisualizationCost visualizations_;
  internal::Turns turns_;
  RandomStream step_counts_;
  std::int64_t index_ = 0;
};

/// Visualizations in a lane of their own, beside steps without gaps.
class SideBySide final : public StepTiming {
 public:
  explicit SideBySide(const ProgrammedTiming& timing)
      : grid_(timing.paced ? std::optional<Rate>(timing.segment) : std::nullopt),
        drift_per_s_(timing.drift_per_s),
        slowdown_(timing.slowdown),
        means_(timing),
        visualizations_(timing),
        steps_(timing) {
    assert(timing.visualization.ns > 0 && timing.first_step == 0 && timing.slowdown >= 1);
    assert(timing.paced || timing.dropped_visualization == 0);  // otherwise a segment could have no length
  }

  bool next(SegmentTiming& segment) override {
    segment.index = index_++;
    segment.begin = boundary_;
    segment.visualization.reset();
    segment.steps.clear();
    segment.concurrent = true;
    const internal::MeansInForce::Means& means = means_.at(segment.begin);
    const double drift = internal::drift_factor(drift_per_s_, segment.begin);

    RealTime visualized = segment.begin;
    if (const std::optional<Duration> visualization = visualizations_.next(segment.begin, means.visualization, drift)) {
      visualized = segment.begin + *visualization;
      segment.visualization = Interval{segment.begin, visualized};
    }
    boundary_ = grid_ ? std::max(visualized, tick_time(*grid_, index_)) : visualized;
    while (step_begin_ < boundary_) {
      const Duration step = steps_.next(segment.begin, means.step, step_begin_ < visualized ? drift * slowdown_ : drift);
      segment.steps.push_back({step_begin_, step_begin_ + step});
      step_begin_ = step_begin_ + step;
    }
    segment.end = segment.steps.empty() ? boundary_ : std::max(boundary_, step_begin_);
    return true;
  }

 private:
  std::optional<Rate> grid_;
  double drift_per_s_, slowdown_;
  internal::MeansInForce means_;
  internal::VisualizationCost visualizations_;
  internal::StepCost steps_;
  RealTime boundary_{}, step_begin_{};
  std::int64_t index_ = 0;
};

class ReplayedTiming final : public StepTiming {
 public:
  explicit ReplayedTiming(std::vector<SegmentTiming> segments) : segments_(std::move(segments)) {}

  bool next(SegmentTiming& segment) override {
    if (position_ == segments_.size()) return false;
    segment = segments_[position_++];
    // A drawing that was longer than its segment, or was dropped, leaves a segment that begins while a step is running and
    // whose own steps show nothing of the drawing's lane.
    segment.concurrent = segment.concurrent || segment.begin < busy_until_;
    for (const Interval& step : segment.steps) busy_until_ = std::max(busy_until_, step.end);
    return true;
  }

 private:
  std::vector<SegmentTiming> segments_;
  std::size_t position_ = 0;
  RealTime busy_until_{std::numeric_limits<std::int64_t>::min()};  // end of the last step
};

class RealSteps final : public StepTiming {
 public:
  explicit RealSteps(std::unique_ptr<StepTiming> programmed) : programmed_(std::move(programmed)) {}
  bool next(SegmentTiming& segment) override {
    if (!programmed_->next(segment)) return false;
    if (segment.steps.empty()) return true;
    const RealTime start = segment.steps.front().begin;
    for (Interval& step : segment.steps) step = {start, start};
    return true;
  }
  void visualized(Duration took, bool finished) override { programmed_->visualized(took, finished); }

 private:
  std::unique_ptr<StepTiming> programmed_;
};

}  // namespace

bool has_clock(std::span<const SegmentTiming> segments) {
  return std::any_of(segments.begin(), segments.end(), [](const SegmentTiming& one) { return !one.simulated.empty(); });
}

bool SegmentTiming::overlaps() const {
  if (concurrent) return true;
  if (!visualization) return false;
  return std::any_of(steps.begin(), steps.end(), [this](const Interval& step) {
    return std::max(step.begin, visualization->begin) < std::min(step.end, visualization->end);
  });
}

namespace {

[[maybe_unused]] bool counts_are_good(const std::vector<int>& steps) {
  return std::all_of(steps.begin(), steps.end(), [](int count) { return count >= 0; });
}

/// Whether a schedule with these `steps` (the initial ones, or those of a change) takes any time; if not, time would stand
/// still.
[[maybe_unused]] bool time_passes(const ProgrammedTiming& timing) {
  const int most_steps = *std::max_element(timing.steps.begin(), timing.steps.end());
  if (timing.dropped_visualization == 1 && most_steps == 0) return false;
  return (timing.visualization.ns > 0 || most_steps > 0) && (most_steps == 0 || starting_step(timing).ns > 0);
}

}  // namespace

std::unique_ptr<StepTiming> make_programmed_timing(const ProgrammedTiming& timing) {
  assert(timing.segment.num > 0 && timing.segment.den > 0 && timing.visualization.ns >= 0 && !timing.steps.empty());
  assert(counts_are_good(timing.steps));
  assert(!timing.step || timing.step->ns > 0);
  assert(timing.visualization_variation >= 0 && timing.step_variation >= 0 && timing.first_step > -1);
  assert(timing.dropped_visualization >= 0 && timing.merged_visualization >= 0);
  assert(timing.dropped_visualization + timing.merged_visualization <= 1);
  assert(!timing.preemption || (timing.preemption->least.ns > 0 && timing.preemption->least <= timing.preemption->most));
  assert(!timing.preemption || timing.preemption->tail > 0);
  assert(std::all_of(timing.changes.begin(), timing.changes.end(), [&](const TimingChange& change) {
    const bool no_lane = timing.order == SegmentOrder::concurrent && change.visualization == Duration{0};
    return counts_are_good(change.steps) && !no_lane && (!change.step || change.step->ns > 0);
  }));
  assert(!timing.regimes || (timing.regimes->factor > 0 && shortest_mean_stay(*timing.regimes) >= 1));
  if (timing.accumulator) return internal::make_accumulator_timing(timing);
  if (is_periodic(timing)) return std::make_unique<PeriodicTiming>(timing);
  assert(time_passes(timing));
  if (timing.order == SegmentOrder::concurrent) return std::make_unique<SideBySide>(timing);
  return std::make_unique<TakingTurns>(timing);
}

Duration replay_duration(std::span<const SegmentTiming> segments) {
  RealTime end, last_step_end;
  for (const SegmentTiming& segment : segments) {
    end = std::max(end, segment.end);
    if (!segment.steps.empty()) last_step_end = std::max(last_step_end, segment.steps.back().end);
  }
  return (last_step_end == end ? end + Duration{1} : end) - RealTime{};
}

std::unique_ptr<StepTiming> make_replayed_timing(std::vector<SegmentTiming> segments) {
  return std::make_unique<ReplayedTiming>(std::move(segments));
}

std::unique_ptr<StepTiming> make_real_steps(std::unique_ptr<StepTiming> programmed) {
  return std::make_unique<RealSteps>(std::move(programmed));
}

}  // namespace evenstep
