#pragma once
/// How a program looks for a device that was unplugged: at equal intervals, for a limited time.

#include <optional>

#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr Duration kLookAgain{250'000'000};
/// If a cable is plugged in again within this time, a run goes on.
inline constexpr Duration kPatience{10'000'000'000};

/// When a device that was lost at `lost` and is there again from `returns` on is found: at the first of the instants lost +
/// k * kLookAgain, k >= 1, that is not before `returns`. Empty: not within kPatience. (The first look, at once, finds
/// nothing that could have been plugged in.)
std::optional<RealTime> found_again(RealTime lost, RealTime returns);

}  // namespace evenstep
