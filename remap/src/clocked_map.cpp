#include "evenstep/remap/maps/clocked_map.h"

#include <algorithm>
#include <utility>

namespace evenstep {

std::optional<RealTime> ClockedMap::slot(std::int64_t n) {
  const SimTime own = sim_time(clock_.step_rate, n);
  if (const std::optional<SimTime> t = std::exchange(told_, std::nullopt)) {
    const Duration ahead{t->ns - own.ns};
    if (!ahead_) ahead_ = ahead;
    dropped_ = ahead - *ahead_;
  }
  moved_ = moved_ + std::clamp(dropped_ - moved_, Duration{-clock_.most.ns}, clock_.most);
  return origin_ + Duration{own.ns} + moved_;
}

}  // namespace evenstep
