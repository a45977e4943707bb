#pragma once
/// The little vector arithmetic that measures need, what they return where there is no value, and a maximum that never hides
/// a NaN.

#include <cmath>
#include <limits>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

inline Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline double norm(const Vec3& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

/// Running maximum of numbers >= 0. Once NaN, always NaN: std::max would drop it, and a NaN must never pass a limit.
struct Peak {
  double value = 0;
  void add(double v) {
    if (!(v <= value) && !std::isnan(value)) value = v;
  }
};

}  // namespace evenstep::internal
