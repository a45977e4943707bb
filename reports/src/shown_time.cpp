#include "src/shown_time.h"

#include <algorithm>
#include <cmath>

namespace evenstep::internal {

Rows<std::size_t> shown_steps(const StrategyRecord& strategy, const Rows<std::size_t>& steps) {
  Rows<std::size_t> shown(steps.get_allocator());
  std::optional<RealTime> later;
  for (std::size_t i = steps.size(); i-- > 0;) {
    const StepRow& step = strategy.steps[steps[i]];
    if (step.lost || (later && *later <= ready(step))) continue;
    later = ready(step);
    shown.push_back(steps[i]);
  }
  std::reverse(shown.begin(), shown.end());
  return shown;
}

std::optional<AnimationError> animation_error(const StrategyRecord& strategy, const DeviceRecord& device,
                                              const Rows<std::size_t>& shown, const Rows<std::size_t>& ticks,
                                              double slot_s) {
  const auto simulated_s = [&](std::size_t i) { return simulation_time_s(strategy, shown[i], slot_s); };
  const auto row = [&](std::size_t i) -> const StepRow& { return strategy.steps[shown[i]]; };
  struct Frame {
    RealTime at;
    double simulated_s;
  };
  std::optional<Frame> before;
  std::size_t i = 0;
  AnimationError error;
  std::int64_t frames = 0;
  for (const std::size_t k : ticks) {
    const RealTime at = sent_at(device.ticks[k]);
    if (shown.empty() || ready(row(0)) > at) continue;
    while (i + 1 < shown.size() && ready(row(i + 1)) <= at) ++i;
    double now_s = simulated_s(i);
    // If forces are interpolated and the step has a slot: on the line to the next force that has come already.
    for (std::size_t j = i + 1; device.interpolates && j < shown.size() && row(i).mapped && row(j).begin <= at; ++j) {
      if (arrival(row(j)) > at) continue;
      const double way = seconds(row(j).emission - row(i).emission);
      now_s += (simulated_s(j) - now_s) * (seconds(at - row(i).emission) / way);
      break;
    }
    if (before && before->simulated_s == now_s) continue;
    if (before) {
      const double off_s = std::abs(now_s - before->simulated_s - seconds(at - before->at));
      error.max_s = std::max(error.max_s, off_s);
      error.mean_s += off_s;
      ++frames;
    }
    before = Frame{at, now_s};
  }
  if (frames == 0) return std::nullopt;
  error.mean_s /= static_cast<double>(frames);
  return error;
}

}  // namespace evenstep::internal
