#include <fmt/format.h>

#include "evenstep/reports/json.h"
#include "evenstep/reports/saturation.h"
#include "evenstep/reports/writers.h"
#include "summary_schema.h"

namespace evenstep {
namespace {

const char* verdict_name(ExpectationResult::Verdict verdict) {
  switch (verdict) {
    case ExpectationResult::Verdict::skipped:
      return "skipped";
    case ExpectationResult::Verdict::degraded:
      return "degraded";
    case ExpectationResult::Verdict::pass:
      return "pass";
    case ExpectationResult::Verdict::fail:
      return "fail";
    case ExpectationResult::Verdict::error:
      return "error";
  }
  return "error";
}

Json word_or_null(const std::string& word) { return word.empty() ? Json() : Json(word); }

Json json_of(const std::optional<FailurePlace>& place) {
  if (!place) return nullptr;
  return {{"index", place->index}, {"time_ns", (place->at - RealTime{0}).ns}};
}

Json json_of(const ExpectationResult& result) {
  return {{"line", result.line},
          {"signal", result.signal},
          {"metric", result.metric},
          {"value", json_number(result.value)},
          {"unit", result.unit},
          {"min", json_number(result.min)},
          {"max", json_number(result.max)},
          {"verdict", verdict_name(result.verdict)},
          {"file", result.file},
          {"expect_fail", result.expect_fail},
          {"because", result.because},
          {"detail", result.detail},
          {"where", result.where},
          {"first", json_of(result.first)},
          {"worst", json_of(result.worst)},
          {"pattern", result.pattern}};
}

Json json_of(const std::map<std::string, double>& values) {
  Json out = Json::object();
  for (const auto& [metric, value] : values) out[metric] = json_number(value);
  return out;
}

/// What was predicted is that of the worst device.
Json latency_json(const StrategyRecord& strategy) {
  const LatencyRecord& latency = strategy.latency;
  std::int64_t missing = 0, late = 0;
  for (const DeviceRecord& device : strategy.devices) {
    missing = std::max(missing, device.predicted_interaction_underruns);
    late = std::max(late, device.predicted_late_forces);
  }
  return {{"lead_ns", latency.lead.ns},
          {"latency_ns", latency.latency.ns},
          {"lead_any_phase_ns", latency.least_any_phase_lead.ns},
          {"latency_any_phase_ns", latency.least_any_phase.ns},
          {"lead_this_phase_ns", latency.least_this_phase_lead.ns},
          {"latency_this_phase_ns", latency.least_this_phase.ns},
          {"lead_culprit", latency.lead_culprit},
          {"latency_culprit", latency.latency_culprit},
          {"interaction_capacity", latency.interaction_capacity},
          {"force_capacity", latency.force_capacity},
          {"predicted_interaction_underruns", missing},
          {"predicted_late_forces", late}};
}

Json json_of(const StrategyRecord& strategy) {
  Json out = {{"trace_hash", fmt::format("{:016x}", strategy.trace_hash)},
              {"shadow", strategy.shadow},
              {"solver", strategy.solver.name},
              {"solver_device", strategy.solver.device},
              {"method", strategy.solver.method}};
  if (strategy.solver.iterations > 0) out["iterations"] = strategy.solver.iterations;
  if (!strategy.solver.lacks.empty()) out["solver_lacks"] = strategy.solver.lacks;
  out["steps"] = strategy.steps.size();
  out["segments"] = strategy.segments.size();
  return out;
}

Json json_of(const Saturation& saturation) {
  Json causes = Json::array();
  for (const Saturation::Part& part : saturation.parts)
    causes.push_back({{"cause", name_of(part.cause)}, {"first_ns", part.first.ns}, {"count", part.count}});
  return {{"judged", saturation.judged},
          {"count", saturation.saturated},
          {"share", json_number(saturation.share())},
          {"causes", causes}};
}

Json json_of(const std::vector<BinRow>& rows) {
  Json out = Json::array();
  for (const BinRow& bin : rows) {
    Json row = {{"from_s", json_number(bin.from_s)},
                {"to_s", json_number(bin.to_s)},
                {"deviation_max", json_number(bin.deviation_max)},
                {"velocity_jump", json_number(bin.velocity_jump)}};
    for (const BinnedError& error : kBinnedErrors) {
      if (const auto rms = error.rms(bin)) row[std::string(error.name) + "_rms"] = json_number(*rms);
    }
    row["underruns_so_far"] = bin.underruns_so_far;
    out.push_back(std::move(row));
  }
  return out;
}

Json json_of(const std::vector<std::pair<std::string_view, GrowthInterval>>& growths) {
  Json out = Json::object();
  for (const auto& [error, interval] : growths)
    out[error] = {{"name", growth_name(interval)}, {"exponent", {json_number(interval.low), json_number(interval.high)}}};
  return out;
}

Json json_of(const LiveRights& rights) {
  Json threads = Json::array();
  for (const auto& [name, priority, fifo, timer_slack_ns, slice_ns, refusal] : rights.threads) {
    threads.push_back({{"name", name},
                       {"priority", priority},
                       {"fifo", fifo},
                       {"timer_slack_ns", timer_slack_ns},
                       {"slice_ns", slice_ns},
                       {"refusal", refusal}});
  }
  Json out{{"threads", threads}, {"memory_locked", rights.memory_locked}, {"memory_refusal", rights.memory_refusal}};
  if (rights.cores_awake) {
    out["cores_awake"] = *rights.cores_awake;
    out["cores_refusal"] = rights.cores_refusal;
  }
  return out;
}

}  // namespace

std::string summary_schema() { return internal::kSummarySchema; }

std::string summary_json(const RunRecord& run, const Metrics& metrics, const std::vector<ExpectationResult>& results,
                         const std::string& version, const std::string& verdict, const std::string& failure) {
  Json out = {{"format", 1},
              {"evenstep", version},
              {"scenario", run.scenario},
              {"file", run.file},
              {"scenario_digest", run.digest ? Json(fmt::format("{:016x}", *run.digest)) : Json()},
              {"date", word_or_null(run.origin.date)},
              {"commit", word_or_null(run.origin.commit)},
              {"seed", run.seed},
              {"clock", run.clock},
              {"real_time_granted", run.real_time_granted},
              {"verdict", verdict},
              {"trace_hash", fmt::format("{:016x}", run.trace_hash)},
              {"expectations", Json::array()},
              {"metrics", Json::object()},
              {"saturated", Json::object()},
              {"latency", Json::object()},
              {"strategies", Json::object()},
              {"growth", Json::object()},
              {"bins", Json::object()},
              {"left_out", run.left_out},
              {"failure", failure}};
  if (run.rights) out["rights"] = json_of(*run.rights);
  for (const ExpectationResult& result : results) out["expectations"].push_back(json_of(result));
  for (const auto& [signal, values] : metrics) out["metrics"][signal] = json_of(values);
  for (const auto& [signal, saturation] : saturations(run)) out["saturated"][signal] = json_of(saturation);
  for (const StrategyRecord& strategy : run.strategies) {
    out["latency"][strategy.name] = latency_json(strategy);
    out["strategies"][strategy.name] = json_of(strategy);
  }
  for (const auto& [signal, rows] : bins(run)) {
    if (const auto growths = growths_of(metrics, signal); !growths.empty()) out["growth"][signal] = json_of(growths);
    out["bins"][signal] = json_of(rows);
  }
  return json_text(out, "expectations") + '\n';
}

}  // namespace evenstep
