// Tests of where an expectation fails.

#include "evenstep/reports/places.h"
#include "cases.h"

#include <cmath>
#include <random>

#include "catch.h"
#include "evenstep/reports/measures.h"
#include "synthetic.h"

using namespace evenstep;
using Catch::Contains;
using Kind = MetricSamples::Kind;

namespace {

/// The reference run with random mistakes: positions, forces, read times, late forces, missing samples.
RunRecord random_run(std::mt19937_64& random) {
  RunRecord run = synthetic::reference_run({700'000'000});
  run.clock = "wall";
  run.live = "paper";
  const auto below = [&](std::uint64_t limit) { return random() % limit; };
  for (StrategyRecord& strategy : run.strategies) {
    DeviceRecord& device = strategy.devices[0];
    for (int i = 0; i < 6; ++i) {
      const std::size_t n = below(strategy.steps.size()), k = below(device.ticks.size());
      device.steps[n].position_m[below(3)] += 1e-3 * static_cast<double>(below(100));
      device.ticks[k].force_N[below(3)] += 1e-2 * static_cast<double>(below(100));
      device.ticks[k].lateness = Duration{static_cast<std::int64_t>(below(5'000'000))};
      strategy.steps[below(strategy.steps.size())].end.ns += static_cast<std::int64_t>(below(20'000'000));
      strategy.steps[below(strategy.steps.size())].read.ns -= static_cast<std::int64_t>(below(9'000'000));
      const std::size_t missing = below(strategy.steps.size());
      if (device.steps[missing].read == StepRead::underrun) continue;
      device.steps[missing].read = StepRead::underrun;
      strategy.underruns.push_back({static_cast<std::int64_t>(missing), 0, UnderrunRow::Side::interaction,
                                    Duration{1 + static_cast<std::int64_t>(below(1'000'000))}, "clamp"});
    }
    device.steps[below(device.steps.size())].read = StepRead::overrun;
    for (std::size_t n = 0; n < device.steps.size(); ++n) {
      device.steps[n].true_position_m = synthetic::hand_at(strategy.steps[n].read);
      strategy.twin_force_N.push_back(synthetic::times(-200, synthetic::hand_at(strategy.steps[n].read)));
    }
    for (TickRow& tick : device.ticks) tick.undelayed_N = synthetic::times(-200, tick.position_m);
    std::sort(strategy.underruns.begin(), strategy.underruns.end(),
              [](const UnderrunRow& a, const UnderrunRow& b) { return a.step < b.step; });
  }
  return run;
}

double value_of(const MetricSamples& found) {
  if (found.kind == Kind::count) return static_cast<double>(found.samples.size());
  double value = found.samples.front().amount;
  for (const MetricSample& sample : found.samples)
    value = found.kind == Kind::largest ? std::max(value, sample.amount) : std::min(value, sample.amount);
  return value;
}

ExpectationResult failed(const std::string& unit, double value, double max) {
  ExpectationResult result;
  result.value = value;
  result.unit = unit;
  result.max = max;
  result.verdict = ExpectationResult::Verdict::fail;
  return result;
}

}  // namespace

TEST_CASE("the samples of a metric give the metric, for every metric that has a place, in 300 random runs") {
  std::mt19937_64 random(7);
  std::map<std::string, int> seen;
  for (int round = 0; round < evenstep::testing::cases(300); ++round) {
    const RunRecord run = random_run(random);
    for (const auto& [signal, values] : measure(run)) {
      for (const auto& [metric, value] : values) {
        const auto found = samples_of(run, signal, metric);
        if (!found || (found->samples.empty() && found->kind != Kind::count)) continue;
        INFO(round << " " << signal << " " << metric);
        REQUIRE(value_of(*found) == Approx(value).epsilon(1e-12));
        ++seen[metric];
      }
    }
  }
  CHECK(seen.size() == 18);
}

TEST_CASE("a late force is placed: the first, the worst, by how much, and the latency that would do") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = run.strategies[2];
  for (const auto& [n, late_ns] :
       std::vector<std::pair<std::size_t, std::int64_t>>{{3, 90'000'000}, {300, 6'660'000}, {450, 13'861'777}})
    paper.steps[n].end = paper.steps[n].emission + Duration{late_ns};
  const auto late = samples_of(run, "left.force.paper", "late");
  REQUIRE(late);
  ExpectationResult result = failed("", 2, 0);
  locate(result, *late, 1);
  REQUIRE(result.first);
  CHECK(result.first->index == 300);
  CHECK(result.first->at == paper.steps[300].begin);
  CHECK(result.worst->index == 450);
  CHECK(result.where ==
        "late first at step 300, 0.678 s, by 6.66 ms; worst at step 450, 1.011 s, by 13.9 ms; latency 26.704 ms would do");
  // That is true: with this latency no force is late.
  for (StepRow& step : paper.steps) step.emission = step.emission + Duration{13'861'777};
  CHECK(measure(run).at("left.force.paper").at("late") == 0);
}

TEST_CASE("a missing sample is placed, with the lead and the latency that would do") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = run.strategies[2];
  paper.devices[0].steps[333].read = StepRead::underrun;
  paper.underruns = {{333, 0, UnderrunRow::Side::interaction, {740'000}, "clamp"}};
  ExpectationResult result = failed("", 1, 0);
  locate(result, *samples_of(run, "left.buffers.paper", "underruns"), 1);
  CHECK(result.where ==
        "missing its sample first at step 333, 0.749 s, by 740 us; lead 1 ms with latency 13.582223 ms would do");
}

TEST_CASE("a value beyond its limit is placed at the first sample that breaks it and at the worst, in the limit's unit") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = run.strategies[2];
  paper.devices[0].steps[200].position_m[0] += 2e-3;
  paper.devices[0].steps[500].position_m[0] += 5e-3;
  const auto jumps = samples_of(run, "left.interaction.paper", "velocity_jump");
  REQUIRE(jumps);
  ExpectationResult result = failed("mm", 10, 1);
  locate(result, *jumps, 1e-3);
  CHECK(result.first->index == 199);
  CHECK(result.worst->index == 500);
  CHECK_THAT(result.where,
             Contains("out of limit first at step 199, 0.450 s: 2 mm; worst at step 500, ") && Contains("s: 10 mm"));
}

TEST_CASE("too little has no place, and neither has what all samples make together") {
  const RunRecord run = synthetic::reference_run();
  ExpectationResult result = failed("mm", 1, 0);
  result.max = std::nullopt;
  result.min = 5;
  locate(result, *samples_of(run, "left.interaction.direct", "velocity_jump"), 1e-3);
  CHECK_FALSE(result.first);
  CHECK(result.where.empty());
  for (const char* metric : {"deviation_rms", "judged", "underrun_rate", "latency_mean", "residual_20_500_hz"})
    CHECK_FALSE(samples_of(run, "left.force.direct", metric));
  CHECK_FALSE(samples_of(run, "run", "judged_s"));
  CHECK_FALSE(samples_of(run, "right.force.direct", "late"));
}
