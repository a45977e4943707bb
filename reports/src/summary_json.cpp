#include <fmt/format.h>

#include "evenstep/reports/writers.h"
#include "src/json_members.h"

namespace evenstep {
namespace {

using internal::json_string;
using internal::Members;

const char* verdict_name(ExpectationResult::Verdict verdict) {
  switch (verdict) {
    case ExpectationResult::Verdict::pass:
      return "pass";
    case ExpectationResult::Verdict::fail:
      return "fail";
    case ExpectationResult::Verdict::error:
      return "error";
  }
  return "error";
}

void put_expectations(std::string& out, const std::vector<ExpectationResult>& results) {
  Members rows(out += '[');
  for (const ExpectationResult& result : results) {
    Members row(rows.next() += "\n{");
    row.whole("line", result.line);
    row.text("signal", result.signal);
    row.text("metric", result.metric);
    row.number("value", result.value);
    row.text("unit", result.unit);
    row.number("min", result.min);
    row.number("max", result.max);
    row.text("verdict", verdict_name(result.verdict));
    row.text("file", result.file);
    row.flag("expect_fail", result.expect_fail);
    row.text("because", result.because);
    row.text("detail", result.detail);
    out += '}';
  }
  out += ']';
}

void put_metrics(std::string& out, const Metrics& metrics) {
  Members signals(out += '{');
  for (const auto& [signal, values] : metrics) {
    Members row(signals.key(signal) += '{');
    for (const auto& [metric, value] : values) row.number(metric, value);
    out += '}';
  }
  out += '}';
}

void put_latency(std::string& out, const std::vector<StrategyRecord>& strategies) {
  Members rows(out += '{');
  for (const StrategyRecord& strategy : strategies) {
    const LatencyRecord& latency = strategy.latency;
    Members row(rows.key(strategy.name) += '{');
    row.whole("lead_ns", latency.lead.ns);
    row.whole("latency_ns", latency.latency.ns);
    row.whole("lead_any_phase_ns", latency.least_any_phase_lead.ns);
    row.whole("latency_any_phase_ns", latency.least_any_phase.ns);
    row.whole("lead_this_phase_ns", latency.least_this_phase_lead.ns);
    row.whole("latency_this_phase_ns", latency.least_this_phase.ns);
    row.whole("lead_culprit", latency.lead_culprit);
    row.whole("latency_culprit", latency.latency_culprit);
    row.whole("interaction_capacity", latency.interaction_capacity);
    row.whole("force_capacity", latency.force_capacity);
    row.whole("predicted_interaction_underruns", latency.predicted_interaction_underruns);
    row.whole("predicted_late_forces", latency.predicted_late_forces);
    out += '}';
  }
  out += '}';
}

void put_strategies(std::string& out, const std::vector<StrategyRecord>& strategies) {
  Members rows(out += '{');
  for (const StrategyRecord& strategy : strategies) {
    Members row(rows.key(strategy.name) += '{');
    row.text("trace_hash", fmt::format("{:016x}", strategy.trace_hash));
    row.flag("shadow", strategy.shadow);
    row.text("solver", strategy.solver.name);
    row.text("solver_device", strategy.solver.device);
    row.text("method", strategy.solver.method);
    if (strategy.solver.iterations > 0) row.whole("iterations", strategy.solver.iterations);
    row.whole("steps", static_cast<std::int64_t>(strategy.steps.size()));
    row.whole("segments", static_cast<std::int64_t>(strategy.segments.size()));
    out += '}';
  }
  out += '}';
}

void put_bins(std::string& out, const std::map<std::string, std::vector<BinRow>>& bins) {
  Members signals(out += '{');
  for (const auto& [signal, rows] : bins) {
    Members list(signals.key(signal) += '[');
    for (const BinRow& bin : rows) {
      Members row(list.next() += '{');
      row.number("from_s", bin.from_s);
      row.number("deviation_max", bin.deviation_max);
      row.number("velocity_jump", bin.velocity_jump);
      row.whole("underruns_so_far", bin.underruns_so_far);
      out += '}';
    }
    out += ']';
  }
  out += '}';
}

}  // namespace

std::string summary_json(const RunRecord& run, const Metrics& metrics, const std::vector<ExpectationResult>& results,
                         const std::string& version, const std::string& verdict) {
  std::string out;
  Members top(out += '{');
  top.whole("format", 1);
  top.text("evenstep", version);
  top.text("scenario", run.scenario);
  top.key("seed") += fmt::format("{}", run.seed);
  top.text("clock", run.clock);
  top.flag("real_time_granted", run.real_time_granted);
  top.text("verdict", verdict);
  top.text("trace_hash", fmt::format("{:016x}", run.trace_hash));
  put_expectations(top.key("expectations"), results);
  put_metrics(top.key("metrics"), metrics);
  put_latency(top.key("latency"), run.strategies);
  put_strategies(top.key("strategies"), run.strategies);
  put_bins(top.key("bins"), bins(run));
  Members left_out(top.key("left_out") += '[');
  for (const std::string& text : run.left_out) left_out.next() += json_string(text);
  return out + "]}\n";
}

}  // namespace evenstep
