#include "fit_statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace evenstep::internal {
namespace {

constexpr std::size_t kBatches = 20;

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

/// The log density of a normal distribution, without its constant.
double log_density(double value, double level, double deviation) {
  const double z = (value - level) / deviation;
  return -0.5 * z * z - std::log(deviation);
}

/// Each value's probability of "high", by scaled forward and backward passes; the expected number of changes of level.
struct Posterior {
  Sample high;
  double changes = 0;
  double log_likelihood = 0;
};

Posterior posterior_of(const Sample& values, const TwoLevels& model) {
  const std::size_t n = values.size();
  Posterior out;
  out.high.resize(n);
  Sample low_density(n), high_density(n), forward(n), scale(n);
  double predicted = 0.5;
  for (std::size_t i = 0; i < n; ++i) {
    // Both densities are divided by the larger one: far from both levels they would be 0.
    const double low_log = log_density(values[i], model.low, model.deviation);
    const double high_log = log_density(values[i], model.high, model.deviation), larger = std::max(low_log, high_log);
    low_density[i] = std::exp(low_log - larger);
    high_density[i] = std::exp(high_log - larger);
    const double high = predicted * high_density[i], low = (1 - predicted) * low_density[i];
    scale[i] = high + low;
    out.log_likelihood += std::log(scale[i]) + larger;
    forward[i] = high / scale[i];
    predicted = forward[i] * (1 - model.leave) + (1 - forward[i]) * model.leave;
  }
  double backward_high = 1, backward_low = 1;
  for (std::size_t i = n; i-- > 0;) {
    const double high = forward[i] * backward_high, low = (1 - forward[i]) * backward_low;
    out.high[i] = high / (high + low);
    if (i == 0) break;
    // The change into value i from the other level, given the values before (forward) and after it (backward).
    const double in_high = high_density[i] * backward_high / scale[i], in_low = low_density[i] * backward_low / scale[i];
    out.changes += model.leave * (forward[i - 1] * in_low + (1 - forward[i - 1]) * in_high);
    backward_high = (1 - model.leave) * in_high + model.leave * in_low;
    backward_low = (1 - model.leave) * in_low + model.leave * in_high;
  }
  return out;
}

void maximize(const Sample& values, const Posterior& posterior, TwoLevels& model) {
  double high_weight = 0, high_sum = 0, low_sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    high_weight += posterior.high[i];
    high_sum += posterior.high[i] * values[i];
    low_sum += (1 - posterior.high[i]) * values[i];
  }
  const double n = static_cast<double>(values.size());
  if (high_weight < 1 || n - high_weight < 1) return;
  model.high = high_sum / high_weight;
  model.low = low_sum / (n - high_weight);
  double squares = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    squares += posterior.high[i] * std::pow(values[i] - model.high, 2) +
               (1 - posterior.high[i]) * std::pow(values[i] - model.low, 2);
  }
  model.deviation = std::max(std::sqrt(squares / n), 1e-6);
  model.leave = std::clamp(posterior.changes / (n - 1), 1e-4, 0.999);
}

}  // namespace

double quantile(Sample sample, double share) {
  if (sample.empty()) return 0;
  const double rank = std::ceil(share * static_cast<double>(sample.size())) - 1;
  const auto at = sample.begin() + static_cast<long>(std::clamp(rank, 0.0, static_cast<double>(sample.size() - 1)));
  std::nth_element(sample.begin(), at, sample.end());
  return *at;
}

double median(const Sample& sample) { return quantile(sample, 0.5); }

double mean(const Sample& sample) {
  return sample.empty() ? 0 : std::accumulate(sample.begin(), sample.end(), 0.0) / static_cast<double>(sample.size());
}

double robust_deviation(const Sample& sample) {
  const double center = median(sample);
  Sample distances;
  for (const double value : sample) distances.push_back(std::abs(value - center));
  return 1.4826 * median(distances);
}

double lag_correlation(const Sample& sample, std::size_t lag) {
  const double center = mean(sample);
  double variance = 0, covariance = 0;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    variance += std::pow(sample[i] - center, 2);
    if (i + lag < sample.size()) covariance += (sample[i] - center) * (sample[i + lag] - center);
  }
  return variance > 0 ? covariance / variance : 0;
}

Sample logarithms(const Sample& sample) {
  Sample out;
  for (const double value : sample) out.push_back(std::log(std::max(value, 1.0)));
  return out;
}

double kolmogorov_distance(Sample sample, const std::function<double(double)>& cdf) {
  std::sort(sample.begin(), sample.end());
  double distance = 0;
  const double n = static_cast<double>(sample.size());
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double f = cdf(sample[i]);
    distance = std::max({distance, std::abs(f - static_cast<double>(i) / n), std::abs(f - static_cast<double>(i + 1) / n)});
  }
  return distance;
}

FittedLength fit_length(const Sample& durations_ns) {
  FittedLength fit;
  fit.count = static_cast<std::int64_t>(durations_ns.size());
  if (durations_ns.empty()) return fit;
  const Sample logs = logarithms(durations_ns);
  const double center = median(logs), deviation = robust_deviation(logs);
  fit.median_ns = std::exp(center);
  Sample core;
  for (const double duration : durations_ns) {
    if (std::abs(std::log(std::max(duration, 1.0)) - center) <= 5 * deviation + 1e-9) core.push_back(duration);
  }
  fit.mean_ns = mean(core);
  fit.variation = std::sqrt(std::expm1(deviation * deviation));
  fit.distance =
      deviation == 0 ? 0 : kolmogorov_distance(logs, [&](double x) { return normal_cdf((x - center) / deviation); });
  const double low = quantile(durations_ns, 0.05), high = quantile(durations_ns, 0.95);
  const double half = (high - low) / 1.8, middle = 0.5 * (low + high);
  fit.half_width = fit.mean_ns > 0 ? half / fit.mean_ns : 0;
  if (!(half > 0)) return fit;
  fit.uniform_distance =
      kolmogorov_distance(durations_ns, [&](double x) { return std::clamp(0.5 + 0.5 * (x - middle) / half, 0.0, 1.0); });
  return fit;
}

FittedNumber relative_slope(const Sample& times_s, const Sample& values) {
  const std::size_t size = values.size() / kBatches;
  if (size < 2) return {};
  Sample t, y;
  for (std::size_t b = 0; b < kBatches; ++b) {
    const auto from = static_cast<long>(b * size), to = static_cast<long>((b + 1) * size);
    t.push_back(mean({times_s.begin() + from, times_s.begin() + to}));
    y.push_back(median({values.begin() + from, values.begin() + to}));
  }
  const double t_mean = mean(t), y_mean = mean(y);
  double tt = 0, ty = 0, residual = 0;
  for (std::size_t b = 0; b < kBatches; ++b) {
    tt += std::pow(t[b] - t_mean, 2);
    ty += (t[b] - t_mean) * (y[b] - y_mean);
  }
  const double slope = ty / tt, at_0 = y_mean - slope * t_mean;
  if (!(at_0 > 0)) return {};  // relative to nothing
  for (std::size_t b = 0; b < kBatches; ++b) residual += std::pow(y[b] - at_0 - slope * t[b], 2);
  double neighbours = 0;
  for (std::size_t b = 0; b + 1 < kBatches; ++b)
    neighbours += (y[b] - at_0 - slope * t[b]) * (y[b + 1] - at_0 - slope * t[b + 1]);
  const double correlation = residual > 0 ? std::clamp(neighbours / residual, 0.0, 0.9) : 0;
  const double error = std::sqrt(residual / static_cast<double>(kBatches - 2) / tt * (1 + correlation) / (1 - correlation));
  return {slope / at_0, error / std::abs(at_0)};
}

TwoLevels fit_two_levels(const Sample& values) {
  TwoLevels model;
  const double deviation = std::max(robust_deviation(values), 1e-6);
  // Starts from the outer tenths of the sample, so that the rarer level is one of them. Outliers more than 5 deviations
  // beyond the outer twentieths are no third level.
  model.low = quantile(values, 0.1);
  model.high = quantile(values, 0.9);
  const double least = quantile(values, 0.05) - 5 * deviation, most = quantile(values, 0.95) + 5 * deviation;
  Sample bounded;
  for (const double value : values) bounded.push_back(std::clamp(value, least, most));
  const double center = mean(bounded);
  double squares = 0;
  for (const double value : bounded) squares += std::pow(value - center, 2);
  const double n = static_cast<double>(values.size()), spread = std::max(std::sqrt(squares / n), 1e-6);
  model.deviation = std::max(spread / 2, 1e-6);
  model.leave = 0.2;
  Posterior posterior = posterior_of(bounded, model);
  for (int round = 0; round < 200; ++round) {
    maximize(bounded, posterior, model);
    const double before = posterior.log_likelihood;
    posterior = posterior_of(bounded, model);
    if (std::abs(posterior.log_likelihood - before) < 1e-6) break;
  }
  model.gain = posterior.log_likelihood - n * (-0.5 - std::log(spread));
  for (const double high : posterior.high) model.is_high.push_back(high > 0.5);
  return model;
}

double fit_tail(const Sample& values, double least, double most) {
  if (values.empty() || most <= least) return 1;
  double logs = 0;
  for (const double value : values) logs += std::log(value / least);
  const double n = static_cast<double>(values.size()), range = std::log(most / least);
  // The derivative by a of n log a - a sum log(x / least) - n log(1 - q^a), q = least / most; it falls with a.
  const auto slope = [&](double a) { return n / a - logs - n * range / std::expm1(a * range); };
  double low = 0.1, high = 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Cluster densest(const Sample& ascending) {
  Cluster best;
  std::size_t to = 0;
  for (std::size_t from = 0; from < ascending.size(); ++from) {
    while (to < ascending.size() && ascending[to] <= 1.4 * ascending[from]) ++to;
    const auto count = static_cast<std::int64_t>(to - from);
    if (count > best.count)
      best = {median({ascending.begin() + static_cast<long>(from), ascending.begin() + static_cast<long>(to)}), count};
  }
  return best;
}

}  // namespace evenstep::internal
