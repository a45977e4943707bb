#include "evenstep/device/symmetric.h"

#include <algorithm>
#include <cmath>

namespace evenstep {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

/// a <- J' a J and v <- v J, where J is the rotation in the plane (p, q) that makes a[p][q] zero.
void rotate(Matrix& a, Matrix& v, std::size_t p, std::size_t q) {
  if (a[p][q] == 0) return;
  const double ratio = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  // The smaller of the two roots, which turns by at most 45 degrees. If the square overflows it is 0, which is right.
  const double t = (ratio < 0 ? -1 : 1) / (std::abs(ratio) + std::sqrt(ratio * ratio + 1));
  const double c = 1 / std::sqrt(t * t + 1), s = t * c;
  const std::size_t r = 3 - p - q;
  const double off = a[p][q], rp = a[r][p], rq = a[r][q];
  a[p][p] -= t * off;
  a[q][q] += t * off;
  a[p][q] = a[q][p] = 0;
  a[r][p] = a[p][r] = c * rp - s * rq;
  a[r][q] = a[q][r] = s * rp + c * rq;
  for (auto& row : v) {
    const double vp = row[p], vq = row[q];
    row[p] = c * vp - s * vq;
    row[q] = s * vp + c * vq;
  }
}

}  // namespace

Axes axes_of(const Symmetric& k) {
  Matrix a{{{k.xx, k.xy, k.xz}, {k.xy, k.yy, k.yz}, {k.xz, k.yz, k.zz}}};
  Matrix v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  // It converges quadratically: five or six sweeps are enough.
  for (int sweep = 0; sweep < 12; ++sweep) {
    const double beside = std::abs(a[0][1]) + std::abs(a[0][2]) + std::abs(a[1][2]);
    const double on = std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]);
    if (on + beside == on) break;
    rotate(a, v, 0, 1);
    rotate(a, v, 0, 2);
    rotate(a, v, 1, 2);
  }
  Axes axes;
  for (std::size_t i = 0; i < 3; ++i) {
    axes.values[i] = a[i][i];
    axes.axes[i] = {v[0][i], v[1][i], v[2][i]};
  }
  return axes;
}

double largest_value(const Axes& of) {
  const auto [x, y, z] = of.values;
  return std::isfinite(x + y + z) ? std::max({x, y, z}) : x + y + z;
}

}  // namespace evenstep
