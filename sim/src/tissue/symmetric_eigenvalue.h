#pragma once
/// The largest eigenvalue of a small symmetric matrix, by Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace evenstep::internal {

template <std::size_t N>
struct SymmetricMatrix {
  double& operator()(std::size_t row, std::size_t column) { return values[row * N + column]; }
  double operator()(std::size_t row, std::size_t column) const { return values[row * N + column]; }
  std::array<double, N * N> values{};
};

template <std::size_t N>
double largest_eigenvalue(SymmetricMatrix<N> a) {
  for (int sweep = 0; sweep < 30; ++sweep) {  // converges quadratically: 6 to 10 are enough
    double off_diagonal = 0, diagonal = 0;
    for (std::size_t p = 0; p < N; ++p) {
      diagonal += a(p, p) * a(p, p);
      for (std::size_t q = p + 1; q < N; ++q) off_diagonal += a(p, q) * a(p, q);
    }
    if (off_diagonal <= 1e-34 * diagonal) break;
    for (std::size_t p = 0; p < N; ++p) {
      for (std::size_t q = p + 1; q < N; ++q) {
        if (a(p, q) == 0) continue;
        const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
        const double t = std::copysign(1 / (std::abs(theta) + std::sqrt(theta * theta + 1)), theta);
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (std::size_t r = 0; r < N; ++r) {
          const double rp = a(r, p), rq = a(r, q);
          a(r, p) = c * rp - s * rq;
          a(r, q) = s * rp + c * rq;
        }
        for (std::size_t r = 0; r < N; ++r) {
          const double pr = a(p, r), qr = a(q, r);
          a(p, r) = c * pr - s * qr;
          a(q, r) = s * pr + c * qr;
        }
      }
    }
  }
  double largest = a(0, 0);
  for (std::size_t p = 1; p < N; ++p) largest = std::max(largest, a(p, p));
  return largest;
}

}  // namespace evenstep::internal
