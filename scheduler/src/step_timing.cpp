#include "evenstep/scheduler/step_timing.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <numeric>
#include <utility>

#include "evenstep/scheduler/random.h"

namespace evenstep {
namespace {

class PeriodicTiming final : public StepTiming {
 public:
  explicit PeriodicTiming(const ProgrammedTiming& timing)
      : segment_rate_(timing.segment),
        visualization_(timing.visualization),
        step_count_(timing.steps.front()),
        step_(timing.step),
        steps_first_(timing.steps_first) {
    // Every T_k is floor(T) or ceil(T), and whole nanoseconds that fit in T fit in floor(T).
    const Duration shortest_segment{instant_ns(segment_rate_, 1)};
    assert(visualization_ + step_.value_or(Duration{1}) * step_count_ <= shortest_segment);
    static_cast<void>(shortest_segment);
  }

  bool next(SegmentTiming& segment) override {
    segment.index = index_;
    segment.begin = tick_time(segment_rate_, index_);
    segment.end = tick_time(segment_rate_, index_ + 1);
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

/// (T - V) / mean(N) to the nearest ns; with T = 1e9 den / num that is (1e9 den - V num) count / (num sum).
Duration mean_filling_step(const ProgrammedTiming& timing) {
  const std::int64_t sum = std::accumulate(timing.steps.begin(), timing.steps.end(), std::int64_t{0});
  if (sum == 0) return {0};  // no segment has a step
  const auto count = static_cast<std::int64_t>(timing.steps.size());
  const __int128 numerator = (static_cast<__int128>(1'000'000'000) * timing.segment.den -
                              static_cast<__int128>(timing.visualization.ns) * timing.segment.num) *
                             count;
  const __int128 denominator = static_cast<__int128>(timing.segment.num) * sum;
  return {static_cast<std::int64_t>((2 * numerator + denominator) / (2 * denominator))};
}

class FreeRunningTiming final : public StepTiming {
 public:
  explicit FreeRunningTiming(const ProgrammedTiming& timing)
      : timing_(timing),
        step_mean_(timing.step ? *timing.step : mean_filling_step(timing)),
        visualization_stream_(timing.seed, "timing.visualization"),
        step_stream_(timing.seed, "timing.step"),
        step_count_stream_(timing.seed, "timing.step_count") {
    const int most_steps = *std::max_element(timing.steps.begin(), timing.steps.end());
    assert(most_steps == 0 || step_mean_.ns > 0);
    assert(timing.visualization.ns > 0 || most_steps > 0);  // or time would stand still
    static_cast<void>(most_steps);
  }

  bool next(SegmentTiming& segment) override {
    segment.index = index_;
    segment.begin = end_;
    segment.visualization.reset();
    segment.steps.clear();

    if (!timing_.steps_first) append_visualization(segment);
    const auto step_count =
        timing_.steps[step_count_stream_.below(static_cast<std::uint64_t>(index_), timing_.steps.size())];
    for (int i = 0; i < step_count; ++i) {
      segment.steps.push_back(append(log_normal(step_stream_, step_number_++, step_mean_, timing_.step_variation)));
    }
    if (timing_.steps_first) append_visualization(segment);

    segment.end = end_;
    ++index_;
    return true;
  }

 private:
  Interval append(Duration duration) {
    const RealTime begin = std::exchange(end_, end_ + duration);
    return {begin, end_};
  }
  void append_visualization(SegmentTiming& segment) {
    if (timing_.visualization.ns == 0) return;
    const auto draw = static_cast<std::uint64_t>(index_);
    segment.visualization =
        append(log_normal(visualization_stream_, draw, timing_.visualization, timing_.visualization_variation));
  }

  ProgrammedTiming timing_;
  Duration step_mean_;
  RandomStream visualization_stream_;
  RandomStream step_stream_;
  RandomStream step_count_stream_;
  RealTime end_{};
  std::int64_t index_ = 0;
  std::uint64_t step_number_ = 0;
};

class ReplayedTiming final : public StepTiming {
 public:
  explicit ReplayedTiming(std::vector<SegmentTiming> segments) : segments_(std::move(segments)) {}

  bool next(SegmentTiming& segment) override {
    if (position_ == segments_.size()) return false;
    segment = segments_[position_++];
    return true;
  }

 private:
  std::vector<SegmentTiming> segments_;
  std::size_t position_ = 0;
};

}  // namespace

bool SegmentTiming::overlaps() const {
  if (!visualization) return false;
  return std::any_of(steps.begin(), steps.end(), [this](const Interval& step) {
    return std::max(step.begin, visualization->begin) < std::min(step.end, visualization->end);
  });
}

std::unique_ptr<StepTiming> make_programmed_timing(const ProgrammedTiming& timing) {
  assert(timing.segment.num > 0 && timing.segment.den > 0 && timing.visualization.ns >= 0 && !timing.steps.empty());
  assert(std::all_of(timing.steps.begin(), timing.steps.end(), [](int count) { return count >= 0; }));
  assert(!timing.step || timing.step->ns > 0);
  assert(timing.visualization_variation >= 0 && timing.step_variation >= 0);
  const bool periodic = timing.steps.size() == 1 && timing.visualization_variation == 0 && timing.step_variation == 0;
  if (periodic) return std::make_unique<PeriodicTiming>(timing);
  return std::make_unique<FreeRunningTiming>(timing);
}

std::unique_ptr<StepTiming> make_replayed_timing(std::vector<SegmentTiming> segments) {
  return std::make_unique<ReplayedTiming>(std::move(segments));
}

}  // namespace evenstep
