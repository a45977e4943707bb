#include <fmt/format.h>

#include <charconv>

#include "evenstep/campaigns/fit_report.h"
#include "evenstep/reports/json.h"

namespace evenstep {
namespace {

double read(const std::string& text) {
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// An estimate, rounded: from a finite recording, more than six digits would only look exact.
Json rounded(double value) { return json_number(read(fmt::format("{:.6g}", value))); }
/// A length in ns, to a tenth.
Json tenths(double value) { return read(fmt::format("{:.1f}", value)); }

Json json_of(const LatencyNeed& need) {
  return {{"window_p50_ns", need.window_p50.ns},
          {"window_p99_ns", need.window_p99.ns},
          {"whole_ns", need.whole.ns},
          {"phase_locked_ns", need.phase_locked.ns}};
}

Json json_of(const std::vector<LatencyNeed>& needs) {
  Json out = Json::array();
  for (const LatencyNeed& need : needs) out.push_back(json_of(need));
  return out;
}

Json json_of(const FittedLength& length) {
  return {{"count", length.count},
          {"median_ns", tenths(length.median_ns)},
          {"mean_ns", tenths(length.mean_ns)},
          {"variation", rounded(length.variation)},
          {"kolmogorov_distance", rounded(length.distance)},
          {"half_width", rounded(length.half_width)},
          {"uniform_distance", rounded(length.uniform_distance)},
          {"law", length.is_uniform() ? "uniform" : "lognormal"}};
}

Json json_of(const FittedNumber& number) { return {{"value", rounded(number.value)}, {"error", rounded(number.error)}}; }

void put_segments(Json& out, const TimingFit& fit) {
  out["segment_median_ns"] = tenths(fit.segment_median_ns);
  out["segment_variation"] = rounded(fit.segment_variation);
  out["work_variation"] = rounded(fit.work_variation);
  out["idle_share"] = rounded(fit.idle_share);
  out["late"] = fit.late;
}

void put_visualizations(Json& out, const TimingFit& fit) {
  out["visualization"] = json_of(fit.visualization);
  out["dropped"] = fit.dropped;
  out["merged"] = fit.merged;
  out["lag_1"] = rounded(fit.lag_1);
  if (const auto& hitch = fit.timing.hitch)
    out["hitch"] = {{"count", fit.hitches}, {"every_ns", hitch->every.ns}, {"visualization_ns", hitch->visualization.ns}};
  if (!fit.timing.regimes) return;
  out["regimes"] = {{"factor", rounded(fit.timing.regimes->factor)},
                    {"mean_length", rounded(fit.timing.regimes->mean_length)},
                    {"separation", rounded(fit.regime_separation)},
                    {"slow_share", rounded(fit.slow_share)}};
}

void put_steps(Json& out, const TimingFit& fit) {
  out["steps"] = fit.timing.steps;
  out["least_steps"] = fit.least_steps;
  out["most_steps"] = fit.most_steps;
  out["mean_steps"] = rounded(fit.mean_steps);
  out["step"] = json_of(fit.step);
  out["first_step"] = json_of(fit.first_step);
  out["slowdown"] = json_of(fit.slowdown);
}

void put_hits(Json& out, const TimingFit& fit) {
  out["hits"] = fit.excess_ns.size();
  out["alike"] = fit.alike;
  if (const auto& spikes = fit.timing.spikes)
    out["spikes"] = {{"rate_Hz", rounded(spikes->rate_Hz)}, {"cost_ns", spikes->cost.ns}};
  if (const auto& preemption = fit.timing.preemption) {
    out["preemption"] = {{"rate_Hz", rounded(preemption->rate_Hz)},
                         {"least_ns", preemption->least.ns},
                         {"most_ns", preemption->most.ns},
                         {"tail", rounded(preemption->tail)},
                         {"kolmogorov_distance", rounded(fit.tail_distance)}};
  }
}

const char* name_of(SegmentOrder order) {
  switch (order) {
    case SegmentOrder::visualization_first:
      return "visualization-first";
    case SegmentOrder::steps_first:
      return "steps-first";
    case SegmentOrder::concurrent:
      return "concurrent";
  }
  return "";
}

}  // namespace

std::string fit_json(const TimingFit& fit, const FitComparison& comparison, const std::string& file) {
  Json out = {{"file", file},
              {"segments", fit.segments},
              {"seconds", rounded(fit.seconds)},
              {"order", name_of(fit.timing.order)},
              {"paced", fit.timing.paced},
              {"spread", fit.spread}};
  put_segments(out, fit);
  put_visualizations(out, fit);
  put_steps(out, fit);
  put_hits(out, fit);
  out["drift_per_s"] = rounded(fit.timing.drift_per_s);
  out["visualization_drift_per_s"] = json_of(fit.visualization_drift_per_s);
  out["step_drift_per_s"] = json_of(fit.step_drift_per_s);
  out["latency"] = {{"recording", json_of(comparison.recording)},
                    {"model", json_of(comparison.model)},
                    {"shuffled", json_of(comparison.shuffled)}};
  out["longest_pause"] = evenstep::json_of(comparison.pause);
  out["order_matters"] = !differences(comparison.recording, comparison.shuffled_median).empty();
  out["replay_instead"] =
      !comparison.objection.empty() || !differences(comparison.recording, comparison.model_median).empty();
  if (!comparison.objection.empty()) out["objection"] = comparison.objection;
  return json_text(out) + '\n';
}

}  // namespace evenstep
