// Straightness is judged on the straight pieces of a motion that turns, and saturation is found where it was.

#include <random>

#include "cases.h"
#include "catch.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/saturation.h"
#include "synthetic.h"

using namespace evenstep;
using synthetic::kSlot_s;
using synthetic::kStep_m;

namespace {

constexpr double kRounding = 1e-6;

/// Whether [from, to] touches a turn or the time before the first straight piece.
bool touches_turn(const Nominal::Turns& turns, RealTime from, RealTime to) {
  if (from < turns.first) return true;
  for (RealTime turn = turns.first + turns.straight; turn < to; turn = turn + turns.straight + turns.turn) {
    if (to > turn && from < turn + turns.turn) return true;
  }
  return false;
}

/// A run whose hand is a kilometre away whenever it turns.
RunRecord run_with(const Nominal::Turns& turns, Duration latency) {
  RunRecord run = synthetic::reference_run();
  run.nominal.devices[0].turns = turns;
  run.strategies.clear();
  run.strategies.push_back(synthetic::strategy("paper", run.nominal.end, synthetic::kLead, latency));
  StrategyRecord& paper = run.strategies[0];
  DeviceRecord& device = paper.devices[0];
  const Duration h{1'000'000};
  for (std::size_t n = 0; n < paper.steps.size(); ++n) {
    if (!touches_turn(turns, paper.steps[n].read - h, paper.steps[n].read + h)) continue;
    device.steps[n].position_m = {1e3, 0, 0};
    device.steps[n].force_N = {-2e5, 0, 0};
  }
  device.ticks.clear();
  synthetic::add_ticks(paper, run.nominal.end);
  return run;
}

double value_of(const RunRecord& run, const std::string& signal, const std::string& metric) {
  const Metrics metrics = measure(run);
  CAPTURE(signal, metric);
  REQUIRE(metrics.at(signal).count(metric) == 1);
  return metrics.at(signal).at(metric);
}

}  // namespace

TEST_CASE("no step and no tick of a turn is judged for straightness, and hardly any other is left out, 300 random turns") {
  std::mt19937_64 random(5);
  const auto ms = [&](std::int64_t from, std::int64_t to) {
    return Duration{(from + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(to - from))) * 1'000'000 +
                    static_cast<std::int64_t>(random() % 1'000'000)};
  };
  for (int i = 0; i < evenstep::testing::cases(300); ++i) {
    const Nominal::Turns turns{RealTime{} + ms(0, 300), ms(150, 700), ms(10, 200)};
    const Duration latency = ms(14, 60);
    const RunRecord run = run_with(turns, latency);
    INFO(turns.first.ns << " " << turns.straight.ns << " " << turns.turn.ns << " L " << latency.ns);
    CHECK(value_of(run, "left.interaction.paper", "velocity_jump") / kStep_m < kRounding);
    CHECK(value_of(run, "left.interaction.paper", "deviation_max") / kStep_m < kRounding);
    CHECK(value_of(run, "left.interaction.paper", "step_ratio_max") < 1 + kRounding);
    // Held forces are a staircase of one step, and a tick sees a force twice or not at all.
    CHECK(value_of(run, "left.force.paper", "velocity_jump") / (200 * kStep_m) < 1 + 1e-5);
    CHECK(value_of(run, "left.force.paper", "deviation_max") / (200 * kStep_m) < 1);
    std::size_t steps = 0, ticks = 0;
    const Duration h{1'000'000}, slot{2'222'223};
    for (const StepRow& step : run.strategies[0].steps)
      steps += step.begin >= run.nominal.judged_from && !touches_turn(turns, step.read - h - h, step.read + h);
    for (const TickRow& tick : run.strategies[0].devices[0].ticks)
      ticks += tick.at >= run.nominal.judged_from && !touches_turn(turns, tick.at - latency - slot - slot - h * 5, tick.at);
    CHECK(value_of(run, "left.interaction.paper", "straight") == static_cast<double>(steps));
    CHECK(value_of(run, "left.force.paper", "straight") >= static_cast<double>(ticks));
    for (const auto& [signal, rows] : bins(run)) {
      for (const BinRow& row : rows) CHECK(row.deviation_max < 1);
    }
  }
}

TEST_CASE("without a piece of three samples straightness has no value, and an expectation on it nothing to judge") {
  const RunRecord run = run_with({RealTime{}, Duration{20'000'000}, Duration{50'000'000}}, Duration{14'000'000});
  const Metrics metrics = measure(run);
  CHECK(metrics.at("left.force.paper").at("straight") < 20);  // a tick here and there
  for (const char* metric : {"velocity_jump", "deviation_max", "deviation_rms", "residual_20_500_hz"})
    CHECK(metrics.at("left.force.paper").count(metric) == 0);
  CHECK(metrics.at("left.force.paper").count("jump_max") == 1);
}

TEST_CASE("saturation says the first time, the count and the share of each cause over the judged samples") {
  RunRecord run = synthetic::reference_run();
  const auto device = [&](const char* name) -> DeviceRecord& {
    return std::find_if(run.strategies.begin(), run.strategies.end(), [&](const auto& s) { return s.name == name; })
        ->devices[0];
  };
  CHECK(saturations(run).empty());
  device("paper").ticks[100].saturated.add(SaturationCause::clamp);  // in warm-up
  CHECK(saturations(run).empty());
  for (std::size_t k = 1000; k < 1010; ++k) device("paper").ticks[k].saturated.add(SaturationCause::slew);
  for (std::size_t k = 1005; k < 1020; ++k) device("paper").ticks[k].saturated.add(SaturationCause::clamp);
  const auto found = saturations(run);
  REQUIRE(found.size() == 1);
  const Saturation& met = found.at("left.force.paper");
  CHECK(met.judged == 2000 - 267);
  CHECK(met.saturated == 20);
  CHECK(met.share() == 20.0 / (2000 - 267));
  REQUIRE(met.parts.size() == 2);
  CHECK((met.parts[0].cause == SaturationCause::slew && met.parts[0].count == 10 && met.parts[0].first.ns == 1'000'000'000));
  CHECK(
      (met.parts[1].cause == SaturationCause::clamp && met.parts[1].count == 15 && met.parts[1].first.ns == 1'005'000'000));
  CHECK(value_of(run, "left.force.paper", "saturated") == 20);
  CHECK(value_of(run, "left.force.direct", "saturated") == 0);
}

TEST_CASE("a position at the end of the range saturates the steps that read it and the ticks that send their forces") {
  RunRecord run = synthetic::reference_run();
  for (StrategyRecord& strategy : run.strategies) {
    strategy.reference = strategy.name == "ideal";
    for (std::size_t k = 1000; k < 1100; ++k) strategy.devices[0].ticks[k].saturated.add(SaturationCause::device_position);
  }
  const auto found = saturations(run);
  CHECK(found.count("left.interaction.ideal") == 0);
  for (const char* name : {"paper", "direct"}) {
    const StrategyRecord& strategy =
        *std::find_if(run.strategies.begin(), run.strategies.end(), [&](const auto& s) { return s.name == name; });
    const Saturation& steps = found.at(std::string("left.interaction.") + name);
    std::int64_t expected = 0;
    for (const StepRow& step : strategy.steps) {
      // On the map a position is interpolated. It is affected from the tick before the first saturated sample to the tick
      // after the last one.
      const bool mapped = std::string(name) == "paper";
      expected += step.read.ns > (mapped ? 999'000'000 : 1'000'000'000 - 1) && step.read.ns < 1'100'000'000;
    }
    CHECK(steps.saturated == expected);
    const Saturation& ticks = found.at(std::string("left.force.") + name);
    CHECK(ticks.saturated >= 100);
    CHECK(ticks.saturated <= 100 + 20);  // plus the latency and some slots
  }
}

TEST_CASE("only metrics of the shape are taken from a saturated signal") {
  for (const char* metric : {"velocity_jump", "deviation_max", "jump_max", "residual_20_500_hz", "error_max", "gain"})
    CHECK(judges_shape("left.force.paper", metric));
  for (const char* metric : {"saturated", "clamped", "underruns", "late", "schedule_latency", "motors_max", "judged"})
    CHECK_FALSE(judges_shape("left.force.paper", metric));
  CHECK(judges_shape("left.interaction.paper", "step_ratio_min"));
  CHECK(judges_shape("closed_loop.left.paper", "rendered_damping"));
  CHECK_FALSE(judges_shape("closed_loop.left.paper", "stable"));
  CHECK_FALSE(judges_shape("solver.paper", "energy_growth"));
}
