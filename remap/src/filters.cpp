#include "evenstep/remap/filters.h"

#include "evenstep/time/reproducible_math.h"

namespace evenstep {
namespace {

constexpr double kPi = 3.14159265358979323846;

bool positive(double value) { return value > 0 && std::isfinite(value); }

bool within(const MovingAverageSpec& spec, double) { return spec.samples >= 1 && spec.samples <= kMaxAveragedSamples; }
bool within(const ButterworthSpec& spec, double rate_Hz) { return positive(spec.cutoff_Hz) && spec.cutoff_Hz < rate_Hz / 2; }
bool within(const OneEuroSpec& spec, double) {
  const bool has_slope = spec.beta >= 0 && std::isfinite(spec.beta);
  return positive(spec.min_cutoff_Hz) && has_slope && positive(spec.derivative_cutoff_Hz);
}

}  // namespace

bool in_domain(const FilterSpec& spec, Rate rate) {
  if (rate.num <= 0 || rate.den <= 0) return false;
  return std::visit([&](const auto& kind) { return within(kind, internal::hertz(rate)); }, spec);
}

namespace internal {

ButterworthCoefficients butterworth_coefficients(double cutoff_Hz, Rate rate) {
  const double angle = kPi * (cutoff_Hz / hertz(rate));  // dividing first, it cannot round past the pole of tan
  const double g = reproducible::sin(angle) / reproducible::cos(angle);
  const double a1 = 1 / (1 + g * (g + std::sqrt(2.0)));
  return {a1, g * a1, g * (g * a1)};
}

double smoothing_factor(double cutoff_Hz, double rate_Hz) {
  return 1 / (1 + rate_Hz / (2 * kPi * cutoff_Hz));  // in this form an infinite cutoff gives 1
}

}  // namespace internal
}  // namespace evenstep
