#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.h"
#include "evenstep/scheduler/random.h"

using namespace evenstep;

namespace {

constexpr std::uint64_t kLogNormalDraws = 1'000'000;
constexpr Duration kMean{1'482'222};

std::vector<double> draw(double variation) {
  const RandomStream stream(7, "log_normal");
  std::vector<double> values(kLogNormalDraws);
  for (std::uint64_t n = 0; n < kLogNormalDraws; ++n)
    values[n] = static_cast<double>(log_normal(stream, n, kMean, variation).ns);
  return values;
}

}  // namespace

TEST_CASE("log_normal keeps the mean and has the coefficient of variation asked for", "[sweep]") {
  for (const double variation : {0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 1.0}) {
    INFO("variation " << variation);
    const std::vector<double> values = draw(variation);
    double sum = 0, sum_of_squares = 0;
    for (const double value : values) sum += value;
    const double mean = sum / kLogNormalDraws;
    for (const double value : values) sum_of_squares += (value - mean) * (value - mean);
    const double measured = std::sqrt(sum_of_squares / kLogNormalDraws) / mean;

    // 5 standard errors are allowed. That of the mean is variation / sqrt(n). That of a standard deviation is, relatively,
    // sqrt((kurtosis - 1) / n) / 2; the kurtosis of a log-normal distribution is w^4 + 2 w^3 + 3 w^2 - 3 with w = 1 +
    // variation^2. The mean in the denominator adds its own error. Rounding to ns adds a variance of 1/12 ns^2, which is
    // less than 2e-8 of the smallest variance here.
    const double w = 1 + variation * variation;
    const double kurtosis = std::pow(w, 4) + 2 * std::pow(w, 3) + 3 * w * w - 3;
    const double error_of_mean = variation / std::sqrt(kLogNormalDraws);
    const double error_of_variation = std::sqrt((kurtosis - 1) / kLogNormalDraws) / 2 + error_of_mean;
    CHECK(std::abs(mean / static_cast<double>(kMean.ns) - 1) < 5 * error_of_mean);
    CHECK(std::abs(measured / variation - 1) < 5 * error_of_variation);
  }
}

TEST_CASE("the logarithm of log_normal is normal (Kolmogorov-Smirnov)", "[sweep]") {
  for (const double variation : {0.01, 0.1, 1.0}) {
    INFO("variation " << variation);
    std::vector<double> values = draw(variation);
    std::sort(values.begin(), values.end());
    const double variance = std::log1p(variation * variation);
    double distance = 0;
    for (std::uint64_t i = 0; i < kLogNormalDraws; ++i) {
      const double z = (std::log(values[i] / static_cast<double>(kMean.ns)) + variance / 2) / std::sqrt(variance);
      const double cumulative = 0.5 * std::erfc(-z / std::sqrt(2.0));
      distance = std::max(distance, std::abs((i + 0.5) / kLogNormalDraws - cumulative));
    }
    // 1.95 / sqrt(n) is exceeded with probability 0.001. Values are whole ns. At 1 %, half a ns is 1.4e-5 of the
    // distribution.
    CHECK(distance < 1.95 / std::sqrt(kLogNormalDraws) + 2e-5);
  }
}

TEST_CASE("log_normal of 0 % is the mean, exactly, for every draw") {
  const RandomStream stream(7, "log_normal");
  int different = 0;
  for (std::uint64_t n = 0; n < 10'000; ++n) {
    for (const std::int64_t ns : {1LL, 1'482'222LL, 9'007'199'254'740'993LL})
      different += log_normal(stream, n, {ns}, 0).ns != ns;
  }
  CHECK(different == 0);
}

TEST_CASE("log_normal is at least 1 ns and at most 2^62 ns, however wide it is") {
  const RandomStream stream(7, "log_normal");
  bool lowest = false, highest = false;
  for (std::uint64_t n = 0; n < 10'000; ++n) {
    const Duration narrow = log_normal(stream, n, {1}, 10.0);
    const Duration wide = log_normal(stream, n, {std::int64_t{1} << 61}, 10.0);
    REQUIRE(narrow.ns >= 1);
    REQUIRE(wide.ns >= 1);
    REQUIRE(wide.ns <= std::int64_t{1} << 62);
    lowest |= narrow.ns == 1;
    highest |= wide.ns == std::int64_t{1} << 62;
  }
  CHECK(lowest);
  CHECK(highest);
}
