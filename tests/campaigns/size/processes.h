#pragma once
/// Processes whose quantiles are known, for the tests of what a size promises.

#include <cmath>
#include <functional>
#include <vector>

#include "evenstep/scheduler/random.h"
#include "src/size/rate.h"

namespace evenstep::testing {

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : stream_(seed, "processes.test") {}
  double uniform() { return stream_.uniform(next_++); }
  double normal() { return stream_.standard_normal(next_++); }
  double exponential() { return -std::log(uniform()); }

 private:
  RandomStream stream_;
  std::uint64_t next_ = 0;
};

struct Process {
  const char* name;
  bool independent;
  std::function<std::vector<double>(Draws&, std::size_t)> draw;
  std::function<double(double)> above;  ///< P(value > x)
};

inline double normal_above(double x) { return std::erfc(x / std::sqrt(2)) / 2; }

/// exp(0.5 z), z normal with an autocorrelation of `r` from one to the next.
inline Process log_normal(const char* name, double r) {
  return {name, r == 0,
          [r](Draws& draws, std::size_t count) {
            std::vector<double> values(count);
            double z = draws.normal();
            for (double& value : values) {
              z = r * z + std::sqrt(1 - r * r) * draws.normal();
              value = std::exp(0.5 * z);
            }
            return values;
          },
          [](double x) { return x <= 0 ? 1 : normal_above(std::log(x) / 0.5); }};
}

/// P(value > x) = x^(-1/shape), x >= 1.
inline Process pareto(const char* name, double shape) {
  return {name, true,
          [shape](Draws& draws, std::size_t count) {
            std::vector<double> values(count);
            for (double& value : values) value = std::pow(draws.uniform(), -shape);
            return values;
          },
          [shape](double x) { return x <= 1 ? 1 : std::pow(x, -1 / shape); }};
}

/// Two machines of which one is twice as slow; it changes every 50 segments on average.
inline Process regimes() {
  return {"regimes", false,
          [](Draws& draws, std::size_t count) {
            std::vector<double> values(count);
            bool slow = draws.uniform() < 0.5;
            for (double& value : values) {
              if (draws.uniform() < 0.02) slow = !slow;
              value = (slow ? 2 : 1) * std::exp(0.3 * draws.normal());
            }
            return values;
          },
          [](double x) {
            if (x <= 0) return 1.0;
            return (normal_above(std::log(x) / 0.3) + normal_above(std::log(x / 2) / 0.3)) / 2;
          }};
}

/// Jitter below a tenth, and in one segment of twenty (a Poisson process) an exponential hitch.
inline Process hitches() {
  return {"hitches", true,
          [](Draws& draws, std::size_t count) {
            std::vector<double> values(count);
            for (double& value : values) value = 0.1 * draws.uniform();
            for (double at = 20 * draws.exponential(); at < static_cast<double>(count); at += 20 * draws.exponential())
              values[static_cast<std::size_t>(at)] += draws.exponential();
            return values;
          },
          // Of a segment with k hitches, k Poisson with mean 1/20, their sum is Gamma(k); three at once are left out, 2e-5.
          [](double x) {
            const double none = std::exp(-0.05), jitter = 0.05;  // the mean of the jitter, which a hitch hardly notices
            if (x <= 0.1) return 1 - none * std::min(std::max(x, 0.0) / 0.1, 1.0);
            const double y = x - jitter;
            return none * (0.05 * std::exp(-y) + 0.00125 * std::exp(-y) * (1 + y)) +
                   (1 - none * (1 + 0.05 + 0.00125)) * std::exp(-y) * (1 + y + y * y / 2);
          }};
}

inline std::vector<Process> processes() {
  return {log_normal("log-normal", 0), log_normal("log-normal, correlated", 0.8), pareto("Pareto 1/4", 0.25), hitches(),
          regimes()};
}

// Values as needs: a millionth is a ns.
inline Duration duration_of(double value) { return {static_cast<std::int64_t>(std::ceil(value * 1e6))}; }
inline double value_of(Duration duration) { return static_cast<double>(duration.ns) * 1e-6; }
inline std::vector<internal::SegmentNeed> needs_of(const std::vector<double>& leads, const std::vector<double>& delays) {
  std::vector<internal::SegmentNeed> needs;
  for (std::size_t k = 0; k < leads.size(); ++k)
    needs.push_back({duration_of(leads[k]), duration_of(delays[k]), {static_cast<std::int64_t>(k)}});
  return needs;
}

}  // namespace evenstep::testing
