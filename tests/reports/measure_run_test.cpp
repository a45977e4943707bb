#include <cmath>
#include <set>

#include "catch.h"
#include "evenstep/reports/measures.h"
#include "synthetic.h"

using namespace evenstep;
using synthetic::kSlot_s;
using synthetic::kStep_m;

namespace {

constexpr double kFloor = 1e-6;  // in steps: a read time floored to 1 ns moves the hand by 1 ns / slot = 4.5e-7 step

StrategyRecord& strategy(RunRecord& run, const std::string& name) {
  return *std::find_if(run.strategies.begin(), run.strategies.end(), [&](const auto& s) { return s.name == name; });
}
/// The steps of the reference run that are judged begin here: whole segments from the ninth on.
constexpr std::size_t kFirstJudged = 8 * 15;

double value(const RunRecord& run, const std::string& signal, const std::string& metric) {
  const Metrics metrics = measure(run);
  CAPTURE(signal, metric);
  REQUIRE(metrics.count(signal) == 1);
  REQUIRE(metrics.at(signal).count(metric) == 1);
  return metrics.at(signal).at(metric);
}
bool has(const RunRecord& run, const std::string& signal, const std::string& metric) {
  return measure(run).at(signal).count(metric) == 1;
}

}  // namespace

TEST_CASE("the paper's reference case gives the closed forms") {
  const RunRecord run = synthetic::reference_run();
  const double v_s = 11.1e-3, s_s = (1.0 / 30 - 11.1e-3) / 15;

  SECTION("direct: the first step sees 5.66 steps, the others 0.667, so the jump is V / slot = 4.995 steps") {
    const std::string signal = "left.interaction.direct";
    CHECK(value(run, signal, "step_ratio_max") == Approx((v_s + s_s) / kSlot_s).margin(2 * kFloor));
    CHECK(value(run, signal, "step_ratio_min") == Approx(s_s / kSlot_s).margin(2 * kFloor));
    CHECK(value(run, signal, "velocity_jump") / kStep_m == Approx(v_s / kSlot_s).margin(3 * kFloor));
    // Within a segment the hand is off an even line by (V/N) i. That is a saw tooth of 14 V/N from peak to peak, apart from
    // the fit.
    CHECK(value(run, signal, "deviation_max") / kStep_m == Approx(7 * v_s / 15 / kSlot_s).epsilon(0.2));
  }
  SECTION("paper: an even line to the floor of the nanosecond clock") {
    for (const char* signal : {"left.interaction.paper", "left.interaction.phase_locked", "left.interaction.ideal"}) {
      CHECK(value(run, signal, "velocity_jump") / kStep_m < kFloor);
      CHECK(value(run, signal, "deviation_max") / kStep_m < kFloor);
      CHECK(value(run, signal, "deviation_rms") <= value(run, signal, "deviation_max"));
      CHECK(value(run, signal, "step_ratio_max") == Approx(1).margin(kFloor));
      CHECK(value(run, signal, "back_steps") == 0);
    }
  }
  SECTION("interaction latency runs from V + c of the first step of a segment to V/N + c of its last") {
    const double c_s = 0.26e-3;
    CHECK(value(run, "left.interaction.paper", "latency_max") == Approx(v_s + c_s).margin(2e-9));
    CHECK(value(run, "left.interaction.paper", "latency_min") == Approx(v_s / 15 + c_s).margin(2e-9));
    CHECK(value(run, "left.interaction.paper", "latency_mean") == Approx(v_s * 16 / 30 + c_s).margin(2e-9));
    CHECK(value(run, "left.interaction.direct", "latency_max") == 0);
  }
  SECTION("the schedule's latency is constant, the total one adds at most a tick") {
    CHECK(value(run, "left.force.paper", "schedule_latency") == 12'842'223e-9);
    CHECK(value(run, "left.force.paper", "schedule_latency_min") == 12'842'223e-9);
    CHECK(value(run, "left.force.paper", "schedule_latency_mean") == Approx(12'842'223e-9).epsilon(1e-15));
    CHECK(value(run, "left.force.paper", "schedule_latency_spread") == 0);
    CHECK(value(run, "left.force.paper", "total_latency_min") >= 12'842'223e-9);
    CHECK(value(run, "left.force.paper", "total_latency") < 12'842'223e-9 + 1e-3);
    CHECK(value(run, "left.force.paper", "late") == 0);
    CHECK(value(run, "left.force.paper", "felt") == 0);
  }
  SECTION("force at the ticks: the burst stands out of hold's own staircase") {
    // With hold emission a tick may see a force twice, so the second difference is at most one step.
    CHECK(value(run, "left.force.paper", "velocity_jump") / (200 * kStep_m) == Approx(1).margin(1e-5));
    CHECK(value(run, "left.force.direct", "jump_max") / (200 * kStep_m) == Approx((v_s + s_s) / kSlot_s).margin(1e-5));
    CHECK(value(run, "left.force.direct", "residual_20_500_hz") > 3 * value(run, "left.force.paper", "residual_20_500_hz"));
    CHECK(value(run, "left.force.direct", "deviation_max") > 2 * value(run, "left.force.paper", "deviation_max"));
  }
}

TEST_CASE("only steps after warm-up that are not acquiring are judged") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  const std::size_t all = paper.steps.size() - kFirstJudged;
  CHECK(value(run, "left.interaction.paper", "judged") == static_cast<double>(all));
  for (std::size_t n = 0; n < kFirstJudged; ++n) paper.devices[0].steps[n].position_m = {1e3, 0, 0};  // warm-up: anything
  CHECK(value(run, "left.interaction.paper", "velocity_jump") / kStep_m < kFloor);
  for (std::size_t n = kFirstJudged; n < kFirstJudged + 30; ++n) {
    paper.steps[n].acquiring = true;
    paper.devices[0].steps[n].position_m = {1e3, 0, 0};
  }
  CHECK(value(run, "left.interaction.paper", "judged") == static_cast<double>(all - 30));
  CHECK(value(run, "left.interaction.paper", "velocity_jump") / kStep_m < kFloor);
  for (StepRow& step : paper.steps) step.acquiring = true;
  CHECK(value(run, "left.interaction.paper", "judged") == 0);
  CHECK_FALSE(has(run, "left.interaction.paper", "velocity_jump"));  // no judged sample: no value, never a pass
  CHECK_FALSE(has(run, "left.interaction.paper", "underruns"));
  CHECK_FALSE(has(run, "left.force.paper", "late"));
}

TEST_CASE("a run that broke off within a step is judged to the step before") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  paper.devices[0].steps.resize(kFirstJudged + 7);
  CHECK(value(run, "left.interaction.paper", "judged") == 7);
  paper.devices[0].steps.clear();
  CHECK(value(run, "left.interaction.paper", "judged") == 0);
}

TEST_CASE("ticks are judged from the end of warm-up to before the end once a force is sent") {
  RunRecord run = synthetic::reference_run();
  DeviceRecord& device = strategy(run, "paper").devices[0];
  const auto judged = [&] { return value(run, "left.force.paper", "judged"); };
  CHECK(judged() == 2000 - 267);  // first tick at or after 266.666 ms
  run.nominal.end = RealTime{1'500'000'000};
  CHECK(judged() == 1500 - 267);  // the tick at the end is out
  for (std::size_t k = 0; k < 300; ++k) device.ticks[k].started = false;
  CHECK(judged() == 1500 - 300);
  for (TickRow& tick : device.ticks) tick.started = false;
  CHECK(judged() == 0);
  CHECK_FALSE(has(run, "left.force.paper", "jump_max"));
}

TEST_CASE("underruns and overruns are counted per step, rates per segment") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  Rows<StepSample>& steps = paper.devices[0].steps;
  steps[3].read = StepRead::underrun;  // in warm-up
  for (const std::size_t n : {kFirstJudged, kFirstJudged + 1, kFirstJudged + 40}) steps[n].read = StepRead::underrun;
  steps[kFirstJudged + 2].read = StepRead::overrun;
  const double segments = 60 - 8;
  CHECK(value(run, "left.interaction.paper", "underruns") == 3);
  CHECK(value(run, "left.interaction.paper", "underrun_rate") == Approx(2 / segments).epsilon(1e-15));
  CHECK(value(run, "left.interaction.paper", "overruns") == 1);
  paper.steps[kFirstJudged + 3].end =
      paper.steps[kFirstJudged + 3].emission + Duration{1};  // late, same segment as the first
  CHECK(value(run, "left.buffers.paper", "interaction_underruns") == 3);
  CHECK(value(run, "left.buffers.paper", "force_underruns") == 1);
  CHECK(value(run, "left.buffers.paper", "underruns") == 4);
  CHECK(value(run, "left.buffers.paper", "underrun_rate") == Approx(2 / segments).epsilon(1e-15));
  CHECK(value(run, "left.force.paper", "underruns") == value(run, "left.force.paper", "late"));
}

TEST_CASE("a read time that does not increase is a back-step, also one that stands still") {
  RunRecord run = synthetic::reference_run();
  Rows<StepRow>& steps = strategy(run, "paper").steps;
  steps[kFirstJudged + 5].read = steps[kFirstJudged + 4].read;
  steps[kFirstJudged + 50].read = steps[kFirstJudged + 49].read - Duration{1};
  CHECK(value(run, "left.interaction.paper", "back_steps") == 2);
}

TEST_CASE("a force that ends exactly at its emission time is not late, 1 ns later it is") {
  RunRecord run = synthetic::reference_run();
  StepRow& step = strategy(run, "paper").steps[kFirstJudged + 20];
  step.end = step.emission;
  CHECK(value(run, "left.force.paper", "late") == 0);
  step.end = step.emission + Duration{1};
  CHECK(value(run, "left.force.paper", "late") == 1);
}

TEST_CASE("with linear emission a force that ends where the line to it begins is not late, 1 ns later it is") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  paper = synthetic::strategy("paper", run.nominal.end, synthetic::kLead, {30'000'000});
  paper.devices[0].interpolates = true;
  StepRow& step = paper.steps[kFirstJudged + 20];
  step.end = paper.steps[kFirstJudged + 19].emission;
  CHECK(value(run, "left.force.paper", "late") == 0);
  step.end = step.end + Duration{1};
  CHECK(value(run, "left.force.paper", "late") == 1);
  CHECK(value(run, "left.buffers.paper", "underruns") == 1);
  step.lost = true;
  CHECK(value(run, "left.force.paper", "late") == 0);
}

TEST_CASE("felt counts each tick that wanted a force which was not there, hold and linear") {
  for (const bool hold : {true, false}) {
    RunRecord run = synthetic::reference_run();
    StrategyRecord& paper = strategy(run, "paper");
    paper = synthetic::strategy("paper", run.nominal.end, synthetic::kLead, {13'260'000});  // every ninth F falls on a tick
    paper.devices[0].interpolates = !hold;
    // Every 7th step is 0 to 6 ms longer. The counts must be those of a plain double loop.
    for (std::size_t n = kFirstJudged; n < paper.steps.size(); n += 7) {
      paper.steps[n].end = paper.steps[n].emission + Duration{static_cast<std::int64_t>(n % 60) * 100'000};
    }
    std::set<std::int64_t> ticks;
    for (std::size_t n = kFirstJudged; n < paper.steps.size(); ++n) {
      for (const TickRow& tick : paper.devices[0].ticks) {
        const bool wanted = hold ? tick.at >= paper.steps[n].emission : tick.at > paper.steps[n - 1].emission;
        if (tick.at >= run.nominal.judged_from && tick.started && wanted && tick.at < paper.steps[n].end)
          ticks.insert(tick.at.ns);
      }
    }
    CAPTURE(hold);
    REQUIRE(ticks.size() > 50);
    CHECK(value(run, "left.force.paper", "felt") == static_cast<double>(ticks.size()));
  }
}

TEST_CASE("total latency is from R to the first tick that sends the force, a force that no tick sends counts for nothing") {
  for (const std::int64_t rate : {1000, 450, 300, 100}) {  // 100 Hz: most forces are never sent
    RunRecord run = synthetic::reference_run();
    StrategyRecord& paper = strategy(run, "paper");
    paper = synthetic::strategy("paper", run.nominal.end, synthetic::kLead, {20'260'000});  // every ninth F falls on a tick
    Rows<TickRow>& ticks = paper.devices[0].ticks;
    ticks.clear();
    for (std::int64_t k = 0; k < 2 * rate; ++k) {
      ticks.push_back({});
      ticks.back().at = tick_time({rate, 1}, k);
      ticks.back().lateness = {k % 3 * 10'000};
      ticks.back().started = true;
    }
    double most = 0, least = 1;
    for (std::size_t n = kFirstJudged; n < paper.steps.size(); ++n) {
      for (const TickRow& tick : ticks) {
        const RealTime sent = tick.at + tick.lateness;
        if (sent < std::max(paper.steps[n].emission, paper.steps[n].end)) continue;
        const bool newest =
            n + 1 == paper.steps.size() || sent < std::max(paper.steps[n + 1].emission, paper.steps[n + 1].end);
        if (newest)
          most = std::max(most, seconds(sent - paper.steps[n].read)),
          least = std::min(least, seconds(sent - paper.steps[n].read));
        break;
      }
    }
    CHECK(value(run, "left.force.paper", "total_latency") == Approx(most).epsilon(1e-12));
    CHECK(value(run, "left.force.paper", "total_latency_min") == Approx(least).epsilon(1e-12));
  }
}

TEST_CASE("deviation_from_ideal compares step by step with the twin, per device, in judged steps") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  CHECK_FALSE(has(run, "left.force.paper", "deviation_from_ideal"));
  paper.devices.push_back(paper.devices[0]);
  paper.devices[1].name = "right";
  for (const StepSample& sample : paper.devices[0].steps)
    paper.twin_force_N.insert(paper.twin_force_N.end(), 2, sample.force_N);
  CHECK(value(run, "left.force.paper", "deviation_from_ideal") == 0);
  paper.twin_force_N[2 * (kFirstJudged + 9) + 1][1] += 0.25;  // right only
  paper.twin_force_N[0][0] += 9;                              // warm-up
  CHECK(value(run, "left.force.paper", "deviation_from_ideal") == 0);
  CHECK(value(run, "right.force.paper", "deviation_from_ideal") == Approx(0.25).epsilon(1e-14));
}

TEST_CASE("error_at_stop looks at 0.2 s around the stop and needs the true position") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  const RealTime stop{1'000'000'000};
  CHECK_FALSE(has(run, "left.interaction.paper", "error_at_stop"));
  run.nominal.devices[0].stop_at = stop;
  CHECK_FALSE(has(run, "left.interaction.paper", "error_at_stop"));
  for (std::size_t n = 0; n < paper.steps.size(); ++n) {
    StepSample& sample = paper.devices[0].steps[n];
    sample.true_position_m = sample.position_m;
    const std::int64_t away = std::abs((paper.steps[n].read - stop).ns);
    (*sample.true_position_m)[2] += away <= 100'000'000 ? 1e-4 : 1;  // far from the stop: ignored
  }
  CHECK(value(run, "left.interaction.paper", "error_at_stop") == Approx(1e-4).epsilon(1e-12));
}

TEST_CASE("error_max is the largest distance from the true position over all judged steps that know it") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  CHECK_FALSE(has(run, "left.interaction.paper", "error_max"));
  Rows<StepSample>& steps = paper.devices[0].steps;
  for (std::size_t n = 0; n < steps.size(); n += 2) steps[n].true_position_m = steps[n].position_m;  // the others: unknown
  CHECK(value(run, "left.interaction.paper", "error_max") == 0);
  CHECK_FALSE(has(run, "left.interaction.paper", "error_at_stop"));
  (*steps[kFirstJudged - 2].true_position_m)[1] += 1;  // warm-up
  for (std::size_t n = kFirstJudged; n < steps.size(); n += 2) {
    (*steps[n].true_position_m)[1] += 3e-4;
    (*steps[n].true_position_m)[2] -= n == 600 ? 4e-4 : 0;
    if (n == 598) CHECK(value(run, "left.interaction.paper", "error_max") == Approx(3e-4).epsilon(1e-12));
  }
  CHECK(value(run, "left.interaction.paper", "error_max") == Approx(5e-4).epsilon(1e-12));
}

TEST_CASE("lateness and waits are those of judged steps, of this device, each side by itself") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  paper.devices.push_back(paper.devices[0]);
  paper.devices[1].name = "right";
  for (const char* metric : {"gated", "gate_wait", "interaction_lateness_max", "force_lateness_max"})
    CHECK(value(run, "left.buffers.paper", metric) == 0);
  using Side = UnderrunRow::Side;
  const auto n = static_cast<std::int64_t>(kFirstJudged);
  paper.underruns = {
      {3, 0, Side::interaction, {90'000'000}, "gate"},  // warm-up
      {n, 0, Side::interaction, {1'000'000}, "gate"},     {n, 1, Side::interaction, {7'000'000}, "gate"},
      {n + 1, 0, Side::interaction, {2'500'000}, "gate"}, {n + 2, 0, Side::interaction, {4'000'000}, "clamp"},
      {n + 2, 0, Side::force, {3'000'000}, "hold"},       {n + 5, 0, Side::force, {2'000'000}, "extrapolate"}};
  CHECK(value(run, "left.buffers.paper", "gated") == 2);
  CHECK(value(run, "left.buffers.paper", "gate_wait") == 3.5e-3);
  CHECK(value(run, "left.buffers.paper", "interaction_lateness_max") == 4e-3);
  CHECK(value(run, "left.buffers.paper", "force_lateness_max") == 3e-3);
  CHECK(value(run, "right.buffers.paper", "gated") == 1);
  CHECK(value(run, "right.buffers.paper", "gate_wait") == 7e-3);
  CHECK(value(run, "right.buffers.paper", "force_lateness_max") == 0);
  CHECK(value(run, "left.buffers.direct", "gated") == 0);
}

TEST_CASE("neither a gated nor a predicted step is an underrun") {
  RunRecord run = synthetic::reference_run();
  Rows<StepSample>& steps = strategy(run, "paper").devices[0].steps;
  for (std::size_t n = 0; n < steps.size(); ++n) steps[n].read = n % 2 ? StepRead::gated : StepRead::predicted;
  CHECK(value(run, "left.interaction.paper", "underruns") == 0);
  CHECK(value(run, "left.buffers.paper", "interaction_underruns") == 0);
  const std::vector<BinRow> rows = bins(run).at("left.interaction.paper");
  for (const BinRow& row : rows) CHECK(row.underruns_so_far == 0);
}

TEST_CASE("segment_mean is the length as run, from the first segment judged whole, also with segments of no step") {
  for (const std::int64_t ratchet_ns : {0, 1, 1'000'000}) {
    RunRecord run = synthetic::reference_run();
    StrategyRecord& paper = strategy(run, "paper");
    std::erase_if(paper.steps, [](const StepRow& step) { return step.segment == 20; });
    paper.devices[0].steps.resize(paper.steps.size());
    for (StepRow& step : paper.steps) step.begin = step.begin + Duration{step.segment * ratchet_ns};
    // If the warm-up ends within a segment, judging begins with the next one. An instant of 30 Hz is floored to 1 ns.
    for (const std::int64_t later_ns : {0, 20'000'000}) {
      run.nominal.judged_from = tick_time(synthetic::kSegmentRate, 8) + Duration{later_ns};
      const double mean_s = 1.0 / 30 + static_cast<double>(ratchet_ns) * 1e-9;
      CHECK(value(run, "solver.paper", "segment_mean") == Approx(mean_s).margin(1e-10));
    }
    run.nominal.judged_from = paper.steps[paper.steps.size() - 15].begin;  // with one segment left there is no length
    CHECK_FALSE(has(run, "solver.paper", "segment_mean"));
  }
}

TEST_CASE("a strategy of variable steps is judged over its own simulation time, and has its own solver verdicts") {
  RunRecord run = synthetic::reference_run({3'000'000'000});
  StrategyRecord& direct = strategy(run, "direct");
  for (StepRow& step : direct.steps) step.simulated = SimTime{40'000'000'000 + step.begin.ns};
  CHECK(value(run, "left.interaction.direct", "deviation_max") / kStep_m > 2);  // over n * slot: the burst
  CHECK_FALSE(has(run, "solver.direct", "steps_over_limit"));
  CHECK_FALSE(has(run, "solver.direct", "step_over_limit_max"));
  direct.variable_step = direct.solver.variable_step = true;
  direct.solver.steps_over_limit = 7;
  direct.solver.step_over_limit_max = 5.66;
  CHECK(value(run, "left.interaction.direct", "deviation_max") / kStep_m < 1e-9);  // x = v z, exactly
  const std::vector<BinRow> rows = bins(run).at("left.interaction.direct");
  for (const BinRow& row : rows) CHECK(row.deviation_max / kStep_m < 1e-9);
  CHECK(value(run, "solver.direct", "steps_over_limit") == 7);
  CHECK(value(run, "solver.direct", "step_over_limit_max") == 5.66);
}

TEST_CASE("no nominal speed: no step ratio, a NaN position is a NaN metric") {
  RunRecord run = synthetic::reference_run();
  strategy(run, "paper").devices[0].steps[kFirstJudged + 3].position_m[0] = NAN;
  CHECK(std::isnan(value(run, "left.interaction.paper", "velocity_jump")));
  CHECK(std::isnan(value(run, "left.interaction.paper", "step_ratio_min")));
  CHECK(std::isnan(value(run, "left.interaction.paper", "step_ratio_max")));
  run.nominal.devices[0].speed_m_per_s.reset();
  CHECK_FALSE(has(run, "left.interaction.paper", "step_ratio_max"));
}

TEST_CASE("solver, buffers, counters, events and run carry what the record says") {
  RunRecord run = synthetic::reference_run();
  StrategyRecord& paper = strategy(run, "paper");
  paper.solver = {};
  paper.solver.substeps = 4;
  CHECK_FALSE(has(run, "solver.paper", "energy_growth"));
  for (const char* limit :
       {"step_size_over_limit", "step_limit", "rest_state_step_limit", "k_max", "limit_particle", "iterations"})
    CHECK_FALSE(has(run, "solver.paper", limit));
  paper.solver.has_energy = true;
  paper.solver.energy_growth = 1.5;
  paper.solver.step_limit_s = kSlot_s / 2;
  paper.solver.stiffness_limit_N_per_m = 0;  // the damping alone exceeds the limit
  paper.solver.limit_particle = 12;
  CHECK(value(run, "solver.paper", "k_max") == 0);
  paper.solver.stiffness_limit_N_per_m = 60;
  paper.solver.iterations = 5;
  paper.solver.non_finite = true;
  paper.solver.first_bad_step = 77;
  paper.latency.interaction_capacity = 14;
  paper.latency.least_any_phase = {12'842'223};
  paper.emission_repairs = 3;
  paper.devices[0].counters = {{"clamped", 5}, {"lost", 2}};
  CHECK(value(run, "solver.paper", "energy_growth") == 1.5);
  CHECK(value(run, "solver.paper", "step_size_over_limit") == Approx(0.5).epsilon(1e-15));  // slot / 4; limit: slot / 2
  CHECK(value(run, "solver.paper", "k_max") == 60);
  CHECK(value(run, "solver.paper", "limit_particle") == 12);
  CHECK(value(run, "solver.paper", "iterations") == 5);
  CHECK(value(run, "solver.paper", "non_finite") == 1);
  CHECK(value(run, "solver.paper", "first_bad_step") == 77);
  CHECK(value(run, "solver.direct", "first_bad_step") == -1);
  CHECK(value(run, "left.buffers.paper", "interaction_capacity") == 14);
  CHECK(value(run, "left.buffers.paper", "latency_any_phase") == 12'842'223e-9);
  CHECK(value(run, "left.buffers.paper", "lead") == 260'000e-9);
  CHECK(value(run, "left.force.paper", "emission_repairs") == 3);
  CHECK(value(run, "left.force.paper", "clamped") == 5);
  CHECK(value(run, "left.force.paper", "lost") == 2);
  paper.event_counts["completion.step"] = 40;
  strategy(run, "direct").event_counts["completion.step"] = 2;
  CHECK(value(run, "events.completion.step", "sometimes") == 42);
  CHECK(value(run, "run", "strategies") == 4);
  CHECK(value(run, "run", "judged_s") == Approx(2 - 8.0 / 30).margin(1e-9));
}

TEST_CASE("lateness is that of the live strategy's ticks on a wall clock: nearest-rank percentiles") {
  RunRecord run = synthetic::reference_run();
  CHECK(measure(run).count("events.device.tick") == 0);  // virtual time is never late
  run.clock = "wall";
  run.live = "paper";
  for (StrategyRecord& s : run.strategies) {
    s.shadow = s.name != "paper" && s.name != "ideal";  // `ideal` did not run live either
    s.devices[0].ticks.resize(1000);
    for (std::size_t k = 0; k < 1000; ++k)
      s.devices[0].ticks[k].lateness = {s.name != "paper" ? 1'000'000'000 : static_cast<std::int64_t>((k * 7) % 1000 + 1)};
  }
  CHECK(value(run, "events.device.tick", "lateness_p50") == 500e-9);
  CHECK(value(run, "events.device.tick", "lateness_p99") == 990e-9);
  CHECK(value(run, "events.device.tick", "lateness_max") == 1000e-9);
}

TEST_CASE("bins: the worst bin is the whole run's jump, a fault stands in its own second, underruns add up") {
  RunRecord run = synthetic::reference_run({5'000'000'000});
  StrategyRecord& paper = strategy(run, "paper");
  const auto step_at = [&](double t) {
    return static_cast<std::size_t>(
        std::find_if(paper.steps.begin(), paper.steps.end(), [&](const StepRow& s) { return seconds(s.begin) >= t; }) -
        paper.steps.begin());
  };
  const double from_s = seconds(run.nominal.judged_from);
  const std::size_t fault = step_at(from_s + 2.5);
  paper.devices[0].steps[fault].position_m[1] = 1e-3;
  for (const double t : {0.1, 0.2, 3.3}) paper.devices[0].steps[step_at(from_s + t)].read = StepRead::underrun;
  const BinLayout of_a_second{run.nominal.judged_from, {1'000'000'000}, 5};
  const auto rows = bins(run, of_a_second).at("left.interaction.paper");
  REQUIRE(rows.size() == 5);  // 4.73 s from the end of warm-up
  double worst = 0;
  for (std::size_t b = 0; b < rows.size(); ++b) {
    CHECK(rows[b].from_s == Approx(from_s + static_cast<double>(b)).margin(1e-9));
    if (b == 2) continue;
    CHECK(rows[b].deviation_max / kStep_m < kFloor);
    CHECK(rows[b].velocity_jump / kStep_m < kFloor);
    worst = std::max(worst, rows[b].velocity_jump);
  }
  CHECK(rows[2].velocity_jump == Approx(2e-3).epsilon(1e-3));
  CHECK(rows[2].velocity_jump == value(run, "left.interaction.paper", "velocity_jump"));
  const std::vector<std::int64_t> expected{2, 2, 2, 3, 3};
  for (std::size_t b = 0; b < rows.size(); ++b) CHECK(rows[b].underruns_so_far == expected[b]);
  CHECK(bins(run, of_a_second).at("left.force.paper").size() == 5);
}

TEST_CASE("no jump is lost at the edge of a bin: every place of a fault") {
  RunRecord run = synthetic::reference_run({1'000'000'000});
  StrategyRecord& paper = strategy(run, "paper");
  for (std::size_t n = kFirstJudged + 1; n + 1 < paper.steps.size(); ++n) {
    const double before = paper.devices[0].steps[n].position_m[1];
    paper.devices[0].steps[n].position_m[1] = 1e-3;
    RunRecord only = run;
    only.strategies = {paper};
    double worst = 0;
    const std::vector<BinRow> rows = bins(only, {run.nominal.judged_from, {100'000'000}, 8}).at("left.interaction.paper");
    for (const BinRow& row : rows) worst = std::max(worst, row.velocity_jump);
    CHECK(worst == Approx(2e-3).epsilon(1e-9));
    paper.devices[0].steps[n].position_m[1] = before;
  }
}

TEST_CASE("bins follow the length of the run: 60 to 119 of whole segments, fewer where there are fewer, at least twenty") {
  RunRecord run;
  run.nominal = synthetic::nominal({0});
  run.strategies.push_back(synthetic::strategy("paper", run.nominal.judged_from, {}, {}));
  for (std::int64_t ms = 1; ms < 1'000'000; ms = ms * 21 / 20 + 1) {
    run.nominal.end = run.nominal.judged_from + Duration{ms * 1'000'000};
    run.strategies[0].steps.assign(static_cast<std::size_t>(1 + ms * 450 / 1000), {.begin = run.nominal.judged_from});
    run.strategies[0].devices[0].steps.resize(run.strategies[0].steps.size());
    const BinLayout layout = bin_layout(run);
    const std::int64_t segments = ms * 1'000'000 / run.nominal.segment.ns;
    if (ms >= 20 * 9) CHECK((layout.count >= 20 && layout.count <= 120));  // four steps last 8.9 ms
    if (segments >= 20) CHECK(layout.width.ns % run.nominal.segment.ns == 0);
    if (segments >= 60) CHECK(layout.count >= 60);
    CHECK(layout.count >= 1);
    CHECK(layout.width.ns * layout.count <= ms * 1'000'000 + layout.width.ns / 2);
    CHECK(layout.width.ns * (2 * layout.count + 1) > 2 * ms * 1'000'000);  // the last bin is at most 1.5 times as long
  }
  run.nominal.end = run.nominal.judged_from;  // nothing is judged
  CHECK(bin_layout(run).count == 0);
  run.nominal.end = run.nominal.judged_from + Duration{-5};
  CHECK(bin_layout(run).count == 0);
}

TEST_CASE("bins are whole ways there and back where there are twenty of them, or four samples long where these are rare") {
  RunRecord run = synthetic::reference_run({30'000'000'000});
  CHECK(bin_layout(run).width.ns % run.nominal.segment.ns == 0);
  run.nominal.devices[0].turns = Nominal::Turns{{}, {400'000'000}, {100'000'000}};
  CHECK(bin_layout(run).width.ns == 1'000'000'000);
  run.nominal.devices[0].turns = Nominal::Turns{{}, {4'000'000'000}, {100'000'000}};  // only three turns
  CHECK(bin_layout(run).width.ns % run.nominal.segment.ns == 0);
  run.nominal.devices[0].rate = {1, 1};
  CHECK(bin_layout(run).width.ns == 4'000'000'000);
}

TEST_CASE("the bins together are what the run as a whole is judged by") {
  RunRecord run = synthetic::reference_run({3'000'000'000});
  for (const char* signal : {"left.interaction.direct", "left.force.direct"}) {
    const std::vector<BinRow> rows = bins(run).at(signal);
    double worst = 0;
    for (const BinRow& row : rows) worst = std::max(worst, row.deviation_max);
    CHECK(rows.size() >= 60);
    CHECK(worst == value(run, signal, "deviation_max"));
    CHECK(rows.front().from_s == seconds(run.nominal.judged_from));
    CHECK(rows.back().to_s == seconds(run.nominal.end));
    for (std::size_t b = 1; b < rows.size(); ++b) CHECK(rows[b].from_s == rows[b - 1].to_s);
  }
}
