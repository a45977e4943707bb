// What is promised about a rate: the bound by its formula, and promises kept by processes that are known.
#include "evenstep/harness/trust.h"

#include <functional>

#include "evenstep/reports/rate_bound.h"
#include "processes.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::testing;
using Catch::Contains;

namespace {

/// P(Bin(n, p) <= k)
double binomial_cdf(std::int64_t k, std::int64_t n, double p) {
  double sum = 0, choose_log = 0;
  for (std::int64_t i = 0; i <= k; ++i) {
    sum += std::exp(choose_log + static_cast<double>(i) * std::log(p) + static_cast<double>(n - i) * std::log1p(-p));
    choose_log += std::log(static_cast<double>(n - i)) - std::log(static_cast<double>(i + 1));
  }
  return sum;
}

}  // namespace

TEST_CASE("the bound on a chosen rate is that of Campi and Garatti with two variables") {
  for (const std::int64_t n : {10, 93, 473, 2000}) {
    for (const std::int64_t k : {0, 1, 5}) {
      for (const double confidence : {0.5, 0.95, 0.999}) {
        INFO(k << " of " << n << " at " << confidence);
        const double bound = chosen_rate_at_most(k, n, 1, confidence);
        CHECK(static_cast<double>(k + 1) * binomial_cdf(k + 1, n, bound) == Approx(1 - confidence).epsilon(1e-9));
        CHECK(chosen_rate_at_most(2 * k, 2 * n, 2, confidence) == bound);  // pairs count as one
      }
    }
  }
  CHECK(chosen_rate_at_most(0, 1, 1, 0.95) == 1);
  CHECK(chosen_rate_at_most(9, 10, 1, 0.95) == 1);
}

TEST_CASE("the most underruns and the segments needed for a rate are those of a search through all counts") {
  for (const double rate : {0.01, 0.05, 0.3}) {
    for (const double confidence : {0.5, 0.95, 0.999}) {
      for (const double alike : {1.0, 1.7, 12.0}) {
        const std::int64_t needed = chosen_segments_needed(rate, confidence, alike);
        CHECK(chosen_rate_at_most(0, needed, alike, confidence) <= rate);
        CHECK(chosen_rate_at_most(0, needed - 1, alike, confidence) > rate);
        for (const std::int64_t segments : {7, 93, 473, 1000}) {
          std::int64_t most = -1;
          while (most + 1 < segments && chosen_rate_at_most(most + 1, segments, alike, confidence) <= rate) ++most;
          REQUIRE(most_chosen_underruns(rate, confidence, segments, alike) == most);
          REQUIRE((most >= 0) == (needed <= segments));
        }
      }
    }
  }
}

TEST_CASE("the dispersion of correlated values is that of their autocorrelation") {
  // Of an autoregressive process with r it is (1 + r) / (1 - r); of 40,000 values it is found to about a tenth.
  for (const double r : {0.0, 0.5, 0.8, 0.95}) {
    Draws draws(7);
    std::vector<double> values(40'000);
    double state = draws.normal();
    for (double& value : values) value = state = r * state + std::sqrt(1 - r * r) * draws.normal();
    CHECK(dispersion(values) == Approx((1 + r) / (1 - r)).epsilon(0.15));
  }
  CHECK(dispersion(std::vector<double>(100, 3.0)) == 1);
  std::vector<double> pairs;  // each value twice
  Draws draws(8);
  for (int i = 0; i < 20'000; ++i) pairs.insert(pairs.end(), 2, draws.uniform());
  CHECK(dispersion(pairs) == Approx(2).epsilon(0.05));
}

TEST_CASE("the promise about a rate is broken by at most one in twenty recordings whatever the process") {
  // 200 recordings of each process; at 5 % more than 10 + 3 * 3.1 = 19 have a probability of 0.2 %. Leads are independent
  // of delays, so both choices cost.
  for (const Process& process : processes()) {
    Draws draws(11);
    int promised = 0, broken = 0, changed = 0;
    for (int i = 0; i < 200; ++i) {
      const std::vector<double> leads = process.draw(draws, 1500), delays = process.draw(draws, 1500);
      const std::vector<SegmentNeed> needs = needs_of(leads, delays);
      const SizeTrust trust = trust_in(needs);
      changed += trust.change ? 1 : 0;
      const std::int64_t allowed = most_chosen_underruns(0.05, 0.95, 1500, trust.alike);
      if (!trust.one_process() || allowed < 0) continue;
      const RateLatency found = least_latency_with_underruns(needs, allowed);
      const double kept =
          (1 - process.above(value_of(found.lead))) * (1 - process.above(value_of(found.latency - found.lead)));
      ++promised;
      broken += 1 - kept > 0.05 ? 1 : 0;
    }
    INFO(process.name << ": " << broken << " of " << promised << " broken, " << changed << " of 200 taken for a change");
    CHECK(broken <= 19);
    CHECK(promised >= 100);
    CHECK(changed <= 45);  // the level of 5 % is that of independent blocks; three times that, and 3 * 5
    if (process.independent) CHECK(changed <= 19);
  }
}

TEST_CASE("a change of the process is found with its place and nothing is promised then") {
  for (const double at : {0.25, 0.5, 0.8}) {
    Draws draws(5);
    int found = 0, near = 0;
    for (int i = 0; i < 40; ++i) {
      std::vector<double> values(600);
      for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = -std::log(draws.uniform()) * (static_cast<double>(k) < 600 * at ? 1.0 : 2.0);
      const SizeTrust trust = trust_in(needs_of(std::vector<double>(600, 1.0), values));
      if (!trust.change) continue;
      ++found;
      near += std::abs(static_cast<double>(trust.change->segment) - 600 * at) < 60 ? 1 : 0;
    }
    INFO(found << " of 40 found, " << near << " within a tenth");
    CHECK(found >= 38);
    CHECK(near >= 32);
  }
  std::vector<SegmentTiming> segments = play({.visualization_variation = 0.05, .step_variation = 0.05, .seed = 2}, 200);
  std::vector<SegmentTiming> slower = play({.visualization = {20 * ms}, .visualization_variation = 0.2, .seed = 3}, 200);
  const Duration later{segments.back().end.ns};
  for (SegmentTiming& one : slower) {
    one.begin = one.begin + later;
    one.end = one.end + later;
    if (one.visualization) *one.visualization = {one.visualization->begin + later, one.visualization->end + later};
    for (Interval& step : one.steps) step = {step.begin + later, step.end + later};
    segments.push_back(one);
  }
  for (std::size_t k = 0; k < segments.size(); ++k) segments[k].index = static_cast<std::int64_t>(k);
  const SizeRecord record = size_segments(segments, "", {.rate = 0.1});
  const SizeStrategy& use = strategy(record, "phase_locked");
  REQUIRE(use.trust.change);
  CHECK(std::abs(seconds(use.trust.change->from) - seconds(later)) < 0.5);
  CHECK_FALSE(use.rate->sure);
  CHECK_FALSE(use.rate->any_phase.rate_at_most);
  CHECK_THAT(size_text(record), Contains("s on it behaves differently than before") && Contains("No confidence is given"));
  CHECK_THAT(size_json(record), Contains("\"one_process\":false") && Contains("\"rate_at_most\":null"));
}

TEST_CASE("of a timing without variation one segment says all") {
  const SizeRecord record = size_segments(play({}, 200), "", {});
  for (const SizeStrategy& one : record.strategies) {
    CHECK(one.trust.alike == 1);
    CHECK(one.trust.one_process());
    CHECK(one.all_unseen().late == 0);
  }
}
