#include "evenstep/device/symmetric.h"

#include <algorithm>
#include <cmath>

namespace evenstep {
namespace {

template <std::size_t N>
using Matrix = std::array<std::array<double, N>, N>;

/// a <- J' a J and v <- v J, where J is the rotation in the plane (p, q) that makes a[p][q] zero.
template <std::size_t N>
void rotate(Matrix<N>& a, Matrix<N>& v, std::size_t p, std::size_t q) {
  if (a[p][q] == 0) return;
  const double ratio = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  // The smaller of the two roots, which turns by at most 45 degrees. If the square overflows, the root is 0, which is right.
  const double t = (ratio < 0 ? -1 : 1) / (std::abs(ratio) + std::sqrt(ratio * ratio + 1));
  const double c = 1 / std::sqrt(t * t + 1), s = t * c;
  const double off = a[p][q];
  a[p][p] -= t * off;
  a[q][q] += t * off;
  a[p][q] = a[q][p] = 0;
  for (std::size_t r = 0; r < N; ++r) {
    if (r == p || r == q) continue;
    const double rp = a[r][p], rq = a[r][q];
    a[r][p] = a[p][r] = c * rp - s * rq;
    a[r][q] = a[q][r] = s * rp + c * rq;
  }
  for (auto& row : v) {
    const double vp = row[p], vq = row[q];
    row[p] = c * vp - s * vq;
    row[q] = s * vp + c * vq;
  }
}

/// Makes `a` diagonal. The columns of the result are the axes.
template <std::size_t N>
Matrix<N> diagonalised(Matrix<N>& a) {
  Matrix<N> v{};
  for (std::size_t i = 0; i < N; ++i) v[i][i] = 1;
  // It converges quadratically: five or six sweeps are enough.
  for (int sweep = 0; sweep < 12; ++sweep) {
    double beside = 0, on = 0;
    for (std::size_t p = 0; p < N; ++p) {
      on += std::abs(a[p][p]);
      for (std::size_t q = p + 1; q < N; ++q) beside += std::abs(a[p][q]);
    }
    if (on + beside == on) break;
    for (std::size_t p = 0; p < N; ++p)
      for (std::size_t q = p + 1; q < N; ++q) rotate<N>(a, v, p, q);
  }
  return v;
}

}  // namespace

Axes axes_of(const Symmetric& k) {
  Matrix<3> a{{{k.xx, k.xy, k.xz}, {k.xy, k.yy, k.yz}, {k.xz, k.yz, k.zz}}};
  const Matrix<3> v = diagonalised<3>(a);
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

Joint joint_of(const Symmetric& first, const glm::dmat3& coupling, const Symmetric& second) {
  const auto rows = [](const Symmetric& k) {
    return Matrix<3>{{{k.xx, k.xy, k.xz}, {k.xy, k.yy, k.yz}, {k.xz, k.yz, k.zz}}};
  };
  const Matrix<3> one = rows(first), two = rows(second);
  Joint joint{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      joint[r][c] = one[r][c];
      joint[3 + r][3 + c] = two[r][c];
      joint[r][3 + c] = joint[3 + c][r] = coupling[static_cast<int>(c)][static_cast<int>(r)];
    }
  }
  return joint;
}

JointAxes joint_axes_of(const Joint& k) {
  JointAxes axes;
  Joint a = k;
  axes.axes = diagonalised<6>(a);
  for (std::size_t i = 0; i < 6; ++i) axes.values[i] = a[i][i];
  return axes;
}

double largest_value(const JointAxes& of) {
  double sum = 0, most = of.values[0];
  for (const double value : of.values) {
    sum += value;
    most = std::max(most, value);
  }
  return std::isfinite(sum) ? most : sum;
}

}  // namespace evenstep
