#pragma once
/// Robust statistics of small samples, for timing_fit.cpp. Nothing here is hashed, so libm serves.

#include <functional>
#include <vector>

#include "evenstep/scheduler/timing_fit.h"

namespace evenstep::internal {

using Sample = std::vector<double>;

double quantile(Sample sample, double share);  ///< of sorted values, nearest rank; 0 of none
double median(const Sample& sample);
double mean(const Sample& sample);
/// 1.4826 times the median absolute deviation: the standard deviation of a normal sample.
double robust_deviation(const Sample& sample);
/// sample[i] and sample[i + lag] about the common mean; 0 where nothing varies.
double lag_correlation(const Sample& sample, std::size_t lag);
Sample logarithms(const Sample& sample);

/// Greatest distance of the empirical distribution to `cdf`.
double kolmogorov_distance(Sample sample, const std::function<double(double)>& cdf);

FittedLength fit_length(const Sample& durations_ns);

/// y = level (1 + slope t) through 20 batch medians; the error is that of the straight line through them, times
/// sqrt((1 + c) / (1 - c)) for residuals with lag-1 correlation c: what lasts long must not look like a certain slope.
FittedNumber relative_slope(const Sample& times_s, const Sample& values);

/// Two levels with the same spread, each left with one probability per value: a hidden Markov chain by expectation and
/// maximization (Baum and Welch).
struct TwoLevels {
  double low = 0, high = 0, deviation = 0, leave = 0;
  double gain = 0;            ///< of log-likelihood over one level
  std::vector<bool> is_high;  ///< the likelier level of each value
};
TwoLevels fit_two_levels(const Sample& values);

/// Tail index of a Pareto between least and most: maximum likelihood, 0.1 to 10.
double fit_tail(const Sample& values, double least, double most);

/// The middle of the densest stretch [x, 1.4 x] and how many values it holds.
struct Cluster {
  double center = 0;
  std::int64_t count = 0;
};
Cluster densest(const Sample& ascending);

}  // namespace evenstep::internal
