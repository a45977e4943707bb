#include "evenstep/time/reproducible_math.h"

#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <limits>

#ifdef __FAST_MATH__
#error "reproducible_math needs IEEE arithmetic as written: build it without -ffast-math"
#endif
static_assert(FLT_EVAL_METHOD == 0, "intermediates must be rounded to double (x87 would keep 80 bits)");
static_assert(std::numeric_limits<double>::is_iec559);

namespace evenstep::reproducible {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ln 2 = high + low; high has 32 significant bits, so that k * high is exact for |k| < 2^21.
constexpr double kLn2High = 0x1.62e42feep-1;
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;

// pi / 2 in three parts of at most 33 bits, so that k * part is exact for |k| < 2^20 (1e6 rad is 636,620 quarter turns),
// and a tail; an error of 2^-157 remains. Doubles below 1e6 come as near as 6.2e-19 = 2^-60 to a multiple of pi / 2 (all
// 636,619 multiples were tried), so k times that error, 2^-137, is far below an ulp of any result, 2^-113.
constexpr double kHalfPi1 = 0x1.921fb544p+0;
constexpr double kHalfPi2 = 0x1.0b4611a6p-34;
constexpr double kHalfPi3 = 0x1.3198a2ep-69;
constexpr double kHalfPiTail = 0x1.b839a252049c1p-104;

/// The integer nearest to x (halves away from zero), |x| < 2^31.
std::int64_t nearest(double x) { return static_cast<std::int64_t>(x < 0 ? x - 0.5 : x + 0.5); }

/// 2^k for a normal result.
double power_of_two(std::int64_t k) { return std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52); }

/// An unevaluated sum: high is the rounded sum, low is what the rounding lost.
struct Sum {
  double high, low;
};

/// Knuth's two-sum: high + low == a + b exactly, whichever is larger.
Sum exact_sum(double a, double b) {
  const double high = a + b;
  const double b_seen = high - a;
  const double a_seen = high - b_seen;
  return {high, (a - a_seen) + (b - b_seen)};
}

/// x = quarter_turns * pi / 2 + (angle.high + angle.low), |angle| <= pi / 4 (Cody and Waite with exact remainders).
struct Reduced {
  std::int64_t quarter_turns;
  Sum angle;
};

Reduced reduce(double x) {
  constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
  const std::int64_t turns = nearest(x * kTwoOverPi);
  if (turns == 0) return {0, {x, 0.0}};
  const double k = static_cast<double>(turns);
  const double first = x - k * kHalfPi1;  // exact: the two are within a factor of two of each other (Sterbenz)
  const Sum second = exact_sum(first, -(k * kHalfPi2));
  const Sum third = exact_sum(second.high, -(k * kHalfPi3));
  return {turns, exact_sum(third.high, (second.low + third.low) - k * kHalfPiTail)};
}

/// sin on |angle| <= pi / 4: Taylor to r^17; the term left out is below 2e-19 of the result.
double sin_near_zero(Sum angle) {
  const double r = angle.high;
  if (std::abs(r) < 0x1p-27) return r;  // r^3 / 6 is under half an ulp; keeps -0.0 and subnormals
  const double z = r * r;
  double series = 1.0 / 355687428096000.0;  // 1 / 17!
  series = series * z - 1.0 / 1307674368000.0;
  series = series * z + 1.0 / 6227020800.0;
  series = series * z - 1.0 / 39916800.0;
  series = series * z + 1.0 / 362880.0;
  series = series * z - 1.0 / 5040.0;
  series = series * z + 1.0 / 120.0;
  series = series * z - 1.0 / 6.0;
  return r + (angle.low * (1.0 - 0.5 * z) + r * z * series);
}

/// cos on |angle| <= pi / 4: Taylor to r^16; the term left out is below 3e-18 of the result.
double cos_near_zero(Sum angle) {
  const double r = angle.high;
  const double z = r * r;
  double series = 1.0 / 20922789888000.0;  // 1 / 16!
  series = series * z - 1.0 / 87178291200.0;
  series = series * z + 1.0 / 479001600.0;
  series = series * z - 1.0 / 3628800.0;
  series = series * z + 1.0 / 40320.0;
  series = series * z - 1.0 / 720.0;
  series = series * z + 1.0 / 24.0;
  const double half = 0.5 * z;
  const double rounded = 1.0 - half;  // its rounding error goes back in below
  return rounded + (((1.0 - rounded) - half) + (z * z * series - r * angle.low));
}

bool out_of_trigonometric_domain(double x) { return !(std::abs(x) <= 1e6); }

}  // namespace

double exp(double x) {
  if (std::isnan(x)) return kNaN;
  if (x > 700.0) return kInfinity;
  if (x < -700.0) return 0.0;
  constexpr double kLog2E = 0x1.71547652b82fep+0;
  const std::int64_t k = nearest(x * kLog2E);
  const double k_real = static_cast<double>(k);
  const double high = x - k_real * kLn2High;  // exact, as in reduce()
  const double low = k_real * kLn2Low;
  const double r = high - low;  // |r| <= ln 2 / 2
  // Taylor to r^13; the term left out is below 5e-18.
  double series = 1.0 / 6227020800.0;  // 1 / 13!
  series = series * r + 1.0 / 479001600.0;
  series = series * r + 1.0 / 39916800.0;
  series = series * r + 1.0 / 3628800.0;
  series = series * r + 1.0 / 362880.0;
  series = series * r + 1.0 / 40320.0;
  series = series * r + 1.0 / 5040.0;
  series = series * r + 1.0 / 720.0;
  series = series * r + 1.0 / 120.0;
  series = series * r + 1.0 / 24.0;
  series = series * r + 1.0 / 6.0;
  series = series * r + 0.5;
  const double r_lost = (high - r) - low;  // what rounding r lost: first order is enough
  return (1.0 + (r + (r * r * series + r_lost))) * power_of_two(k);
}

double log(double x) {
  if (!(x > 0.0) || x > std::numeric_limits<double>::max()) return kNaN;
  std::int64_t k = 0;
  if (x < std::numeric_limits<double>::min()) {  // subnormal: exact scaling to a normal number
    x *= 0x1p54;
    k = -54;
  }
  // x = 2^k * m with m in [sqrt(1/2), sqrt(2)), so that log(m) is small where k is 0 and nothing cancels.
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  k += static_cast<std::int64_t>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  if (m >= 0x1.6a09e667f3bcdp+0) {
    m *= 0.5;
    ++k;
  }
  // With f = m - 1 (exact) and s = f / (2 + f): log(1 + f) = 2 atanh(s) = 2 s + s z R, z = s^2, and 2 s = f - s f, so
  // log(1 + f) = f - (f^2 / 2 - s (f^2 / 2 + z R)). Series to s^21; the term left out is below 1e-18 of the result.
  const double f = m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  double series = 2.0 / 21.0;
  series = series * z + 2.0 / 19.0;
  series = series * z + 2.0 / 17.0;
  series = series * z + 2.0 / 15.0;
  series = series * z + 2.0 / 13.0;
  series = series * z + 2.0 / 11.0;
  series = series * z + 2.0 / 9.0;
  series = series * z + 2.0 / 7.0;
  series = series * z + 2.0 / 5.0;
  series = series * z + 2.0 / 3.0;
  const double half_square = 0.5 * f * f;
  const double k_real = static_cast<double>(k);
  const double small = s * (half_square + z * series) + k_real * kLn2Low;
  return k_real * kLn2High - ((half_square - small) - f);
}

double sin(double x) {
  if (out_of_trigonometric_domain(x)) return kNaN;
  const Reduced reduced = reduce(x);
  const double value = (reduced.quarter_turns & 1) ? cos_near_zero(reduced.angle) : sin_near_zero(reduced.angle);
  return (reduced.quarter_turns & 2) ? -value : value;
}

double cos(double x) {
  if (out_of_trigonometric_domain(x)) return kNaN;
  const Reduced reduced = reduce(x);
  const double value = (reduced.quarter_turns & 1) ? sin_near_zero(reduced.angle) : cos_near_zero(reduced.angle);
  return ((reduced.quarter_turns + 1) & 2) ? -value : value;
}

}  // namespace evenstep::reproducible
