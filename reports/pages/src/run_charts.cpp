#include "src/run_charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "src/columns.h"
#include "src/kept_rows.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kMostNumbers = 400'000;
constexpr std::size_t kMostBytes = 650'000;  // of the charts' text, so that a page stays below 1 MB

template <class Value>
std::vector<Value> picked(const std::vector<Value>& values, const std::vector<std::size_t>& rows) {
  std::vector<Value> out;
  out.reserve(rows.size());
  for (const std::size_t row : rows) out.push_back(values[row]);
  return out;
}

/// The axis along which the device moves farthest; if it does not move, the axis of its largest force.
std::size_t main_axis(const RunRecord& run, std::size_t device) {
  std::array<double, 3> moved{}, pushed{};
  for (const StrategyRecord& strategy : run.strategies) {
    if (device >= strategy.devices.size()) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = INFINITY, high = -INFINITY, most = 0;
      for (const TickRow& tick : strategy.devices[device].ticks) {
        low = std::min(low, tick.position_m[axis]);
        high = std::max(high, tick.position_m[axis]);
        most = std::max(most, std::abs(tick.force_N[axis]));
      }
      if (high > low) moved[axis] = std::max(moved[axis], high - low);
      pushed[axis] = std::max(pushed[axis], most);
    }
  }
  const std::array<double, 3>& reach = *std::max_element(moved.begin(), moved.end()) > 0 ? moved : pushed;
  return static_cast<std::size_t>(std::max_element(reach.begin(), reach.end()) - reach.begin());
}

/// From when the force of a step is at the devices until the first of them needs it; below 0: it is late.
Duration time_to_spare(const StepRow& step, const std::vector<DeviceRecord>& devices) {
  if (step.lost) return {};  // no time is its own
  Duration least = step.emission - arrival(step);
  for (const DeviceRecord& device : devices) least = std::min(least, deadline(step, device) - arrival(step));
  return least;
}

/// For each step, how many forces (its own too) wait in the schedule when it ends.
std::vector<std::int64_t> waiting_forces(const StrategyRecord& strategy) {
  std::vector<std::int64_t> counts;
  std::deque<RealTime> due;
  for (const StepRow& step : strategy.steps) {
    due.push_back(step.emission);
    while (!due.empty() && due.front() <= step.end) due.pop_front();
    counts.push_back(step.mapped ? static_cast<std::int64_t>(due.size()) : 0);
  }
  return counts;
}

/// Builds the JSON of one strategy.
class StrategyCharts {
 public:
  StrategyCharts(Columns& columns, const RunRecord& run, const StrategyRecord& strategy, const KeptSegments& kept,
                 const std::vector<std::size_t>& axes)
      : columns_(columns), run_(run), strategy_(strategy), kept_(kept), axes_(axes) {}

  Json json() {
    Json out = {{"name", strategy_.name},
                {"reference", strategy_.reference},
                {"colour", strategy_.look.colour},
                {"width", strategy_.look.width},
                {"dash", strategy_.look.dash},
                {"latency_s", seconds(strategy_.latency.latency)},
                {"lead_s", seconds(strategy_.latency.lead)},
                {"force_capacity", strategy_.latency.force_capacity},
                {"total_steps", strategy_.steps.size()}};
    put_segments(out);
    put_steps(out);
    out["devices"] = Json::array();
    for (std::size_t d = 0; d < strategy_.devices.size(); ++d) out["devices"].push_back(device_json(d));
    return out;
  }

 private:
  void put_segments(Json& out) {
    std::vector<std::int64_t> index, begin, length, vis_begin, vis_length;
    for (const SegmentRow& row : strategy_.segments) {
      if (!kept_.holds(row.index)) continue;
      index.push_back(row.index);
      begin.push_back(since_start(row.begin));
      length.push_back((row.end - row.begin).ns);
      vis_begin.push_back(row.visualization ? ((*row.visualization)[0] - row.begin).ns : 0);
      vis_length.push_back(row.visualization ? ((*row.visualization)[1] - (*row.visualization)[0]).ns : -1);
    }
    out["segments"] = {{"index", columns_.add(index)},
                       {"begin", columns_.add(begin)},
                       {"length", columns_.add(length)},
                       {"vis_begin", columns_.add(vis_begin)},
                       {"vis_length", columns_.add(vis_length)}};
  }

  void put_steps(Json& out) {
    std::vector<bool> whole;
    std::vector<double> value;
    // If the run failed during a step, its row may be there without the samples of all devices.
    std::size_t complete = strategy_.steps.size();
    for (const DeviceRecord& device : strategy_.devices) complete = std::min(complete, device.steps.size());
    for (std::size_t n = 0; n < complete; ++n) {
      whole.push_back(kept_.holds(strategy_.steps[n].segment));
      value.push_back(strategy_.devices.empty() ? 0 : strategy_.devices[0].steps[n].position_m[axes_[0]]);
    }
    steps_ = kept_rows(whole, value);
    const auto put = [&](const char* name, auto of) {
      std::vector<std::int64_t> column;
      for (const std::size_t n : steps_) column.push_back(of(n));
      out["steps"][name] = columns_.add(column);
    };
    const auto& rows = strategy_.steps;
    const std::vector<std::int64_t> waiting = waiting_forces(strategy_);
    put("index", [](std::size_t n) { return static_cast<std::int64_t>(n); });
    put("segment", [&](std::size_t n) { return rows[n].segment; });
    put("begin", [&](std::size_t n) { return since_start(rows[n].begin); });
    put("run", [&](std::size_t n) { return (rows[n].end - rows[n].begin).ns; });
    put("read", [&](std::size_t n) { return (rows[n].read - rows[n].begin).ns; });
    put("emission", [&](std::size_t n) { return (rows[n].emission - rows[n].read).ns; });
    put("spare", [&](std::size_t n) { return time_to_spare(rows[n], strategy_.devices).ns; });
    put("mapped", [&](std::size_t n) { return rows[n].mapped ? 1 : 0; });
    put("judged", [&](std::size_t n) { return rows[n].begin >= run_.nominal.judged_from && !rows[n].acquiring ? 1 : 0; });
    put("waiting", [&](std::size_t n) { return waiting[n]; });
    if (strategy_.variable_step) put("simulated", [&](std::size_t n) { return rows[n].simulated.ns; });
  }

  Json device_json(std::size_t d) {
    const DeviceRecord& device = strategy_.devices[d];
    const std::size_t axis = axes_[d];
    std::vector<double> position, force;
    for (const std::size_t n : steps_) {
      position.push_back(device.steps[n].position_m[axis]);
      force.push_back(device.steps[n].force_N[axis]);
    }
    Json out = {{"name", device.name}, {"position", columns_.add(position)}, {"force", columns_.add(force)}};
    out["ticks"] = ticks_json(device, axis);
    return out;
  }

  Json ticks_json(const DeviceRecord& device, std::size_t axis) {
    std::vector<bool> whole;
    std::vector<double> position, force;
    std::vector<std::int64_t> at, lateness, started;
    for (const TickRow& tick : device.ticks) {
      whole.push_back(kept_.every == 1 || kept_.holds(segment_of(tick.at)));
      position.push_back(tick.position_m[axis]);
      force.push_back(tick.force_N[axis]);
      at.push_back(since_start(tick.at));
      lateness.push_back(tick.lateness.ns);
      started.push_back(tick.started ? 1 : 0);
    }
    segment_hint_ = 0;
    const std::vector<std::size_t> rows = kept_rows(whole, force);
    return {{"at", columns_.add(picked(at, rows))},
            {"lateness", columns_.add(picked(lateness, rows))},
            {"started", columns_.add(picked(started, rows))},
            {"position", columns_.add(picked(position, rows))},
            {"force", columns_.add(picked(force, rows))}};
  }

  /// Ticks come in order, so the search goes on where it stopped.
  std::int64_t segment_of(RealTime at) {
    const auto& rows = strategy_.segments;
    while (segment_hint_ + 1 < rows.size() && rows[segment_hint_ + 1].begin <= at) ++segment_hint_;
    return rows.empty() ? 0 : rows[segment_hint_].index;
  }

  static std::int64_t since_start(RealTime t) { return (t - RealTime{0}).ns; }

  Columns& columns_;
  const RunRecord& run_;
  const StrategyRecord& strategy_;
  const KeptSegments& kept_;
  const std::vector<std::size_t>& axes_;
  std::vector<std::size_t> steps_;
  std::size_t segment_hint_ = 0;
};

Json bins_json(const RunRecord& run) {
  Json out = Json::object();
  for (const auto& [signal, rows] : bins(run)) {
    Json at = Json::array(), deviation = Json::array(), jump = Json::array(), late = Json::array();
    std::map<std::string_view, Json> others;
    for (const BinRow& row : rows) {
      at.push_back(json_number((row.from_s + row.to_s) / 2));
      deviation.push_back(json_number(row.deviation_max));
      jump.push_back(json_number(row.velocity_jump));
      late.push_back(row.underruns_so_far);
      for (const BinnedError& error : kBinnedErrors) {
        if (error.name == "deviation") continue;
        if (const auto rms = error.rms(row)) others[error.name].push_back(json_number(*rms));
      }
    }
    Json errors = {{"deviation max", deviation}, {"velocity jump", jump}};
    for (const auto& [name, values] : others) {
      if (values.size() == rows.size()) errors[std::string(name) + " RMS"] = values;
    }
    out[signal] = {{"t", at}, {"errors", errors}, {"underruns", late}};
  }
  return out;
}

Json marks_json(std::span<const ExpectationResult> results) {
  Json marks = Json::array();
  for (const ExpectationResult& result : results) {
    const auto add = [&](const FailurePlace& place, const char* word) {
      marks.push_back({{"signal", result.signal},
                       {"metric", result.metric},
                       {"word", word},
                       {"index", place.index},
                       {"at_s", seconds(place.at)}});
    };
    if (!result.first || !result.worst) continue;
    add(*result.worst, result.first->at == result.worst->at ? "failure" : "worst failure");
    if (result.first->at != result.worst->at) add(*result.first, "first failure");
  }
  return marks;
}

/// Limits of metrics that are distances from a line or jumps, in the metric's base unit.
Json limits_json(const RunRecord& run, std::span<const ExpectationResult> results) {
  Json limits = Json::array();
  for (const ExpectationResult& result : results) {
    const std::optional<double> step = step_unit(run.nominal, result.signal);
    const bool drawn = result.metric == "deviation_max" || result.metric == "velocity_jump";
    if (!drawn || result.unit != "step" || !step) continue;
    for (const auto& [limit, word] : {std::pair(result.max, "at most"), std::pair(result.min, "at least")}) {
      if (limit && *limit > 0)
        limits.push_back({{"signal", result.signal}, {"metric", result.metric}, {"word", word}, {"steps", *limit}});
    }
  }
  return limits;
}

Json charts_with(const RunRecord& run, std::span<const ExpectationResult> results, std::int64_t most_numbers) {
  const KeptSegments kept = kept_segments(run, results, most_numbers);
  const Nominal& nominal = run.nominal;
  Columns columns;
  std::vector<std::size_t> axes;
  Json devices = Json::array();
  for (std::size_t d = 0; d < nominal.devices.size(); ++d) {
    const std::string& name = nominal.devices[d].name;
    axes.push_back(main_axis(run, d));
    devices.push_back({{"name", name},
                       {"axis", std::string(1, "xyz"[axes.back()])},
                       {"step_m", json_number(step_unit(nominal, name + ".interaction.any"))},
                       {"step_N", json_number(step_unit(nominal, name + ".force.any"))}});
  }
  Json out = {{"kind", "run"},
              {"live", run.live},
              {"clock", run.clock},
              {"slot_s", nominal.slot_s},
              {"segment_s", seconds(nominal.segment)},
              {"judged_from_s", seconds(nominal.judged_from)},
              {"end_s", seconds(nominal.end)},
              {"every", kept.every},
              {"devices", devices},
              {"strategies", Json::array()},
              {"bins", bins_json(run)},
              {"marks", marks_json(results)},
              {"limits", limits_json(run, results)}};
  for (const StrategyRecord& strategy : run.strategies)
    out["strategies"].push_back(StrategyCharts(columns, run, strategy, kept, axes).json());
  out["columns"] = columns.json();
  return out;
}

}  // namespace

Json run_charts(const RunRecord& run, std::span<const ExpectationResult> results) {
  if (run.strategies.empty() || run.nominal.devices.empty()) return nullptr;
  std::int64_t most_numbers = kMostNumbers;
  Json charts = charts_with(run, results, most_numbers);
  // Numbers without any pattern take more room than others.
  constexpr std::int64_t kFewest = 20'000;
  while (most_numbers > kFewest && charts["columns"]["bytes"].get_ref<const std::string&>().size() > kMostBytes) {
    most_numbers /= 2;
    charts = charts_with(run, results, most_numbers);
  }
  return charts;
}

}  // namespace evenstep::internal
