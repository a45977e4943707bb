#include "evenstep/remap/resampler.h"

#include <cmath>
#include <numbers>

#include "evenstep/time/reproducible_math.h"

namespace evenstep::internal {
namespace {

/// The modified Bessel function of order 0, by its series sum ((x/2)^k / k!)^2; for 0 <= x <= 6 each term from the tenth on
/// is less than half of the one before.
double bessel_i0(double x) {
  double term = 1, sum = 1;
  for (int k = 1; term > sum * 1e-17; ++k) {
    term *= x / (2 * k) * (x / (2 * k));
    sum += term;
  }
  return sum;
}

}  // namespace

double windowed_sinc(double u, int taps) {
  const double edge = u / taps;
  if (!(edge > -1 && edge < 1)) return 0;
  constexpr double kBeta = 6;
  static const double whole = bessel_i0(kBeta);
  const double window = bessel_i0(kBeta * std::sqrt(1 - edge * edge)) / whole;
  return u == 0 ? window : reproducible::sin(std::numbers::pi * u) / (std::numbers::pi * u) * window;
}

}  // namespace evenstep::internal
