#include "evenstep/reports/growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "evenstep/time/reproducible_math.h"

namespace evenstep {
namespace {

constexpr std::size_t kLeastBinsToJudge = 10;
constexpr double kMaterial = 1.25;  // an error that grows by less than a quarter counts as bounded

// The noise of neighbouring bins may be correlated. For a trend its strength at the lowest frequencies matters, which is
// estimated from the first six cosines over the run, less two degrees of freedom for the unknowns of the fit.
constexpr int kCosines = 6;
constexpr double kDegrees = kCosines - 2;
constexpr double kStudent4 = 2.776;    // 97.5 % of Student's t with 4 degrees of freedom
constexpr double kStudent6 = 2.447;    // with 6
constexpr double kLeastNoise = 1e-12;  // of the logarithm, squared: what rounding may cause

constexpr int kMostTenths = 50;
constexpr double kMostExponent = kMostTenths / 10.0;

// The share of a series' changes from bin to bin that lies at the lowest frequencies, over the share that would lie there
// if the changes were independent of each other: 1 for a random walk, 0 for noise around a curve.
constexpr double kWalkLow = 1.237 / kCosines;    // 2.5 % of chi-square with 6 degrees of freedom
constexpr double kWalkHigh = 10.645 / kCosines;  // 90 %: a series above it is smoother than a walk
constexpr double kResidualWalks = 0.6;           // residuals with a larger share are a walk
constexpr std::size_t kBinsToTellWalks = 40;     // with fewer bins, plain noise has such residuals too

using PerBin = std::vector<double>;

double sum_of_squares(const PerBin& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

PerBin difference(PerBin values, const PerBin& other) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= other[i];
  return values;
}

double squared_distance(const PerBin& a, const PerBin& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

double mean_of(const PerBin& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

PerBin minus_mean(PerBin values) {
  const double mean = mean_of(values);
  for (double& value : values) value -= mean;
  return values;
}

/// The squares of the first six coefficients of the discrete cosine transform, added up.
double slow_power(const PerBin& values) {
  const auto count = static_cast<double>(values.size());
  double power = 0;
  for (int k = 1; k <= kCosines; ++k) {
    double coefficient = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      coefficient += values[i] * reproducible::cos(std::numbers::pi * k * (static_cast<double>(i) + 0.5) / count);
    power += 2 / count * coefficient * coefficient;
  }
  return power;
}

struct Walk {
  double share = 0;  ///< see kWalkLow
  double drift = 0;  ///< mean change over its standard error
  double reach = 0;  ///< how far such a walk gets in the whole time (standard deviation)
};

Walk walk_of(const PerBin& values) {
  PerBin changes(values.size() - 1);
  for (std::size_t i = 0; i < changes.size(); ++i) changes[i] = values[i + 1] - values[i];
  const auto count = static_cast<double>(changes.size());
  const double mean = (values.back() - values.front()) / count;
  changes = minus_mean(std::move(changes));
  const double variance = sum_of_squares(changes) / count;
  const double slow = slow_power(changes) / kCosines;
  if (!(variance > 0) || !(slow > 0)) return {};
  return {slow / variance, mean * std::sqrt(count / slow), std::sqrt(count * slow)};
}

/// Whether no bin has an error larger by a quarter than some bin before it.
bool never_grows(std::span<const double> rms) {
  double least = rms.front();
  for (const double value : rms) {
    least = std::min(least, value);
    if (value > kMaterial * least) return false;
  }
  return true;
}

/// The logarithms, without their mean. A bin without any error counts as a billionth of the largest.
PerBin logarithms(std::span<const double> rms, double most) {
  PerBin logs;
  for (const double value : rms) logs.push_back(reproducible::log(std::max(value / most, 1e-9)));
  return minus_mean(std::move(logs));
}

/// x^p for x in (0, 1].
double power(double x, double p) { return reproducible::exp(p * reproducible::log(x)); }

/// What t^p can look like if there was an error from the start: the two add up either as errors of unrelated causes (their
/// squares add up), or as a growth on top of an offset.
double with_start(double grown, double start, bool offset) {
  return offset ? start + grown : std::sqrt(start * start + grown * grown);
}

}  // namespace

const char* growth_name(const GrowthInterval& interval) {
  constexpr double kTouch = 1e-9;  // the ends are sums of tenths
  const auto contains = [&](double p) { return interval.low <= p + kTouch && p <= interval.high + kTouch; };
  const int names = (contains(0) ? 1 : 0) + (contains(0.5) ? 1 : 0) + (contains(1) ? 1 : 0);
  if (names != 1 || interval.high > 2 - kTouch) return "undetermined";
  return contains(0) ? "bounded" : contains(1) ? "linear" : "square root";
}

std::string growth_text(const GrowthInterval& interval) {
  if (interval.high == interval.low) return fmt::format("{} ({:g})", growth_name(interval), interval.low);
  return fmt::format("{} ({:g} to {:g})", growth_name(interval), interval.low, interval.high);
}

GrowthFit::GrowthFit(std::vector<double> t_s) : t_s_(std::move(t_s)) {
  if (t_s_.size() < kLeastBinsToJudge) return;
  for (int tenths = 1; tenths <= kMostTenths; tenths += tenths < 20 ? 1 : 5) {
    PerBin grown;
    for (const double t : t_s_) grown.push_back(power(t / t_s_.back(), tenths / 10.0));
    const auto add = [&](double start, bool offset) {
      PerBin shape;
      for (const double value : grown) shape.push_back(with_start(value, start, offset));
      if (shape.back() < kMaterial * shape.front()) return;
      for (double& value : shape) value = reproducible::log(value);
      shapes_.push_back({tenths / 10.0, minus_mean(std::move(shape))});
    };
    add(0, true);
    for (double start = 4; start > 1.0 / 1024; start /= std::numbers::sqrt2) {
      add(start, true);
      add(start, false);
    }
  }
}

std::optional<GrowthInterval> GrowthFit::operator()(std::span<const double> rms) const {
  if (rms.size() != t_s_.size() || rms.size() < kLeastBinsToJudge) return std::nullopt;
  if (!std::all_of(rms.begin(), rms.end(), [](double value) { return std::isfinite(value); })) return std::nullopt;
  if (never_grows(rms)) return GrowthInterval{0, 0};
  const double most = *std::max_element(rms.begin(), rms.end());
  std::vector<double> possible = around_curves(logarithms(rms, most));
  PerBin scaled(rms.begin(), rms.end());
  for (double& value : scaled) value /= most;
  const Walk walk = walk_of(scaled);
  if (walk.share >= kWalkLow && walk.share <= kWalkHigh && walk.reach > (kMaterial - 1) * mean_of(scaled))
    possible.push_back(std::abs(walk.drift) > kStudent6 ? 1 : 0.5);
  if (possible.empty()) return GrowthInterval{0, kMostExponent};
  const auto [low, high] = std::minmax_element(possible.begin(), possible.end());
  return GrowthInterval{*low, *high};
}

/// The exponents for which the series may be noise around a curve. The best of all curves says how strong the noise is.
std::vector<double> GrowthFit::around_curves(const PerBin& logs) const {
  std::vector<double> misfit{sum_of_squares(logs)};
  for (const Shape& shape : shapes_) misfit.push_back(squared_distance(logs, shape.logarithm));
  const auto least = static_cast<std::size_t>(std::min_element(misfit.begin(), misfit.end()) - misfit.begin());
  const PerBin residual = least == 0 ? logs : difference(logs, shapes_[least - 1].logarithm);
  const Walk walk = walk_of(residual);
  if (logs.size() >= kBinsToTellWalks && walk.share > kResidualWalks && walk.reach > kMaterial - 1) return {};
  const double noise =
      std::max({slow_power(residual) / kDegrees, misfit[least] / static_cast<double>(logs.size() - 3), kLeastNoise});
  std::vector<double> possible;
  for (std::size_t i = 0; i < misfit.size(); ++i) {
    if (misfit[i] <= misfit[least] + kStudent4 * kStudent4 * noise) possible.push_back(i == 0 ? 0 : shapes_[i - 1].exponent);
  }
  return possible;
}

}  // namespace evenstep
