#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "timing_models.h"

namespace evenstep::internal {
namespace {

/// How many steps a frame runs: what is due, or as many as frames have had before. The numbers are those of
/// ProgrammedTiming's description.
class StepsPerFrame {
 public:
  StepsPerFrame() {
    for (std::size_t frames = 0; frames < kWindows; ++frames) usual_[frames] = past_[frames] = std::int64_t(frames);
  }
  /// The next frame's number, from `least` to `most`; `due` lies between them.
  std::int64_t next(std::int64_t least, std::int64_t due, std::int64_t most) {
    std::int64_t low = usual_[0], high = low + 1;
    bool is_unusual = false;
    for (std::size_t frames = 1; frames < kWindows && !is_unusual; ++frames) {
      const std::int64_t missing = usual_[frames] - past_[frames - 1];  // in the window that ends with this frame
      is_unusual = missing > high || missing + 1 < low;
      if (is_unusual) break;
      low = std::max(low, missing);
      high = std::min(high, missing + 1);
    }
    const std::int64_t wanted = std::clamp(due, low, high), count = std::clamp(wanted, least, most);
    is_unusual = is_unusual || count != wanted;
    const std::int64_t steps = std::max<std::int64_t>(count, 0);
    for (std::size_t frames = kWindows - 1; frames > 0; --frames) past_[frames] = past_[frames - 1] + steps;
    past_[0] = steps;
    for (std::size_t frames = 0; frames < kWindows && is_unusual; ++frames)
      usual_[frames] = std::clamp(usual_[frames], past_[frames] - 1, past_[frames]);
    return steps;
  }

 private:
  static constexpr std::size_t kWindows = 12;        // Godot's CONTROL_STEPS
  std::array<std::int64_t, kWindows> usual_, past_;  // [i]: steps of i + 1 frames; `past_` of the last ones
};

class AccumulatorTiming final : public StepTiming {
 public:
  explicit AccumulatorTiming(const ProgrammedTiming& timing)
      : loop_(*timing.accumulator),
        steps_first_(timing.order == SegmentOrder::steps_first),
        grid_(timing.paced ? std::optional<Rate>(timing.segment) : std::nullopt),
        drift_per_s_(timing.drift_per_s),
        means_(timing),
        visualizations_(timing),
        turns_(timing),
        refresh_(timing.seed, "timing.refresh") {
    assert(timing.order != SegmentOrder::concurrent && timing.slowdown == 1 && timing.step);
    assert(loop_.step_rate.num > 0 && loop_.step_rate.den > 0 && (!loop_.max_steps || *loop_.max_steps > 0));
    assert(loop_.jitter_fix.ns >= 0 && loop_.jitter_fix.ns <= instant_ns(loop_.step_rate, 1));
    assert(timing.paced || (timing.visualization.ns > 0 && timing.dropped_visualization == 0));
  }

  bool next(SegmentTiming& segment) override {
    segment.index = index_;
    segment.begin = turns_.end = begin_;
    segment.visualization.reset();
    segment.steps.clear();
    segment.simulated.clear();
    segment.concurrent = false;
    const MeansInForce::Means& means = means_.at(segment.begin);
    const double drift = drift_factor(drift_per_s_, segment.begin);
    const std::optional<Duration> visualization = visualizations_.next(segment.begin, means.visualization, drift);
    if (!steps_first_) turns_.append_visualization(segment, visualization);
    for (std::int64_t left = steps_due(segment.begin); left > 0; --left) {
      segment.simulated.push_back(sim_time(loop_.step_rate, done_++));
      turns_.append_step(segment, means.step, drift);
    }
    if (steps_first_) turns_.append_visualization(segment, visualization);
    ++index_;
    segment.end = begin_ = next_begin();
    return true;
  }

 private:
  /// How many steps end at or before this time, in whole ns as all times: so steps as frequent as frames are one a frame.
  std::int64_t periods(RealTime at) const { return first_tick_at_or_after(loop_.step_rate, at + Duration{1}) - 1; }
  /// N of a frame that begins now. Steps that are dropped are counted as done.
  std::int64_t steps_due(RealTime now) {
    std::int64_t count = periods(now) - done_;
    if (loop_.jitter_fix.ns > 0)
      count = smoothed_.next(periods(now - loop_.jitter_fix) - done_, count, periods(now + loop_.jitter_fix) - done_);
    if (!loop_.max_steps || count <= *loop_.max_steps) return count;
    done_ += count - *loop_.max_steps;
    return *loop_.max_steps;
  }
  RealTime next_begin() {
    if (!grid_) return turns_.end;
    tick_ = std::max(tick_ + 1, first_tick_at_or_after(*grid_, turns_.end));
    const auto latest = static_cast<std::uint64_t>(loop_.refresh_jitter.ns) + 1;
    const Duration late{static_cast<std::int64_t>(refresh_.below(static_cast<std::uint64_t>(index_), latest))};
    return tick_time(*grid_, tick_) + late;
  }

  Accumulator loop_;
  bool steps_first_;
  std::optional<Rate> grid_;
  double drift_per_s_;
  MeansInForce means_;
  VisualizationCost visualizations_;
  Turns turns_;
  RandomStream refresh_;
  StepsPerFrame smoothed_;
  RealTime begin_;  // of the next frame
  std::int64_t index_ = 0, tick_ = 0;
  std::int64_t done_ = 0;  // steps run or dropped
};

}  // namespace

std::unique_ptr<StepTiming> make_accumulator_timing(const ProgrammedTiming& timing) {
  return std::make_unique<AccumulatorTiming>(timing);
}

}  // namespace evenstep::internal
