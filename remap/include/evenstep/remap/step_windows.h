#pragma once
/// Cuts a run into windows of equal length. A map that tracks its timing has to stay straight only for the length of such
/// a window, whereas a straight line through the whole run would have to absorb all of its drift (docs/choose/numerics.md).

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr Duration kSizingWindow{250'000'000};

/// Finds the windows one step at a time.
class WindowBorder {
 public:
  explicit WindowBorder(Duration length = kSizingWindow) : length_(length) {}
  /// Whether a step that begins at `begin` is the first of a window. The very first step always is. Call in step order.
  bool begins(RealTime begin) {
    if (begin < end_) return false;
    end_ = begin + length_;
    return true;
  }

 private:
  Duration length_;
  RealTime end_{INT64_MIN};  // of the current window
};

/// The positions [from, to) of the steps that begin in each window. The first window begins with the first step, each
/// further one with the first step after the window before it. The last window is left out if no step follows it (it may
/// be incomplete), unless it is the only one. `Step` has a member `begin`; steps in order.
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
