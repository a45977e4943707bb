#include "evenstep/remap/filters.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "evenstep/time/reproducible_math.h"

namespace evenstep {
namespace internal {
namespace {

/// g = tan(pi f_c T)
double warped(double cutoff_Hz, Rate rate) {
  const double angle = std::numbers::pi * (cutoff_Hz / hertz(rate));  // dividing first, it cannot round past the pole of tan
  return reproducible::sin(angle) / reproducible::cos(angle);
}

}  // namespace
}  // namespace internal

namespace {

bool positive(double value) { return value > 0 && std::isfinite(value); }

bool within(const MovingAverageSpec& spec, double) { return spec.samples >= 1 && spec.samples <= kMaxAveragedSamples; }
bool within(const ButterworthSpec& spec, double rate_Hz) { return positive(spec.cutoff_Hz) && spec.cutoff_Hz < rate_Hz / 2; }
bool within(const OneEuroSpec& spec, double) {
  const bool has_slope = spec.beta >= 0 && std::isfinite(spec.beta);
  return positive(spec.min_cutoff_Hz) && has_slope && positive(spec.derivative_cutoff_Hz);
}

/// How many samples it takes until less than a billionth is left, if each sample leaves this factor.
double samples_to_settle(double factor_per_sample) {
  constexpr double kLeft = 1e-9;
  if (!(factor_per_sample < 1)) return std::numeric_limits<double>::infinity();
  return factor_per_sample > 0 ? reproducible::log(kLeft) / reproducible::log(factor_per_sample) : 1;
}

double settling(const MovingAverageSpec& spec, Rate) { return spec.samples; }
double settling(const ButterworthSpec& spec, Rate rate) {
  const double g = internal::warped(spec.cutoff_Hz, rate), middle = 1 + g * g, around = std::sqrt(2.0) * g;
  return samples_to_settle(std::sqrt((middle - around) / (middle + around)));
}
double settling(const OneEuroSpec& spec, Rate rate) {
  const auto of = [&](double cutoff_Hz) {
    return samples_to_settle(1 - internal::smoothing_factor(cutoff_Hz, internal::hertz(rate)));
  };
  return of(spec.min_cutoff_Hz) + of(spec.derivative_cutoff_Hz);
}

}  // namespace

Duration settling_time(const FilterSpec& spec, Rate rate) {
  constexpr double kLongest_s = 1e6;  // a cutoff of next to nothing never settles
  const double samples = std::visit([&](const auto& kind) { return settling(kind, rate); }, spec);
  return {static_cast<std::int64_t>(1e9 * std::min(samples / internal::hertz(rate), kLongest_s))};
}

bool in_domain(const FilterSpec& spec, Rate rate) {
  if (rate.num <= 0 || rate.den <= 0) return false;
  return std::visit([&](const auto& kind) { return within(kind, internal::hertz(rate)); }, spec);
}

namespace internal {

ButterworthCoefficients butterworth_coefficients(double cutoff_Hz, Rate rate) {
  const double g = warped(cutoff_Hz, rate);
  const double a1 = 1 / (1 + g * (g + std::sqrt(2.0)));
  return {a1, g * a1, g * (g * a1)};
}

double smoothing_factor(double cutoff_Hz, double rate_Hz) {
  return 1 / (1 + rate_Hz / (2 * std::numbers::pi * cutoff_Hz));  // in this form an infinite cutoff gives 1
}

}  // namespace internal
}  // namespace evenstep
