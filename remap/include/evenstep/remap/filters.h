#pragma once
/// Low-pass filters for a signal sampled at even times, the usual means of smoothing bunched forces or positions. The
/// paper rejects them (introduction: enough smoothing to hide the bursts also "dampens the desired haptic changes");
/// they are here so that this can be measured. Below, T = 1 / rate; x_n goes in and y_n comes out at once.
///
/// MovingAverage, n samples:  y = (x_i + x_i-1 + ... + x_i-n+1) / n
///   Gain |sin(pi f n T) / (n sin(pi f T))|, zero at multiples of 1 / (n T); group delay (n - 1) T / 2 at every
///   frequency (Smith, The Scientist and Engineer's Guide to DSP, 1997, ch. 15); -3 dB at 0.443 / (T sqrt(n^2 - 1)),
///   to 3 % from n = 2.
/// Butterworth, second order, cutoff f_c:  1 / (s^2 + sqrt(2) s + 1) at s = (1 - z^-1) / (g (1 + z^-1))
///   The bilinear transform, pre-warped by g = tan(pi f_c T), so that the -3 dB point is f_c itself (Oppenheim and
///   Schafer, Discrete-Time Signal Processing, ch. 7). Group delay T / (sqrt(2) g) at 0 Hz, about 0.225 / f_c. Computed
///   as two trapezoidal integrators (Zavalishin, The Art of VA Filter Design, ch. 4): in exact arithmetic this equals the
///   direct form, but it does not lose digits where f_c T is small.
/// OneEuro (Casiez, Roussel, Vogel: 1 Euro Filter, CHI 2012, algorithm 1): a first-order low-pass with
///   a(f) = w / (1 + w), w = 2 pi f T, whose cutoff follows the speed:
///     d <- d + a(derivative_cutoff) ((x - y) / T - d),    f = min_cutoff + beta |d|,    y <- y + a(f) (x - y)
///   The difference is taken to the previous *filtered* value, as published (and as in the authors' code since 2023;
///   older copies take the raw one). For a vector, |d| is the norm: all components share one cutoff, whatever the axes. At
///   steady speed v the lag is |v| / (2 pi f) and d = v / a(f): f^2 - (min_cutoff + beta |v|) f = beta |v| / (2 pi T).
///   At a fixed f: group delay 1 / (2 pi f) at 0 Hz; with b = 1 - a the gain a / sqrt(1 - 2 b cos(2 pi f' T) + b^2) is
///   -3 dB at cos(2 pi f' T) = 1 - a^2 / (2 b), which is f where f T is small, and nowhere for a > 2 (sqrt(2) - 1).
///
/// The filter starts as if the first sample had been its input for ever: that sample comes out unchanged, without a
/// start-up transient. A constant input comes out with the very same bits for ever. Coefficients and states have the same
/// bits on every machine (no libm). Value types: see sample.h. A sample that is not finite stays in the state for ever
/// (in that of MovingAverage for n samples).

#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <variant>
#include <vector>

#include "evenstep/remap/sample.h"
#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr int kMaxAveragedSamples = 100'000;  ///< a limit, because every next() goes over all of them

struct MovingAverageSpec {
  int samples = 1;  ///< 1 to kMaxAveragedSamples; 1 changes nothing
};
struct ButterworthSpec {
  double cutoff_Hz = 0;  ///< above 0, below rate / 2
};
struct OneEuroSpec {
  double min_cutoff_Hz = 0;         ///< above 0, without an upper limit: beyond rate / 2 it hardly filters
  double beta = 0;                  ///< Hz per unit of speed (of metres: 1/m); 0 or more
  double derivative_cutoff_Hz = 0;  ///< above 0
};
using FilterSpec = std::variant<MovingAverageSpec, ButterworthSpec, OneEuroSpec>;

/// Whether the parameters are within the limits above. Making a filter from any others is a programming error (asserted).
bool in_domain(const FilterSpec& spec, Rate rate);

/// The time after which less than a billionth of an input is left in the output. MovingAverage: n T. Butterworth: its poles
/// shrink by sqrt((1 - sqrt(2) g + g^2) / (1 + sqrt(2) g + g^2)) per sample. OneEuro: the time for its smallest cutoff plus
/// that for the cutoff of the derivative; each shrinks by 1 - a(f) per sample.
Duration settling_time(const FilterSpec& spec, Rate rate);

/// The magnitude of a value: |x|, or the Euclidean norm of a std::array of values or of a vector with members x, y, z.
/// Specialize it to use OneEuro with other types.
template <class Value>
struct Norm {
  double operator()(const Value& value) const {
    if constexpr (std::is_arithmetic_v<Value>) {
      return std::abs(static_cast<double>(value));
    } else {
      return std::sqrt(value.x * value.x + value.y * value.y + value.z * value.z);
    }
  }
};
template <class Value, std::size_t N>
struct Norm<std::array<Value, N>> {
  double operator()(const std::array<Value, N>& value) const {
    double squares = 0;
    for (const Value& part : value) {
      const double norm = Norm<Value>()(part);
      squares += norm * norm;
    }
    return std::sqrt(squares);
  }
};

namespace internal {

/// a + w b
template <class Value>
Value plus_scaled(const Value& a, const Value& b, double w) {
  return a + b * w;
}
template <class Value, std::size_t N>
std::array<Value, N> plus_scaled(const std::array<Value, N>& a, const std::array<Value, N>& b, double w) {
  std::array<Value, N> result{};
  for (std::size_t i = 0; i < N; ++i) result[i] = plus_scaled(a[i], b[i], w);
  return result;
}
template <class Value>
Value difference(const Value& a, const Value& b) {
  return plus_scaled(a, b, -1.0);
}

/// With g = tan(pi cutoff / rate): a1 = 1 / (1 + sqrt(2) g + g^2), a2 = g a1, a3 = g a2.
struct ButterworthCoefficients {
  double a1, a2, a3;
};
ButterworthCoefficients butterworth_coefficients(double cutoff_Hz, Rate rate);

/// a(f) = w / (1 + w), w = 2 pi f / rate.
double smoothing_factor(double cutoff_Hz, double rate_Hz);

inline double hertz(Rate rate) { return static_cast<double>(rate.num) / static_cast<double>(rate.den); }

template <class Value>
class MovingAverage {
 public:
  MovingAverage(const MovingAverageSpec& spec, Rate) : window_(static_cast<std::size_t>(spec.samples)) {}

  /// The newest value plus the mean of the differences from it, oldest first. The sum is formed anew each time, so
  /// rounding errors do not accumulate.
  Value next(const Value& x) {
    if (!started_) window_.assign(window_.size(), x);
    started_ = true;
    window_[oldest_] = x;
    oldest_ = (oldest_ + 1) % window_.size();
    Value sum{};
    for (std::size_t age = 0; age < window_.size(); ++age)
      sum = plus_scaled(sum, difference(window_[(oldest_ + age) % window_.size()], x), 1.0);
    return plus_scaled(x, sum, 1.0 / static_cast<double>(window_.size()));
  }

 private:
  std::vector<Value> window_;
  std::size_t oldest_ = 0;
  bool started_ = false;
};

template <class Value>
class Butterworth {
 public:
  Butterworth(const ButterworthSpec& spec, Rate rate) : a_(butterworth_coefficients(spec.cutoff_Hz, rate)) {}

  /// band = (s1 + g (x - s2)) a1 and low = s2 + g band solve both trapezoidal integrators at once; their states then
  /// move on to 2 band - s1 and 2 low - s2.
  Value next(const Value& x) {
    if (!started_) state_2_ = x;
    started_ = true;
    const Value error = difference(x, state_2_);
    const Value band = plus_scaled(plus_scaled(Value{}, state_1_, a_.a1), error, a_.a2);
    const Value low = plus_scaled(plus_scaled(state_2_, state_1_, a_.a2), error, a_.a3);
    state_1_ = plus_scaled(difference(band, state_1_), band, 1.0);
    state_2_ = plus_scaled(difference(low, state_2_), low, 1.0);
    return low;
  }

 private:
  ButterworthCoefficients a_;
  Value state_1_{}, state_2_{};  // of the integrators: band, low
  bool started_ = false;
};

template <class Value>
class OneEuro {
 public:
  OneEuro(const OneEuroSpec& spec, Rate rate)
      : spec_(spec), rate_Hz_(hertz(rate)), derivative_factor_(smoothing_factor(spec.derivative_cutoff_Hz, rate_Hz_)) {}

  Value next(const Value& x) {
    if (!started_) filtered_ = x;
    started_ = true;
    const Value derivative = plus_scaled(Value{}, difference(x, filtered_), rate_Hz_);
    derivative_ = lerp(derivative_, derivative, derivative_factor_);
    const double cutoff_Hz = spec_.min_cutoff_Hz + spec_.beta * Norm<Value>()(derivative_);
    filtered_ = lerp(filtered_, x, smoothing_factor(cutoff_Hz, rate_Hz_));
    return filtered_;
  }

 private:
  OneEuroSpec spec_;
  double rate_Hz_, derivative_factor_;
  Value filtered_{}, derivative_{};  // units, units per second
  bool started_ = false;
};

}  // namespace internal

template <class Value>
class Filter {
 public:
  /// Takes the next of the evenly spaced samples and returns the filtered value. Does not allocate.
  Value next(const Value& x) {
    return std::visit([&x](auto& kind) { return kind.next(x); }, kind_);
  }

 private:
  using Kind = std::variant<internal::MovingAverage<Value>, internal::Butterworth<Value>, internal::OneEuro<Value>>;
  explicit Filter(Kind kind) : kind_(std::move(kind)) {}
  template <class V>
  friend Filter<V> make_filter(const FilterSpec& spec, Rate rate);
  Kind kind_;
};

/// A filter in its initial state, for samples that come at `rate`.
template <class Value>
Filter<Value> make_filter(const FilterSpec& spec, Rate rate) {
  assert(in_domain(spec, rate));
  if (const auto* average = std::get_if<MovingAverageSpec>(&spec))
    return Filter<Value>(internal::MovingAverage<Value>(*average, rate));
  if (const auto* butterworth = std::get_if<ButterworthSpec>(&spec))
    return Filter<Value>(internal::Butterworth<Value>(*butterworth, rate));
  return Filter<Value>(internal::OneEuro<Value>(std::get<OneEuroSpec>(spec), rate));
}

}  // namespace evenstep
