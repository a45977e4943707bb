#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "evenstep/reports/measures.h"
#include "evenstep/reports/recovery.h"
#include "src/closed_loop.h"
#include "src/fits/sine_response.h"
#include "src/fits/straight.h"
#include "src/judged.h"
#include "src/line_measures.h"
#include "src/saturated_samples.h"
#include "src/shown_time.h"
#include "src/undelayed.h"
#include "src/vec3.h"

namespace evenstep {
namespace {

using internal::Series;
using Pieces = std::vector<internal::Window>;
using Values = std::map<std::string, double>;

constexpr Duration kAroundStop{100'000'000};  // error_at_stop: 0.2 s around the stop

/// Adds a metric. Without a value it is left out, and an expectation on it is then an error, never a pass.
void put(Values& values, const std::string& metric, double value, bool has_value = true) {
  if (has_value) values.emplace(metric, value);
}

/// The double nearest to a whole number of ns (a division rounds once, a product with 1e-9 would round twice), so that it is
/// the same number that parsing "12.842223 ms" gives.
double nearest_s(std::int64_t ns) { return static_cast<double>(ns) / 1e9; }
double nearest_s(Duration d) { return nearest_s(d.ns); }

/// Smallest, mean and largest of a list of durations; summed in integers.
struct Spread {
  std::int64_t count = 0, sum_ns = 0, least_ns = INT64_MAX, most_ns = INT64_MIN;
  void add(Duration d) {
    ++count;
    sum_ns += d.ns;
    least_ns = std::min(least_ns, d.ns);
    most_ns = std::max(most_ns, d.ns);
  }
  double min_s() const { return nearest_s(least_ns); }
  double max_s() const { return nearest_s(most_ns); }
  double mean_s() const { return static_cast<double>(sum_ns) / static_cast<double>(count) / 1e9; }
};

/// The smallest value that at least `share` of the sorted list does not exceed (nearest rank).
double percentile_s(std::span<const std::int64_t> sorted_ns, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted_ns.size())));
  return nearest_s(sorted_ns[std::max<std::size_t>(rank, 1) - 1]);
}

/// Share of the judged segments in which `bad` holds for at least one judged step.
template <class Bad>
double segment_rate(const StrategyRecord& strategy, const Rows<std::size_t>& steps, Bad bad) {
  std::int64_t all = 0, hit = 0, segment = -1;  // segments do not decrease
  bool counted = false;
  for (const std::size_t n : steps) {
    if (all == 0 || strategy.steps[n].segment != segment) {
      segment = strategy.steps[n].segment;
      ++all;
      counted = false;
    }
    if (counted || !bad(n)) continue;
    ++hit;
    counted = true;
  }
  return static_cast<double>(hit) / static_cast<double>(all);
}

template <class Each, class Predicate>
double count_of(const Each& rows, Predicate predicate) {
  return static_cast<double>(std::count_if(rows.begin(), rows.end(), predicate));
}

double saturated(const std::vector<SaturationCauses>& met) {
  return count_of(met, [](SaturationCauses causes) { return !causes.none(); });
}

/// Whether a piece has at least this many samples: any two lie on a line, so judging a line needs three.
bool any_with(std::size_t least, const Pieces& pieces) {
  return std::any_of(pieces.begin(), pieces.end(), [&](const internal::Window& piece) { return piece.size() >= least; });
}

void put_line(Values& values, const Series& series, const Pieces& pieces) {
  std::size_t straight = 0;
  for (const internal::Window& piece : pieces) straight += piece.size();
  put(values, "straight", static_cast<double>(straight));
  const Deviation line =
      internal::deviation(series.t_s, series.value, internal::windows(series.t_s, pieces, internal::kWindow_s));
  put(values, "deviation_max", line.max, any_with(3, pieces));
  put(values, "deviation_rms", line.rms, any_with(3, pieces));
  put(values, "velocity_jump", internal::velocity_jump(series.value, pieces), any_with(3, pieces));
}

void put_step_ratio(Values& values, const Series& series, const Pieces& pieces, std::optional<double> step_m) {
  if (!step_m || !any_with(2, pieces)) return;
  internal::Peak most;
  double smallest = INFINITY;
  for (const internal::Window& piece : pieces) {
    for (std::size_t n = piece.begin + 1; n < piece.end; ++n) {
      const double ratio = internal::norm(internal::minus(series.value[n], series.value[n - 1])) / *step_m;
      most.add(ratio);
      if (!(ratio >= smallest) && !std::isnan(smallest)) smallest = ratio;
    }
  }
  put(values, "step_ratio_max", most.value);
  put(values, "step_ratio_min", smallest);
}

/// Distance from the true position, over all steps that know it and over those around the stop.
void put_errors(Values& values, const StrategyRecord& strategy, const DeviceRecord& device, const Rows<std::size_t>& steps,
                std::optional<RealTime> stop) {
  internal::Peak all, at_stop;
  bool any = false, any_at_stop = false;
  for (const std::size_t n : steps) {
    if (!device.steps[n].true_position_m) continue;
    const double error_m = internal::norm(internal::minus(device.steps[n].position_m, *device.steps[n].true_position_m));
    all.add(error_m);
    any = true;
    const RealTime read = strategy.steps[n].read;
    if (!stop || read < *stop - kAroundStop || read > *stop + kAroundStop) continue;
    at_stop.add(error_m);
    any_at_stop = true;
  }
  put(values, "error_max", all.value, any);
  put(values, "error_at_stop", at_stop.value, any_at_stop);
}

void put_sine(Values& values, const std::optional<internal::SineResponse>& response) {
  if (!response) return;
  put(values, "gain", response->gain.value_or(0), response->gain.has_value());
  put(values, "phase_delay", response->delay_s);
  put(values, "distortion", response->distortion);
}

Values interaction_values(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device,
                          const Rows<std::size_t>& steps) {
  Values values;
  put(values, "judged", static_cast<double>(steps.size()));
  put(values, "saturated", saturated(internal::saturation_of_steps(strategy, device, steps)));
  if (steps.empty()) return values;
  const Series series = internal::interaction_series(strategy, device, steps, run.nominal.slot_s);
  const Nominal::Device* nominal = internal::nominal_device(run.nominal, device.name);
  const Pieces pieces = internal::straight_steps(strategy, nominal, steps);
  put_line(values, series, pieces);
  put_step_ratio(values, series, pieces, step_unit(run.nominal, device.name + ".interaction." + strategy.name));
  Spread latency;
  std::int64_t back_steps = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const StepRow& step = strategy.steps[steps[i]];
    latency.add(step.begin - step.read);
    if (i > 0 && step.read <= strategy.steps[steps[i - 1]].read) ++back_steps;
  }
  put(values, "latency_min", latency.min_s());
  put(values, "latency_mean", latency.mean_s());
  put(values, "latency_max", latency.max_s());
  put(values, "back_steps", static_cast<double>(back_steps));
  const auto underrun = [&](std::size_t n) { return device.steps[n].read == StepRead::underrun; };
  put(values, "underruns", count_of(steps, underrun));
  put(values, "underrun_rate", segment_rate(strategy, steps, underrun));
  put(values, "overruns", count_of(steps, [&](std::size_t n) { return device.steps[n].read == StepRead::overrun; }));
  put_errors(values, strategy, device, steps, nominal ? nominal->stop_at : std::nullopt);
  put_sine(values, internal::interaction_response(run, strategy, device, steps));
  return values;
}

/// The first instant at which a tick needs the force. One at the begin of the line that leads to it does not.
RealTime needed_from(const StepRow& step, const DeviceRecord& device) {
  return std::min(step.emission, deadline(step, device) + Duration{1});
}

/// The number of ticks that needed a force which was not there yet: in [needed, E) of some judged step; each tick counts
/// once.
std::int64_t felt(const StrategyRecord& strategy, const DeviceRecord& device, const Rows<std::size_t>& steps,
                  const Rows<std::size_t>& ticks) {
  std::vector<bool> hit(ticks.size());  // by place among `ticks`
  for (const std::size_t n : steps) {
    const RealTime from = needed_from(strategy.steps[n], device), to = arrival(strategy.steps[n]);
    if (to <= from || strategy.steps[n].lost) continue;
    auto k = std::lower_bound(ticks.begin(), ticks.end(), from,
                              [&](std::size_t tick, RealTime at) { return internal::sent_at(device.ticks[tick]) < at; });
    for (; k != ticks.end() && internal::sent_at(device.ticks[*k]) < to; ++k)
      hit[static_cast<std::size_t>(k - ticks.begin())] = true;
  }
  return std::count(hit.begin(), hit.end(), true);
}

/// The time from R(n) to the first tick that sends f_n, which is the first at or after max(F(n), E(n)) (a completion comes
/// before a tick of the same instant). A step whose successor is already sent by that tick is never felt and does not count.
Spread total_latency(const StrategyRecord& strategy, const DeviceRecord& device, const Rows<std::size_t>& shown) {
  const auto ready = [&](std::size_t i) { return internal::ready(strategy.steps[shown[i]]); };
  Spread spread;
  std::size_t k = 0;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    while (k < device.ticks.size() && internal::sent_at(device.ticks[k]) < ready(i)) ++k;
    if (k == device.ticks.size()) break;
    const RealTime sent = internal::sent_at(device.ticks[k]);
    if (i + 1 < shown.size() && ready(i + 1) <= sent) continue;
    spread.add(sent - strategy.steps[shown[i]].read);
  }
  return spread;
}

void put_latencies(Values& values, const StrategyRecord& strategy, const DeviceRecord& device,
                   const Rows<std::size_t>& steps, const Rows<std::size_t>& shown) {
  Spread schedule;
  Rows<std::int64_t> scheduled_ns(strategy.steps.get_allocator());
  for (const std::size_t n : steps) {
    const Duration latency = strategy.steps[n].emission - strategy.steps[n].read;
    schedule.add(latency);
    scheduled_ns.push_back(latency.ns);
  }
  std::sort(scheduled_ns.begin(), scheduled_ns.end());
  put(values, "schedule_latency", schedule.max_s());
  put(values, "schedule_latency_min", schedule.min_s());
  put(values, "schedule_latency_mean", schedule.mean_s());
  put(values, "schedule_latency_p50", percentile_s(scheduled_ns, 0.5));
  put(values, "schedule_latency_spread", nearest_s(schedule.most_ns - schedule.least_ns));
  const Spread total = total_latency(strategy, device, shown);
  if (total.count == 0) return;
  put(values, "total_latency", total.max_s());
  put(values, "total_latency_min", total.min_s());
  put(values, "total_latency_mean", total.mean_s());
}

void put_animation_error(Values& values, const StrategyRecord& strategy,
                         const std::optional<internal::AnimationError>& error) {
  if (!error || strategy.continues) return;
  put(values, "animation_error", error->max_s);
  put(values, "animation_error_mean", error->mean_s);
}

void put_deviation_from_ideal(Values& values, const StrategyRecord& strategy, std::size_t device,
                              const Rows<std::size_t>& steps) {
  internal::Peak peak;
  bool judged = false;
  for (const std::size_t n : steps) {
    const std::size_t twin = n * strategy.devices.size() + device;
    if (twin >= strategy.twin_force_N.size()) break;
    peak.add(internal::norm(internal::minus(strategy.devices[device].steps[n].force_N, strategy.twin_force_N[twin])));
    judged = true;
  }
  put(values, "deviation_from_ideal", peak.value, judged);
}

/// What became of the ticks and forces of the whole run.
void put_flow(Values& values, const DeviceRecord& device) {
  if (!device.flow) return;
  const DeviceFlow& flow = *device.flow;
  put(values, "forces", static_cast<double>(flow.forces));
  put(values, "forces_sent", static_cast<double>(flow.forces_sent));
  put(values, "forces_overtaken", static_cast<double>(flow.forces_overtaken));
  put(values, "forces_dropped", static_cast<double>(flow.forces_dropped));
  put(values, "forces_pending", static_cast<double>(flow.forces_pending));
  put(values, "ticks_unforced", static_cast<double>(flow.ticks_unforced));
  put(values, "ticks_underrun", static_cast<double>(flow.ticks_underrun));
  put(values, "ticks_overrun", static_cast<double>(flow.ticks_overrun));
  const auto reports = device.counters.find("reports"), stale = device.counters.find("stale");
  if (reports == device.counters.end() || stale == device.counters.end()) return;
  const double ticks_with_report = static_cast<double>(device.ticks.size()) - stale->second;
  put(values, "reports_overtaken", reports->second - ticks_with_report);
}

void put_recovery(Values& values, const RunRecord& run, const StrategyRecord& strategy, std::size_t device) {
  const Recovery recovery = recovery_of(run, strategy, device);
  if (recovery.state != Recovery::State::recovered && recovery.state != Recovery::State::never) return;
  put(values, "recovery_time", recovery.time_s());
  for (std::size_t part = 0; part < kRecoveryParts.size(); ++part)
    put(values, std::string("recovery_time_") + kRecoveryParts[part], recovery.part_s[part]);
  put(values, "recovered", recovery.state == Recovery::State::recovered ? 1 : 0);
}

Values force_values(const RunRecord& run, const StrategyRecord& strategy, std::size_t device_index,
                    const Rows<std::size_t>& steps) {
  const DeviceRecord& device = strategy.devices[device_index];
  const Rows<std::size_t> ticks = internal::judged_ticks(device, run.nominal);
  const Nominal::Device* nominal = internal::nominal_device(run.nominal, device.name);
  Values values;
  put(values, "judged", static_cast<double>(ticks.size()));
  put(values, "saturated", saturated(internal::saturation_of_ticks(strategy, device, ticks)));
  put(values, "emission_repairs", static_cast<double>(strategy.emission_repairs));
  put(values, "latency_growths", static_cast<double>(strategy.latency_growths));
  for (const auto& [name, count] : device.counters) put(values, name, count);
  put_flow(values, device);
  put_recovery(values, run, strategy, device_index);
  if (!ticks.empty()) {
    const Series series = internal::force_series(device, ticks, run.nominal.judged_from);
    const Pieces pieces = internal::straight_ticks(strategy, device, nominal, ticks);
    put_line(values, series, pieces);
    put(values, "jump_max", jump_max(series.value), series.value.size() >= 2);
    put(values, "rise_max", rise_max(series.value), series.value.size() >= 2);
    const double residual_N =
        internal::band_rms(series.t_s, series.value, internal::windows(series.t_s, pieces, internal::kWindow_s), 20, 500);
    put(values, "residual_20_500_hz", residual_N, any_with(3, pieces));
    values.merge(internal::undelayed_values(device, ticks, nominal ? nominal->stop_at : std::nullopt));
  }
  if (steps.empty()) return values;
  const auto late = [&](std::size_t n) { return is_late(strategy.steps[n], device); };
  put(values, "late", count_of(steps, late));
  put(values, "underruns", count_of(steps, late));
  put(values, "underrun_rate", segment_rate(strategy, steps, late));
  put(values, "felt", static_cast<double>(felt(strategy, device, steps, ticks)));
  const Rows<std::size_t> shown = internal::shown_steps(strategy, steps);
  put_latencies(values, strategy, device, steps, shown);
  put_animation_error(values, strategy, internal::animation_error(strategy, device, shown, ticks, run.nominal.slot_s));
  put_deviation_from_ideal(values, strategy, device_index, steps);
  put_sine(values, internal::force_response(run, strategy, device, steps, ticks));
  return values;
}

/// How late samples and forces were in judged steps; 0 if none was late.
void put_lateness_of_underruns(Values& values, const StrategyRecord& strategy, std::size_t device,
                               const Rows<std::size_t>& steps) {
  std::int64_t gated = 0;
  Duration gate_wait, interaction, force;
  for (const UnderrunRow& row : strategy.underruns) {
    if (row.device != device || !std::binary_search(steps.begin(), steps.end(), static_cast<std::size_t>(row.step)))
      continue;
    Duration& most = row.side == UnderrunRow::Side::interaction ? interaction : force;
    most = std::max(most, row.lateness);
    if (row.policy != "gate") continue;
    ++gated;
    gate_wait = gate_wait + row.lateness;
  }
  put(values, "gated", static_cast<double>(gated));
  put(values, "gate_wait", nearest_s(gate_wait));
  put(values, "interaction_lateness_max", nearest_s(interaction));
  put(values, "force_lateness_max", nearest_s(force));
}

Values buffer_values(const StrategyRecord& strategy, std::size_t device_index, const Rows<std::size_t>& steps) {
  const DeviceRecord& device = strategy.devices[device_index];
  const LatencyRecord& latency = strategy.latency;
  Values values;
  put(values, "interaction_capacity", static_cast<double>(latency.interaction_capacity));
  put(values, "force_capacity", static_cast<double>(latency.force_capacity));
  put(values, "predicted_interaction_underruns", static_cast<double>(device.predicted_interaction_underruns));
  put(values, "predicted_late_forces", static_cast<double>(device.predicted_late_forces));
  put(values, "lead", nearest_s(latency.lead));
  put(values, "latency", nearest_s(latency.latency));
  put(values, "latency_any_phase", nearest_s(latency.least_any_phase));
  put(values, "latency_this_phase", nearest_s(latency.least_this_phase));
  put(values, "played_age", device.loop.played_age_s.value_or(0), device.loop.played_age_s.has_value());
  put(values, "least_entries", static_cast<double>(latency.least_entries), latency.least_entries > 0);
  if (steps.empty()) return values;
  const auto underrun = [&](std::size_t n) { return device.steps[n].read == StepRead::underrun; };
  const auto late = [&](std::size_t n) { return is_late(strategy.steps[n], device); };
  put(values, "interaction_underruns", count_of(steps, underrun));
  put(values, "force_underruns", count_of(steps, late));
  put(values, "underruns", count_of(steps, underrun) + count_of(steps, late));
  put(values, "underrun_rate", segment_rate(strategy, steps, [&](std::size_t n) { return underrun(n) || late(n); }));
  put(values, "overruns", count_of(steps, [&](std::size_t n) { return device.steps[n].read == StepRead::overrun; }));
  put_lateness_of_underruns(values, strategy, device_index, steps);
  return values;
}

/// The mean length of the segments as they ran, from first step to first step: from the first segment that was judged
/// completely to the last one.
void put_segment_mean(Values& values, const StrategyRecord& strategy, const Rows<std::size_t>& steps) {
  const StepRow *first = nullptr, *last = nullptr;
  for (const std::size_t n : steps) {
    if (n > 0 && strategy.steps[n - 1].segment == strategy.steps[n].segment) continue;
    if (!first) first = &strategy.steps[n];
    last = &strategy.steps[n];
  }
  if (first == last) return;
  const auto segments = static_cast<double>(last->segment - first->segment);
  put(values, "segment_mean", static_cast<double>((last->begin - first->begin).ns) / segments / 1e9);
}

/// What was drawn in the judged span, if anything is drawn at all.
void put_drawings(Values& values, const StrategyRecord& strategy, RealTime from, RealTime end) {
  const auto draws = [](const SegmentRow& row) { return row.visualization || row.left_out; };
  if (from >= end || std::none_of(strategy.segments.begin(), strategy.segments.end(), draws)) return;
  std::int64_t drawings = 0, left_out = 0;
  Duration pause, interval;
  RealTime last = from;
  for (const SegmentRow& row : strategy.segments) {
    left_out += row.left_out && row.begin >= from && row.begin < end ? 1 : 0;
    if (!row.visualization) continue;
    const auto [began, ended] = *row.visualization;
    if (ended <= from || began >= end) continue;
    pause = std::max(pause, std::min(ended, end) - began);
    if (!row.finishes || ended >= end) continue;
    ++drawings;
    interval = std::max(interval, ended - last);
    last = ended;
  }
  put(values, "drawing_rate", static_cast<double>(drawings) / seconds(end - from));
  put(values, "drawings_left_out", static_cast<double>(left_out));
  put(values, "drawing_pause_max", seconds(pause));
  put(values, "drawing_interval_max", seconds(std::max(interval, end - last)));
}

/// How much simulation time passes per second of real time: one slot for each step that begins.
void put_pace(Values& values, const StrategyRecord& strategy, const Rows<std::size_t>& steps, double slot_s) {
  if (steps.size() < 2 || strategy.variable_step) return;
  const StepRow &first = strategy.steps[steps.front()], &last = strategy.steps[steps.back()];
  if (first.begin >= last.begin) return;
  const auto simulated_s = static_cast<double>(steps.back() - steps.front()) * slot_s;
  put(values, "simulated_per_real", simulated_s / seconds(last.begin - first.begin));
}

/// How many steps would have simulated the time that the loop dropped, in the whole run.
void put_dropped(Values& values, const StrategyRecord& strategy, double slot_s) {
  if (strategy.steps.empty() || !strategy.steps.front().clock || !strategy.steps.back().clock) return;
  const double passed_s = seconds(*strategy.steps.back().clock) - seconds(*strategy.steps.front().clock);
  put(values, "steps_dropped", std::round(passed_s / slot_s - static_cast<double>(strategy.steps.size() - 1)));
}

Values solver_values(const StrategyRecord& strategy, const Rows<std::size_t>& steps, double slot_s) {
  const SolverRecord& solver = strategy.solver;
  Values values;
  put(values, "energy_growth", solver.energy_growth, solver.has_energy);
  put(values, "non_finite", solver.non_finite ? 1 : 0);
  put(values, "first_bad_step", static_cast<double>(solver.first_bad_step));
  put(values, "step_size_over_limit", slot_s / solver.substeps / solver.step_limit_s, solver.step_limit_s > 0);
  put(values, "substeps", solver.substeps);
  put(values, "particles", static_cast<double>(solver.particles));
  put(values, "step_limit", solver.step_limit_s, solver.step_limit_s > 0);
  put(values, "rest_state_step_limit", solver.rest_state_step_limit_s, solver.rest_state_step_limit_s > 0);
  put(values, "k_max", solver.stiffness_limit_N_per_m, solver.step_limit_s > 0);
  put(values, "limit_particle", static_cast<double>(solver.limit_particle), solver.step_limit_s > 0);
  put(values, "iterations", solver.iterations, solver.iterations > 0);
  put(values, "solver_seconds", solver.solver_seconds);
  put(values, "steps_begun", static_cast<double>(strategy.steps_begun), strategy.steps_due != 0);
  const std::int64_t due = strategy.steps_due.value_or(0);
  put(values, "steps_not_begun", static_cast<double>(due - strategy.steps_begun), due > 0);
  put(values, "steps_over_limit", static_cast<double>(solver.steps_over_limit), solver.variable_step);
  put(values, "step_over_limit_max", solver.step_over_limit_max, solver.variable_step);
  put_segment_mean(values, strategy, steps);
  put_pace(values, strategy, steps, slot_s);
  put_dropped(values, strategy, slot_s);
  return values;
}

/// The number of ticks of the device's grid before the run's end that never ran, because a tick before them ran late. If a
/// recording was cut off, the device lane may go on past the end of the time that both lanes cover.
std::int64_t missed_ticks(const Rows<TickRow>& ticks, const Nominal::Device& device, RealTime end) {
  if (!ticks.empty()) end = std::max(end, ticks.back().at + Duration{1});
  return first_tick_at_or_after(device.rate, end, device.first_tick) - std::ssize(ticks);
}

/// The lateness of all ticks of the strategy that ran live. Shadows and the ideal twin ran in virtual time, in which nothing
/// is late.
void put_lateness(Values& values, const RunRecord& run) {
  std::vector<std::int64_t> lateness_ns;
  std::int64_t misses = 0;
  for (const StrategyRecord& strategy : run.strategies) {
    if (strategy.name != run.live) continue;
    for (std::size_t d = 0; d < strategy.devices.size(); ++d) {
      const Rows<TickRow>& ticks = strategy.devices[d].ticks;
      for (const TickRow& tick : ticks) lateness_ns.push_back(tick.lateness.ns);
      misses += missed_ticks(ticks, run.nominal.devices[d], run.nominal.end);
    }
  }
  if (lateness_ns.empty()) return;
  std::sort(lateness_ns.begin(), lateness_ns.end());
  put(values, "lateness_p50", percentile_s(lateness_ns, 0.5));
  put(values, "lateness_p99", percentile_s(lateness_ns, 0.99));
  put(values, "lateness_p999", percentile_s(lateness_ns, 0.999));
  put(values, "lateness_max", nearest_s(lateness_ns.back()));
  put(values, "ticks_run", static_cast<double>(lateness_ns.size()));
  put(values, "deadline_misses", static_cast<double>(misses));
  put(values, "deadline_miss_share", static_cast<double>(misses) / static_cast<double>(misses + std::ssize(lateness_ns)));
}

Values run_values(const RunRecord& run) {
  Values values;
  put(values, "judged_s", nearest_s(run.nominal.end - run.nominal.judged_from));
  put(values, "real_time_granted", run.real_time_granted ? 1 : 0);
  put(values, "strategies", static_cast<double>(run.strategies.size()));
  put(values, "left_out", static_cast<double>(run.left_out.size()));
  return values;
}

}  // namespace

double value_or_0(const Metrics& metrics, const std::string& signal, const std::string& metric) {
  const auto values = metrics.find(signal);
  if (values == metrics.end()) return 0;
  const auto value = values->second.find(metric);
  return value == values->second.end() ? 0 : value->second;
}

Metrics measure(const RunRecord& run) {
  Metrics metrics;
  for (const StrategyRecord& strategy : run.strategies) {
    const Rows<std::size_t> steps = internal::judged_steps(strategy, run.nominal);
    for (std::size_t d = 0; d < strategy.devices.size(); ++d) {
      const DeviceRecord& device = strategy.devices[d];
      metrics[device.name + ".interaction." + strategy.name] = interaction_values(run, strategy, device, steps);
      metrics[device.name + ".force." + strategy.name] = force_values(run, strategy, d, steps);
      metrics[device.name + ".buffers." + strategy.name] = buffer_values(strategy, d, steps);
      metrics["closed_loop." + device.name + "." + strategy.name] = internal::closed_loop_values(run, device);
    }
    metrics["solver." + strategy.name] = solver_values(strategy, steps, run.nominal.slot_s);
    put_drawings(metrics["solver." + strategy.name], strategy, run.nominal.judged_from, run.nominal.end);
    for (const auto& [event, count] : strategy.event_counts)
      metrics["events." + event]["sometimes"] += static_cast<double>(count);
  }
  if (run.clock == "wall") put_lateness(metrics["events.device.tick"], run);
  metrics["run"] = run_values(run);
  return metrics;
}

}  // namespace evenstep
