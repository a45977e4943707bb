#include "evenstep/reports/places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "evenstep/reports/measures.h"
#include "src/fits/line_fit.h"
#include "src/fits/straight.h"
#include "src/judged.h"
#include "src/vec3.h"

namespace evenstep {
namespace {

using internal::minus;
using internal::norm;
using Kind = MetricSamples::Kind;
using Side = UnderrunRow::Side;

/// What a signal "<device>.<kind>.<strategy>" names.
struct Source {
  const RunRecord& run;
  const StrategyRecord& strategy;
  const DeviceRecord& device;
  std::size_t device_index;
  const Nominal::Device* nominal = internal::nominal_device(run.nominal, device.name);
  Rows<std::size_t> steps = internal::judged_steps(strategy, run.nominal);
  Rows<std::size_t> ticks = internal::judged_ticks(device, run.nominal);

  MetricSample step(std::size_t n, double amount) const {
    return {static_cast<std::int64_t>(n), strategy.steps[n].begin, amount};
  }
  MetricSample tick(std::size_t k, double amount) const {
    return {static_cast<std::int64_t>(k), device.ticks[k].at, amount};
  }
};

MetricSamples of_steps(const Source& source, Kind kind, const char* word = "") {
  return {kind, "step", word, Rows<MetricSample>(source.steps.get_allocator())};
}
MetricSamples of_ticks(const Source& source, Kind kind) {
  return {kind, "tick", "", Rows<MetricSample>(source.ticks.get_allocator())};
}

std::string exact_ms(Duration d) {
  std::string text = fmt::format("{:.6f}", static_cast<double>(d.ns) * 1e-6);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " ms";
}

MetricSamples late(const Source& source) {
  MetricSamples found = of_steps(source, Kind::count, "late");
  Duration most;
  for (const std::size_t n : source.steps) {
    const StepRow& step = source.strategy.steps[n];
    if (!is_late(step, source.device)) continue;
    const Duration by = arrival(step) - deadline(step, source.device);
    most = std::max(most, by);
    found.samples.push_back(source.step(n, seconds(by)));
  }
  found.now = {source.strategy.latency.lead, source.strategy.latency.latency};
  if (!source.strategy.latency.adapts) late_by(found, most);
  return found;
}

MetricSamples missing(const Source& source) {
  MetricSamples found = of_steps(source, Kind::count, "missing its sample");
  Duration most;
  for (const UnderrunRow& row : source.strategy.underruns) {
    const auto n = static_cast<std::size_t>(row.step);
    if (row.device != source.device_index || row.side != Side::interaction) continue;
    if (!std::binary_search(source.steps.begin(), source.steps.end(), n)) continue;
    if (source.device.steps[n].read != StepRead::underrun) continue;
    most = std::max(most, row.lateness);
    found.samples.push_back(source.step(n, seconds(row.lateness)));
  }
  found.now = {source.strategy.latency.lead, source.strategy.latency.latency};
  if (!source.strategy.latency.adapts) missing_by(found, most);
  return found;
}

MetricSamples overruns(const Source& source) {
  MetricSamples found = of_steps(source, Kind::count, "reading what the ring no longer holds");
  for (const std::size_t n : source.steps) {
    if (source.device.steps[n].read == StepRead::overrun) found.samples.push_back(source.step(n, NAN));
  }
  return found;
}

MetricSamples back_steps(const Source& source) {
  MetricSamples found = of_steps(source, Kind::count, "stepping back");
  for (std::size_t i = 1; i < source.steps.size(); ++i) {
    const Duration back = source.strategy.steps[source.steps[i - 1]].read - source.strategy.steps[source.steps[i]].read;
    if (back.ns >= 0) found.samples.push_back(source.step(source.steps[i], seconds(back)));
  }
  return found;
}

/// One sample for each item of `rows` for which `amount(row)` has a value.
template <class Amount>
MetricSamples each_step(const Source& source, Kind kind, Amount amount) {
  MetricSamples found = of_steps(source, kind);
  for (const std::size_t n : source.steps) {
    if (const std::optional<double> value = amount(n)) found.samples.push_back(source.step(n, *value));
  }
  return found;
}

/// The measures of plain series, sample by sample, within each straight piece: a velocity jump belongs to the middle one of
/// its three samples, a change between two samples to the second.
MetricSamples of_series(MetricSamples found, const internal::Series& series, std::string_view metric,
                        const Rows<MetricSample>& rows, const std::vector<internal::Window>& pieces) {
  const Rows<Vec3>& x = series.value;
  const auto add = [&](std::size_t i, double amount) {
    found.samples.push_back(rows[i]);
    found.samples.back().amount = amount;
  };
  if (metric == "velocity_jump") {
    for (const internal::Window& piece : pieces) {
      for (std::size_t i = piece.begin + 1; i + 1 < piece.end; ++i)
        add(i, norm(minus(minus(x[i + 1], x[i]), minus(x[i], x[i - 1]))));
    }
  } else if (metric == "deviation_max") {
    for (const internal::Window& window : internal::windows(series.t_s, pieces, internal::kWindow_s)) {
      if (window.size() < 3) continue;
      const std::vector<Vec3> residual = internal::line_residual(std::span(series.t_s).subspan(window.begin, window.size()),
                                                                 std::span(x).subspan(window.begin, window.size()));
      for (std::size_t i = 0; i < residual.size(); ++i) add(window.begin + i, norm(residual[i]));
    }
  } else {  // the change from one sample to the next
    for (const internal::Window& piece : pieces) {
      for (std::size_t i = piece.begin + 1; i < piece.end; ++i) add(i, norm(minus(x[i], x[i - 1])));
    }
  }
  return found;
}

std::optional<MetricSamples> of_interaction(const Source& source, const std::string& signal, std::string_view metric) {
  const StrategyRecord& strategy = source.strategy;
  const DeviceRecord& device = source.device;
  if (metric == "underruns") return missing(source);
  if (metric == "overruns") return overruns(source);
  if (metric == "back_steps") return back_steps(source);
  if (metric == "latency_max" || metric == "latency_min") {
    return each_step(source, metric == "latency_max" ? Kind::largest : Kind::least, [&](std::size_t n) {
      return std::optional(seconds(strategy.steps[n].begin - strategy.steps[n].read));
    });
  }
  if (metric == "error_max") {
    return each_step(source, Kind::largest, [&](std::size_t n) -> std::optional<double> {
      const StepSample& step = device.steps[n];
      if (!step.true_position_m) return std::nullopt;
      return norm(minus(step.position_m, *step.true_position_m));
    });
  }
  const std::optional<double> step_m = step_unit(source.run.nominal, signal);
  const bool ratio = (metric == "step_ratio_max" || metric == "step_ratio_min") && step_m;
  if (metric != "velocity_jump" && metric != "deviation_max" && !ratio) return std::nullopt;
  Rows<MetricSample> rows(source.steps.get_allocator());
  for (const std::size_t n : source.steps) rows.push_back(source.step(n, 0));
  MetricSamples found = of_series(of_steps(source, metric == "step_ratio_min" ? Kind::least : Kind::largest),
                                  internal::interaction_series(strategy, device, source.steps, source.run.nominal.slot_s),
                                  metric, rows, internal::straight_steps(strategy, source.nominal, source.steps));
  if (ratio) {
    for (MetricSample& sample : found.samples) sample.amount /= *step_m;
  }
  return found;
}

std::optional<MetricSamples> of_force(const Source& source, std::string_view metric) {
  const StrategyRecord& strategy = source.strategy;
  const DeviceRecord& device = source.device;
  if (metric == "late" || metric == "underruns") return late(source);
  if (metric == "schedule_latency" || metric == "schedule_latency_min") {
    return each_step(source, metric == "schedule_latency" ? Kind::largest : Kind::least, [&](std::size_t n) {
      return std::optional(seconds(strategy.steps[n].emission - strategy.steps[n].read));
    });
  }
  if (metric == "deviation_from_ideal") {
    return each_step(source, Kind::largest, [&](std::size_t n) -> std::optional<double> {
      const std::size_t twin = n * strategy.devices.size() + source.device_index;
      if (twin >= strategy.twin_force_N.size()) return std::nullopt;
      return norm(minus(device.steps[n].force_N, strategy.twin_force_N[twin]));
    });
  }
  if (metric == "error_max") {
    MetricSamples found = of_ticks(source, Kind::largest);
    for (const std::size_t k : source.ticks) {
      const TickRow& tick = device.ticks[k];
      if (tick.undelayed_N) found.samples.push_back(source.tick(k, norm(minus(tick.force_N, *tick.undelayed_N))));
    }
    return found;
  }
  if (metric != "velocity_jump" && metric != "deviation_max" && metric != "jump_max") return std::nullopt;
  Rows<MetricSample> rows(source.steps.get_allocator());
  for (const std::size_t k : source.ticks) rows.push_back(source.tick(k, 0));
  // A jump of the force counts in a turn too.
  const std::vector<internal::Window> pieces =
      metric == "jump_max" ? std::vector<internal::Window>{{0, source.ticks.size()}}
                           : internal::straight_ticks(strategy, device, source.nominal, source.ticks);
  return of_series(of_ticks(source, Kind::largest),
                   internal::force_series(device, source.ticks, source.run.nominal.judged_from), metric, rows, pieces);
}

std::optional<MetricSamples> of_buffers(const Source& source, std::string_view metric) {
  if (metric == "interaction_underruns") return missing(source);
  if (metric == "force_underruns") return late(source);
  if (metric == "overruns") return overruns(source);
  if (metric != "underruns") return std::nullopt;
  return joined(missing(source), late(source));
}

/// The ticks of the strategy that ran live, of each of its devices.
std::optional<MetricSamples> of_live_ticks(const RunRecord& run, std::string_view metric) {
  if (metric != "lateness_max") return std::nullopt;
  MetricSamples found{Kind::largest, "tick", "", {}};
  for (const StrategyRecord& strategy : run.strategies) {
    if (strategy.name != run.live) continue;
    for (const DeviceRecord& device : strategy.devices) {
      for (std::size_t k = 0; k < device.ticks.size(); ++k)
        found.samples.push_back({static_cast<std::int64_t>(k), device.ticks[k].at, seconds(device.ticks[k].lateness)});
    }
  }
  return found;
}

/// Decides which failing sample is named as the worst: the farthest from what it should be; of several that differ only by
/// rounding, the first. NaN is worse than anything.
bool is_worse(const MetricSample& a, const MetricSample& b, bool larger) {
  if (std::isnan(b.amount)) return false;
  const double rounding = 1e-9 * std::abs(b.amount);
  return std::isnan(a.amount) || (larger ? a.amount > b.amount + rounding : a.amount < b.amount - rounding);
}

std::string short_time(double amount_s) {
  const double size = std::abs(amount_s);
  return size < 1e-6   ? fmt::format("{:.3g} ns", amount_s * 1e9)
         : size < 1e-3 ? fmt::format("{:.3g} us", amount_s * 1e6)
         : size < 1    ? fmt::format("{:.3g} ms", amount_s * 1e3)
                       : fmt::format("{:.3g} s", amount_s);
}

std::string text_of(const MetricSamples& samples, const MetricSample& sample, const std::string& unit,
                    double base_per_unit) {
  std::string text = fmt::format("at {} {}, {:.3f} s", samples.of, sample.index, seconds(sample.at));
  if (samples.kind == Kind::count) return std::isnan(sample.amount) ? text : text + ", by " + short_time(sample.amount);
  return text + fmt::format(": {:.6g}{}{}", sample.amount / base_per_unit, unit.empty() ? "" : " ", unit);
}

}  // namespace

void late_by(MetricSamples& late, Duration most) {
  if (most.ns > 0) late.enough = LeadAndLatency{late.now.lead, late.now.latency + most};
}

void missing_by(MetricSamples& missing, Duration most) {
  if (most.ns > 0) missing.enough = LeadAndLatency{missing.now.lead + most, missing.now.latency + most};
}

MetricSamples joined(MetricSamples missing, const MetricSamples& late) {
  if (late.samples.empty()) return missing;
  if (missing.samples.empty()) return late;
  missing.word = "missing its sample or late";
  missing.samples.insert(missing.samples.end(), late.samples.begin(), late.samples.end());
  std::stable_sort(missing.samples.begin(), missing.samples.end(),
                   [](const MetricSample& a, const MetricSample& b) { return a.index < b.index; });
  if (missing.enough && late.enough)
    missing.enough->latency = missing.enough->latency + (late.enough->latency - late.now.latency);
  else
    missing.enough.reset();
  return missing;
}

std::optional<MetricSamples> samples_of(const RunRecord& run, const std::string& signal, const std::string& metric) {
  if (signal == "events.device.tick") return of_live_ticks(run, metric);
  for (const StrategyRecord& strategy : run.strategies) {
    for (std::size_t d = 0; d < strategy.devices.size(); ++d) {
      const DeviceRecord& device = strategy.devices[d];
      const auto is = [&](const char* kind) { return signal == device.name + '.' + kind + '.' + strategy.name; };
      if (is("interaction")) return of_interaction({run, strategy, device, d}, signal, metric);
      if (is("force")) return of_force({run, strategy, device, d}, metric);
      if (is("buffers")) return of_buffers({run, strategy, device, d}, metric);
    }
  }
  return std::nullopt;
}

void locate(ExpectationResult& result, const MetricSamples& samples, double base_per_unit,
            std::optional<double> base_limit) {
  // A maximum that is too small, or a count that is too low, has no place.
  const bool least = samples.kind == Kind::least;
  const std::optional<double>& limit = least ? result.min : result.max;
  if (!limit || !result.value) return;
  if (samples.kind == Kind::count && *result.value <= *limit) return;
  const double base = base_limit.value_or(*limit * base_per_unit);
  const auto breaks = [&](const MetricSample& sample) {
    return samples.kind == Kind::count || !(least ? sample.amount >= base : sample.amount <= base);
  };
  const MetricSample *first = nullptr, *worst = nullptr;
  for (const MetricSample& sample : samples.samples) {
    if (!breaks(sample)) continue;
    if (!first) first = worst = &sample;
    if (is_worse(sample, *worst, !least)) worst = &sample;
  }
  if (!first) return;
  result.first = FailurePlace{first->index, first->at};
  result.worst = FailurePlace{worst->index, worst->at};
  result.where = fmt::format("{} first {}", samples.word[0] ? samples.word : "out of limit",
                             text_of(samples, *first, result.unit, base_per_unit));
  if (worst != first) result.where += "; worst " + text_of(samples, *worst, result.unit, base_per_unit);
  if (!samples.enough) return;
  const auto [lead, latency] = *samples.enough;
  const std::string with_lead = lead == samples.now.lead ? "" : fmt::format("lead {} with ", exact_ms(lead));
  result.where += fmt::format("; {}latency {} would do", with_lead, exact_ms(latency));
}

}  // namespace evenstep
