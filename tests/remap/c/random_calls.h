#pragma once
/// Random options and calls, with which C, C++ and C# (tests/embedding/csharp) are compared.

#include <evenstep_remap.h>

#include "../schedules.h"
#include "remap_c_calls.h"

namespace evenstep::testing {

/// The calls of both threads in order. At the same instant an end comes first, then a tick, then a beginning.
inline std::vector<remap_c_call> calls_of(const Schedule& schedule, Draw& draw) {
  std::vector<remap_c_call> calls;
  const auto call = [&](int what, RealTime at) {
    remap_c_call& made = calls.emplace_back();
    made.what = what;
    made.at_ns = at.ns;
    if (what != REMAP_C_SAMPLE && what != REMAP_C_END_STEP) return;
    for (double& component : made.value) component = draw.unit() - 0.5;
  };
  std::int64_t k = first_tick_at_or_after({1000, 1}, schedule.front().begin);
  const auto ticks_until = [&](RealTime at, bool including) {
    for (; tick_time({1000, 1}, k) < at || (including && tick_time({1000, 1}, k) == at); ++k) {
      call(REMAP_C_SAMPLE, tick_time({1000, 1}, k));
      call(REMAP_C_FORCE, tick_time({1000, 1}, k));
    }
  };
  for (const Segment& segment : schedule) {
    ticks_until(segment.begin, true);
    call(REMAP_C_SEGMENT, segment.begin);
    for (const StepTimes& step : segment.steps) {
      ticks_until(step.begin, true);
      call(REMAP_C_BEGIN_STEP, step.begin);
      ticks_until(step.end, false);
      call(REMAP_C_END_STEP, step.end);
    }
  }
  return calls;
}

inline evenstep_remap_options random_options(evenstep_remap_options options, Draw& draw) {
  options.components = static_cast<std::uint32_t>(draw.between(1, 8));
  options.lead_ns = draw.between(-2'000'000, 2'000'000);
  options.latency_ns = draw.between(0, 30'000'000);
  options.emission = static_cast<std::uint32_t>(draw.between(0, 1));
  options.adapts = static_cast<std::uint32_t>(draw.between(0, 1));
  options.sample_capacity = static_cast<std::uint32_t>(draw.between(2, 64));
  options.force_capacity = static_cast<std::uint32_t>(draw.between(2, 64));
  options.sample_window_ns = draw.between(0, 8'000'000);
  options.sample_furthest_ns = draw.between(0, 8'000'000);
  options.force_window_ns = draw.between(0, 8'000'000);
  options.force_furthest_ns = draw.between(0, 8'000'000);
  options.adapt_start_ns = draw.between(0, 5'000'000);
  options.adapt_most_ns = draw.between(5'000'000, 50'000'000);
  return options;
}

}  // namespace evenstep::testing
