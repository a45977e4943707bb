#pragma once
/// Records whose results are known: the paper's reference case (30 Hz, V = 11.1 ms, N = 15), constant velocity, a spring.

#include <algorithm>
#include <sstream>
#include <string>

#include "evenstep/reports/run_record.h"

namespace evenstep::synthetic {

inline constexpr double kSpeed_m_per_s = 0.1, kStiffness_N_per_m = 200;
inline constexpr Rate kSegmentRate{30, 1}, kStepRate{450, 1}, kTickRate{1000, 1};
inline constexpr std::int64_t kSteps = 15;
inline constexpr Duration kVisualization{11'100'000};
inline constexpr double kSlot_s = 1.0 / 450, kStep_m = kSpeed_m_per_s * kSlot_s;

/// The hand moves along +x only, so that closed forms stay one-dimensional.
inline Vec3 hand_at(RealTime t) { return {kSpeed_m_per_s * std::max(0.0, seconds(t)), 0, 0}; }
inline Vec3 times(double factor, const Vec3& v) { return {factor * v[0], factor * v[1], factor * v[2]}; }

inline Nominal nominal(Duration duration) {
  Nominal nominal;
  nominal.segment = {33'333'333};
  nominal.visualization = kVisualization;
  nominal.step_run_time = {1'482'222};
  nominal.slot_s = kSlot_s;
  nominal.judged_from = tick_time(kSegmentRate, 8);
  nominal.end = RealTime{} + duration;
  nominal.devices.push_back({"left", kSpeed_m_per_s, kStiffness_N_per_m, kTickRate, {}, std::nullopt});
  return nominal;
}

/// Adds the real begin and end of every step of the run, and the segments and visualizations.
inline void add_timing(StrategyRecord& strategy, RealTime end) {
  for (std::int64_t k = 0; tick_time(kSegmentRate, k) < end; ++k) {
    const RealTime begin = tick_time(kSegmentRate, k), next = tick_time(kSegmentRate, k + 1);
    strategy.segments.push_back({k, begin, next, {{begin, begin + kVisualization}}});
    const RealTime steps_from = begin + kVisualization;
    for (std::int64_t i = 0; i < kSteps; ++i) {
      StepRow step;
      step.segment = k;
      step.begin = steps_from + Duration{floor_mul_div(i, (next - steps_from).ns, kSteps)};
      step.end = steps_from + Duration{floor_mul_div(i + 1, (next - steps_from).ns, kSteps)};
      strategy.steps.push_back(step);
    }
  }
}

/// Adds what the device receives: the latest force with F <= tick.
inline void add_ticks(StrategyRecord& strategy, RealTime end) {
  DeviceRecord& device = strategy.devices.front();
  std::size_t next = 0;
  for (std::int64_t k = 0; tick_time(kTickRate, k) < end; ++k) {
    TickRow tick;
    tick.at = tick_time(kTickRate, k);
    tick.position_m = hand_at(tick.at);
    while (next < strategy.steps.size() && std::max(strategy.steps[next].emission, strategy.steps[next].end) <= tick.at)
      ++next;
    tick.started = next > 0;
    if (next > 0) tick.force_N = device.steps[next - 1].force_N;
    device.ticks.push_back(tick);
  }
}

inline StrategyRecord strategy(const std::string& name, RealTime end, Duration lead, Duration latency) {
  StrategyRecord strategy;
  strategy.name = name;
  strategy.latency.lead = lead;
  strategy.latency.latency = latency;
  strategy.devices.emplace_back().name = "left";
  add_timing(strategy, end);
  for (std::size_t n = 0; n < strategy.steps.size(); ++n) {
    StepRow& step = strategy.steps[n];
    step.mapped = name != "direct";
    step.read = step.mapped ? tick_time(kStepRate, static_cast<std::int64_t>(n)) - lead : step.begin;
    step.emission = step.mapped ? step.read + latency : step.end;
    step.line_from = n > 0 ? strategy.steps[n - 1].emission : step.emission;
    StepSample sample;
    sample.position_m = hand_at(step.read);
    sample.force_N = times(-kStiffness_N_per_m, sample.position_m);
    sample.read = step.mapped ? StepRead::inside : StepRead::newest;
    strategy.devices.front().steps.push_back(sample);
  }
  add_ticks(strategy, end);
  return strategy;
}

/// direct, paper, phase_locked and ideal side by side; c = h - V/N, L = s + V (1 - 1/N) + h.
inline constexpr Duration kLead{260'000}, kLatency{12'842'223};
inline RunRecord reference_run(Duration duration = {2'000'000'000}) {
  RunRecord run;
  run.scenario = "reference";
  run.file = "scenarios/paper/reference.toml";
  run.clock = "virtual";
  run.nominal = nominal(duration);
  for (const char* name : {"ideal", "direct", "paper", "phase_locked"}) {
    run.strategies.push_back(strategy(name, run.nominal.end, kLead, kLatency));
  }
  return run;
}

/// The text that a writer puts into its file.
template <class Write>
std::string written(Write write, const RunRecord& run) {
  std::ostringstream out;
  write(run, out);
  return std::move(out).str();
}

}  // namespace evenstep::synthetic
