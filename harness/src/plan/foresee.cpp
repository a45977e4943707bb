#include "evenstep/harness/foresee.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/harness/run.h"
#include "evenstep/reports/places.h"
#include "evenstep/reports/recovery.h"
#include "src/judge.h"
#include "strategies.h"

namespace evenstep {
namespace {

double nearest_s(Duration d) { return static_cast<double>(d.ns) / 1e9; }

/// The judged steps that one device misses something of, and by how much at most.
struct BadSteps {
  MetricSamples samples;
  Duration most;

  BadSteps(const StrategyPlan& plan, const char* word)
      : samples{MetricSamples::Kind::count, "step", word, {}, {plan.lead, plan.latency}} {}
  /// If the latency adapts, it is not said by how much.
  void add(const StrategyPlan& plan, const MappedStep& step, Duration by) {
    if (by.ns <= 0) return;
    most = std::max(most, by);
    samples.samples.push_back({step.step, step.begin, plan.adapts ? NAN : nearest_s(by)});
  }
};
struct DeviceMisses {
  BadSteps late, missing;
};

/// For each device; empty if no step is judged.
std::vector<DeviceMisses> misses_of(const Scenario& scenario, const StrategyPlan& plan) {
  std::vector<RunningUnderruns> underruns = internal::underruns_of(scenario, map_setup(scenario), plan);
  std::vector<DeviceMisses> devices(underruns.size(), {{plan, "late"}, {plan, "missing its sample"}});
  bool judged = false;
  each_run_step(scenario, plan, [&](std::span<const MappedStep> steps) {
    for (const MappedStep& step : steps) {
      const bool counts = step.begin >= RealTime{scenario.warmup.ns};
      judged = judged || counts;
      for (std::size_t d = 0; d < devices.size(); ++d) {
        const RunningUnderruns::Step found = underruns[d].next(step);
        if (!counts) continue;
        devices[d].late.add(plan, step, found.late_by);
        devices[d].missing.add(plan, step, found.missing_by);
      }
    }
  });
  if (!judged) return {};
  for (auto& [late, missing] : devices) {
    if (plan.adapts) break;
    late_by(late.samples, late.most);
    missing_by(missing.samples, missing.most);
  }
  return devices;
}

/// What the sizing pass knows of one strategy: values of metrics, and where in the run those that are counted occur.
struct Foreseen {
  Metrics metrics;
  std::map<std::string, std::map<std::string, MetricSamples>> samples;

  void add(const std::string& signal, const std::string& metric, const MetricSamples& counted) {
    metrics[signal][metric] = static_cast<double>(counted.samples.size());
    samples[signal].emplace(metric, counted);
  }
};

void add_counts(const Scenario& scenario, const StrategyPlan& plan, Foreseen& foreseen) {
  const bool gated = scenario.remap.interaction_underrun == InteractionUnderrun::gate;
  const std::vector<DeviceMisses> misses = misses_of(scenario, plan);
  for (std::size_t d = 0; d < misses.size(); ++d) {
    const std::string device = scenario.devices[d].name, strategy = name_of(plan.kind);
    const MetricSamples& late = misses[d].late.samples;
    for (const char* metric : {"late", "underruns"}) foreseen.add(device + ".force." + strategy, metric, late);
    const std::string buffers = device + ".buffers." + strategy;
    foreseen.add(buffers, "force_underruns", late);
    // With ages, or where an event comes only for a change, it is not known beforehand which samples are missing.
    if (gated || scenario.devices[d].age.is_given() || unchanged_age_of(scenario.devices[d])) continue;
    const MetricSamples& missing = misses[d].missing.samples;
    foreseen.add(device + ".interaction." + strategy, "underruns", missing);
    foreseen.add(buffers, "interaction_underruns", missing);
    foreseen.add(buffers, "underruns", joined(missing, late));
  }
}

void add_sizes(const Scenario& scenario, const StrategyPlan& plan, Foreseen& foreseen) {
  for (std::size_t d = 0; d < plan.predicted.size(); ++d) {
    const std::string signal = scenario.devices[d].name + ".buffers." + name_of(plan.kind);
    std::map<std::string, double>& buffers = foreseen.metrics[signal];
    buffers["interaction_capacity"] = static_cast<double>(plan.interaction_capacity);
    buffers["force_capacity"] = static_cast<double>(plan.force_capacity);
    buffers["predicted_interaction_underruns"] = static_cast<double>(plan.predicted[d].interaction_underruns);
    buffers["predicted_late_forces"] = static_cast<double>(plan.predicted[d].late_forces);
    buffers["lead"] = nearest_s(plan.lead);
    buffers["latency"] = nearest_s(plan.latency);
    buffers["latency_any_phase"] = nearest_s(plan.sizing.any_phase.latency);
    buffers["latency_this_phase"] = nearest_s(plan.sizing.this_phase.latency);
  }
}

}  // namespace

std::vector<ExpectationResult> foresee_failures(const Scenario& scenario, const std::vector<StrategyPlan>& plans) {
  std::vector<ExpectationResult> failures;
  if (scenario.expect_stop || scenario.case_spec) return failures;
  Foreseen foreseen;
  for (const StrategyPlan& plan : plans) {
    if (!is_remap(plan.kind)) continue;
    add_sizes(scenario, plan, foreseen);
    add_counts(scenario, plan, foreseen);
  }
  for (const Expectation& expectation : scenario.expectations) {
    // Whether a known fault under a pattern is still there depends on all that the pattern matches, also on what is not
    // foreseen.
    const bool pattern = expectation.signal.find('*') != std::string::npos;
    if (expectation.clock == "wall" || expectation.confidence || (pattern && expectation.expect_fail)) continue;
    ExpectationResult result = internal::judge_by(expectation, scenario, nominal_of(scenario), foreseen.metrics);
    if (result.verdict != ExpectationResult::Verdict::fail) continue;
    const auto of_signal = foreseen.samples.find(result.signal);
    if (of_signal != foreseen.samples.end() && !result.expect_fail) {
      const auto found = of_signal->second.find(result.metric);
      if (found != of_signal->second.end()) locate(result, found->second, 1);
    }
    failures.push_back(std::move(result));
  }
  return failures;
}

std::optional<RealTime> ForetoldSchedule::last_end() const {
  std::optional<RealTime> last;
  for (const ForetoldFault& fault : faults) {
    if (!fault.to) return std::nullopt;
    last = last ? std::max(*last, *fault.to) : *fault.to;
  }
  return last;
}

ForetoldSchedule foretell_schedule(const Scenario& scenario) {
  ForetoldSchedule foretold;
  const RealTime from{scenario.warmup.ns}, end{scenario.run_duration.ns};
  foretold.pace.step_s = period_s(scenario.scene.step_rate);
  LongestPause pauses;
  Rows<SegmentRow> rows;
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  for (SegmentTiming segment; timing->next(segment) && segment.begin < end;) {
    if (!scenario.faults.empty()) {  // who needs the rows; a run may be long
      SegmentRow& row = rows.emplace_back();
      row.begin = segment.begin;
      row.end = segment.end;
    }
    pauses.add_segment({segment.begin, segment.end}, segment.visualization, segment.steps, segment.overlaps());
    foretold.pace.add_segment({segment.begin, segment.end}, segment.steps);
    foretold.drawings.left_out += segment.drawing.left_out && segment.begin >= from;
    if (!segment.visualization || !segment.drawing.finishes) continue;
    const RealTime drawn = segment.visualization->end;
    foretold.drawings.finished += drawn > from && drawn < end;
  }
  foretold.longest_pause = pauses.parts();
  for (const ProgrammedFault& fault : scenario.faults) {
    if (fault.from >= end) continue;
    std::optional<RealTime> to = fault_end(fault, rows);
    if (to && *to > end) to.reset();
    foretold.faults.push_back({fault.name, fault.from, to, fault.over == ProgrammedFault::Over::never});
  }
  return foretold;
}

}  // namespace evenstep
