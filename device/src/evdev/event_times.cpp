#include "evenstep/device/evdev/event_times.h"

#include <algorithm>

namespace evenstep {
namespace {

constexpr Duration kOldest{1'000'000'000};
constexpr Duration kFarthest{3'600'000'000'000};  // so that the difference of two times cannot overflow

}  // namespace

RealTime EventTimes::taken(RealTime read) const { return taken_.value_or(read - Duration{2 * kOldest.ns}); }

void EventTimes::changed(RealTime event, RealTime read) {
  const Duration age{read.ns - std::clamp(event.ns, read.ns - kFarthest.ns, read.ns + kFarthest.ns)};
  RealTime taken = read - age;
  if (age.ns < 0) {
    ++ages_.ahead;
    ages_.ahead_max = std::max(ages_.ahead_max, Duration{-age.ns});
    taken = read;
  }
  bool is_moved = false;
  if (age > kOldest) {
    taken = read - std::min(unchanged_age_, kOldest);
    is_moved = true;
  }
  if (taken_ && taken <= *taken_) {
    taken = std::min(*taken_ + Duration{1}, read);
    is_moved = true;
  }
  ages_.capped += is_moved;
  taken_ = taken;
  ages_.ages.add(read - taken);
}

bool EventTimes::unchanged(RealTime read) {
  const RealTime holds = read - std::min(unchanged_age_, kOldest);
  if (taken_ && holds <= *taken_) return false;
  taken_ = holds;
  return true;
}

}  // namespace evenstep
