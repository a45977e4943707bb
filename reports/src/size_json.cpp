#include "evenstep/reports/size_record.h"
#include "src/json_members.h"

namespace evenstep {
namespace {

using internal::Members;

void put_windows(std::string& out, const SizeWindows& windows) {
  Members row(out += '{');
  row.whole("p50", windows.p50.ns);
  row.whole("p99", windows.p99.ns);
  row.whole("max", windows.most.ns);
  row.whole("count", windows.count);
  out += '}';
}

void put_need(Members& row, const SizeNeed& need) {
  put_windows(row.key("window_latency_ns"), need.windows);
  const SizeCulprit& culprit = need.culprit;
  row.whole("culprit_step", culprit.step);
  row.whole("culprit_segment", culprit.segment);
  row.whole("culprit_index", culprit.index);
  row.whole("culprit_begin_ns", culprit.begin.ns);
  row.whole("late_step", culprit.late_step);
  row.whole("late_pause_excess_ns", culprit.pause_excess.ns);
  row.whole("late_run_excess_ns", culprit.run_excess.ns);
  row.whole("mended_latency_ns", culprit.mended_latency.ns);
  row.whole("mending_saves_ns", (need.latency - culprit.mended_latency).ns);
  row.whole("total_delay_ns", need.total_delay.ns);
  row.number("stiffness_limit_N_per_m", need.stiffness_limit_N_per_m);
}

void put_bound(std::string& out, const SizeNeed& need) {
  Members row(out += '{');
  row.whole("latency_ns", need.latency.ns);
  put_need(row, need);
  out += '}';
}

void put_bounds(Members& top, const SizeBounds& bounds, const std::string& suffix) {
  top.whole("best_line_latency" + suffix + "_ns", bounds.best_line.latency.ns);
  top.whole("taut_string_latency" + suffix + "_ns", bounds.taut_string.latency.ns);
  put_windows(top.key("window_latency" + suffix + "_ns"), bounds.best_line.windows);
  put_bound(top.key("best_line" + suffix), bounds.best_line);
  put_bound(top.key("taut_string" + suffix), bounds.taut_string);
}

void put_rate_need(std::string& out, const SizeRateNeed& need) {
  Members row(out += '{');
  row.whole("latency_ns", need.latency.ns);
  row.whole("lead_ns", need.lead.ns);
  row.whole("underrun_segments", need.underruns);
  row.number("rate_at_most", need.rate_at_most);
  out += '}';
}

void put_rate(std::string& out, const SizeRate& rate) {
  Members row(out += '{');
  row.whole("segments", rate.segments);
  row.whole("allowed_segments", rate.allowed);
  put_rate_need(row.key("any_phase"), rate.any_phase);
  put_rate_need(row.key("this_phase"), rate.this_phase);
  row.flag("long_enough", rate.sure.has_value());
  if (rate.sure) put_rate_need(row.key("sure"), *rate.sure);
  out += '}';
}

void put_strategy(std::string& out, const SizeStrategy& strategy) {
  Members row(out += '{');
  row.whole("latency_any_phase_ns", strategy.any_phase.latency.ns);
  row.whole("latency_this_phase_ns", strategy.latency_this_phase.ns);
  row.whole("lead_ns", strategy.lead.ns);
  row.whole("lead_this_phase_ns", strategy.lead_this_phase.ns);
  row.whole("lead_culprit_step", strategy.lead_culprit);
  row.whole("interaction_capacity", strategy.interaction_capacity);
  row.whole("force_capacity", strategy.force_capacity);
  put_need(row, strategy.any_phase);
  if (strategy.rate) put_rate(row.key("rate"), *strategy.rate);
  out += '}';
}

void put_cycle(std::string& out, const SizeCycle& cycle) {
  Members row(out += '{');
  row.flag("found", cycle.found);
  if (!cycle.found) {
    row.text("reason", cycle.reason);
    row.number("regularity", cycle.regularity);
    out += '}';
    return;
  }
  row.whole("period_ns", cycle.period.ns);
  row.number("period_variation", cycle.period_variation);
  row.whole("steps_per_segment", cycle.steps_per_segment);
  row.whole("least_steps", cycle.least_steps);
  row.whole("most_steps", cycle.most_steps);
  row.whole("pause_ns", cycle.pause.ns);
  row.whole("longest_gap_ns", cycle.longest_gap.ns);
  row.whole("first_boundary_step", cycle.first_boundary);
  row.whole("segments", cycle.segments);
  row.number("confidence", cycle.confidence);
  row.number("regularity", cycle.regularity);
  out += '}';
}

}  // namespace

std::string size_json(const SizeRecord& record) {
  std::string out;
  Members top(out += '{');
  top.whole("format", 1);
  top.text("input", record.input);
  top.whole("steps", record.steps);
  top.whole("left_out_steps", record.left_out);
  top.whole("segments", record.segments);
  top.text("segments_from", record.segments_from);
  top.whole("length_ns", record.length.ns);
  top.whole("sampling_period_ns", record.sampling_period.ns);
  top.text("emission", record.interpolated ? "linear" : "hold");
  top.number("damping_N_s_per_m", record.damping_N_s_per_m);
  if (record.rate) {
    top.number("rate", *record.rate);
    top.number("confidence", record.confidence);
    top.whole("clean_segments_needed", record.clean_segments);
  }
  put_bounds(top, record.held, "");
  if (record.linear) put_bounds(top, *record.linear, "_linear");
  Members strategies(top.key("strategies") += '{');
  for (const SizeStrategy& strategy : record.strategies) put_strategy(strategies.key(strategy.name), strategy);
  out += '}';
  if (record.cycle) put_cycle(top.key("cycle"), *record.cycle);
  return out + "}\n";
}

}  // namespace evenstep
