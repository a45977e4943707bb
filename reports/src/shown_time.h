#pragma once
/// Which simulation time a device shows at a tick, and the animation error that follows from it (docs/reference/metrics.md).

#include <algorithm>
#include <cstddef>
#include <optional>

#include "src/judged.h"

namespace evenstep::internal {

/// When a force can first be sent: when it is due and has come. Without slots, a force is due when it comes.
inline RealTime ready(const StepRow& step) {
  return step.mapped || step.transport.ns == 0 ? std::max(step.emission, arrival(step)) : arrival(step);
}

/// Those of these steps, in order, whose force comes and can be sent before that of any later one.
Rows<std::size_t> shown_steps(const StrategyRecord& strategy, const Rows<std::size_t>& steps);

/// Largest and mean absolute value of (Z(t) - Z(t')) - (t - t') over the frames: the judged ticks t that show another
/// simulation time Z than the tick before; t' is the frame before. Empty without two frames.
struct AnimationError {
  double max_s = 0, mean_s = 0;
};
std::optional<AnimationError> animation_error(const StrategyRecord& strategy, const DeviceRecord& device,
                                              const Rows<std::size_t>& shown, const Rows<std::size_t>& ticks, double slot_s);

}  // namespace evenstep::internal
