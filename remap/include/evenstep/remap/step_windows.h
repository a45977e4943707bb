#pragma once
/// Parts of a run that begin every so often: what a map that tracks has to hold through, where a line through a whole run
/// would have to hold its whole drift (docs/numerics.md).

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr Duration kSizingWindow{250'000'000};

/// [from, to) positions of the steps that begin in each window, from the first step on; the next window begins with the
/// first step behind it. The last one is left out unless it is whole (a step begins behind it) or the only one.
/// `Step` has a `begin`; steps in order.
template <class Step>
std::vector<std::pair<std::size_t, std::size_t>> step_windows(std::span<const Step> steps, Duration length = kSizingWindow) {
  std::vector<std::pair<std::size_t, std::size_t>> windows;
  for (std::size_t from = 0; from < steps.size();) {
    const RealTime end = steps[from].begin + length;
    std::size_t to = from;
    while (to < steps.size() && steps[to].begin < end) ++to;
    if (to == steps.size() && !windows.empty()) break;
    windows.emplace_back(from, to);
    from = to;
  }
  return windows;
}

}  // namespace evenstep
