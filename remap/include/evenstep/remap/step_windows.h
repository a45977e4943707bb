#pragma once
/// Parts of a run that begin every so often: what a map that tracks has to hold through, where a line through a whole run
/// would have to hold its whole drift (docs/numerics.md).

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr Duration kSizingWindow{250'000'000};

/// The same, one step more at a time.
class WindowBorder {
 public:
  explicit WindowBorder(Duration length = kSizingWindow) : length_(length) {}
  /// Does the step that begins then begin a window? The first one does. Steps in order.
  bool begins(RealTime begin) {
    if (begin < end_) return false;
    end_ = begin + length_;
    return true;
  }

 private:
  Duration length_;
  RealTime end_{INT64_MIN};   // of the running window
};

/// [from, to) positions of the steps that begin in each window, from the first step on; the next window begins with the
/// first step behind it. The last one is left out unless it is whole (a step begins behind it) or the only one.
/// `Step` has a `begin`; steps in order.
template <class Step>
std::vector<std::pair<std::size_t, std::size_t>> step_windows(std::span<const Step> steps, Duration length = kSizingWindow) {
  std::vector<std::pair<std::size_t, std::size_t>> windows;
  WindowBorder border(length);
  std::size_t from = 0;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    if (!border.begins(steps[n].begin) || n == 0) continue;
    windows.emplace_back(from, n);
    from = n;
  }
  if (windows.empty() && !steps.empty()) windows.emplace_back(from, steps.size());
  return windows;
}

}  // namespace evenstep
