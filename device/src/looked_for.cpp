#include "evenstep/device/looked_for.h"

#include <algorithm>

namespace evenstep {

std::optional<RealTime> found_again(RealTime lost, RealTime returns) {
  const std::int64_t away_ns = std::max<std::int64_t>(1, (returns - lost).ns);
  const std::int64_t looks = (away_ns + kLookAgain.ns - 1) / kLookAgain.ns;
  if (looks > kPatience.ns / kLookAgain.ns) return std::nullopt;
  return lost + Duration{looks * kLookAgain.ns};
}

}  // namespace evenstep
