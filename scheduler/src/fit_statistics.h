#pragma once
/// Robust statistics of small samples, for timing_fit.cpp. Nothing here is hashed, so libm may be used.

#include <functional>
#include <vector>

#include "evenstep/scheduler/timing_fit.h"

namespace evenstep::internal {

using Sample = std::vector<double>;

double quantile(Sample sample, double share);  ///< nearest rank; 0 for an empty sample
double median(const Sample& sample);
double mean(const Sample& sample);
/// 1.4826 times the median absolute deviation: the standard deviation of a normal sample.
double robust_deviation(const Sample& sample);
/// The correlation of sample[i] and sample[i + lag] about the common mean; 0 if nothing varies.
double lag_correlation(const Sample& sample, std::size_t lag);
Sample logarithms(const Sample& sample);

/// The greatest distance of the empirical distribution from `cdf`.
double kolmogorov_distance(Sample sample, const std::function<double(double)>& cdf);

FittedLength fit_length(const Sample& durations_ns);

/// Fits y = level (1 + slope t) to 20 batch medians and returns the slope. The error is that of the straight line through
/// them, times sqrt((1 + c) / (1 - c)) for residuals with lag-1 correlation c, so that a long-lasting deviation is not
/// mistaken for a well-determined slope. 0 for fewer than 40 values, and where the line is not above 0 at t = 0.
FittedNumber relative_slope(const Sample& times_s, const Sample& values);

/// Two levels with the same spread and the same probability per value of changing to the other: a hidden Markov chain,
/// fitted by expectation and maximization (Baum and Welch).
struct TwoLevels {
  double low = 0, high = 0, deviation = 0, leave = 0;
  double gain = 0;            ///< of log-likelihood compared with a single level
  std::vector<bool> is_high;  ///< the likelier level of each value
};
TwoLevels fit_two_levels(const Sample& values);

/// The maximum-likelihood tail index, 0.1 to 10, of a Pareto distribution between `least` and `most`.
double fit_tail(const Sample& values, double least, double most);

/// The middle of the densest stretch [x, 1.4 x] and how many values it holds.
struct Cluster {
  double center = 0;
  std::int64_t count = 0;
};
Cluster densest(const Sample& ascending);

}  // namespace evenstep::internal
