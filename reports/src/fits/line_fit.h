#pragma once
/// Windows of a series and the residual of the least-squares line in each.

#include <cstddef>
#include <span>
#include <vector>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// Length of the windows of a run's signals.
inline constexpr double kWindow_s = 0.25;

struct Window {
  std::size_t begin = 0, end = 0;  ///< samples [begin, end)
  std::size_t size() const { return end - begin; }
};

/// Non-overlapping windows of `window_s` from t[0] on; a sample on a boundary belongs to the next window. A remainder that
/// covers less than half a window is added to the window before.
std::vector<Window> windows(std::span<const double> t, double window_s);

/// The windows of all pieces; each piece begins a new window.
std::vector<Window> windows(std::span<const double> t, std::span<const Window> pieces, double window_s);

/// x minus its least-squares line over t.
std::vector<Vec3> line_residual(std::span<const double> t, std::span<const Vec3> x);

}  // namespace evenstep::internal
