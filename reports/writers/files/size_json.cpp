#include "evenstep/reports/json.h"
#include "evenstep/reports/size_record.h"

namespace evenstep {
namespace {

Json json_of(const SizeWindows& windows) {
  return {{"p50", windows.p50.ns}, {"p99", windows.p99.ns}, {"max", windows.most.ns}, {"count", windows.count}};
}

void put_need(Json& out, const SizeNeed& need) {
  const SizeCulprit& culprit = need.culprit;
  out["window_latency_ns"] = json_of(need.windows);
  out["culprit_step"] = culprit.step;
  out["culprit_segment"] = culprit.segment;
  out["culprit_index"] = culprit.index;
  out["culprit_begin_ns"] = culprit.begin.ns;
  out["late_step"] = culprit.late_step;
  out["late_pause_excess_ns"] = culprit.pause_excess.ns;
  out["late_run_excess_ns"] = culprit.run_excess.ns;
  out["mended_latency_ns"] = culprit.mended_latency.ns;
  out["mending_saves_ns"] = (need.latency - culprit.mended_latency).ns;
  out["total_delay_ns"] = need.total_delay.ns;
  out["stiffness_limit_N_per_m"] = json_number(need.stiffness_limit_N_per_m);
}

Json json_of(const SizeNeed& need) {
  Json out = {{"latency_ns", need.latency.ns}};
  put_need(out, need);
  return out;
}

Json json_of(const SizePath& path) { return {{"velocity_jump", json_number(path.jump)}, {"latency_ns", path.latency.ns}}; }

void put_bounds(Json& top, const SizeBounds& bounds, const std::string& suffix) {
  top["best_line_latency" + suffix + "_ns"] = bounds.best_line.latency.ns;
  top["taut_string_latency" + suffix + "_ns"] = bounds.taut_string.latency.ns;
  top["window_latency" + suffix + "_ns"] = json_of(bounds.best_line.windows);
  top["pause_bound" + suffix + "_ns"] = bounds.pause.ns;
  Json paths = Json::array();
  for (const SizePath& path : bounds.paths) paths.push_back(json_of(path));
  top["any_path" + suffix] = paths;
  top["best_line" + suffix] = json_of(bounds.best_line);
  top["taut_string" + suffix] = json_of(bounds.taut_string);
}

Json json_of(const SizeRateNeed& need) {
  return {{"latency_ns", need.latency.ns},
          {"lead_ns", need.lead.ns},
          {"underrun_segments", need.underruns},
          {"rate_at_most", need.rate_at_most ? json_number(*need.rate_at_most) : Json()}};
}

Json json_of(const SizeRate& rate) {
  Json out = {{"segments", rate.segments},
              {"allowed_segments", rate.allowed},
              {"any_phase", json_of(rate.any_phase)},
              {"this_phase", json_of(rate.this_phase)},
              {"segments_needed", rate.segments_needed},
              {"sure", nullptr}};
  if (rate.sure) out["sure"] = json_of(*rate.sure);
  return out;
}

Json json_of(const SizeUnseen& unseen) {
  return {{"sized_segments", unseen.sized},  {"played_segments", unseen.played},
          {"from_ns", unseen.from.ns},       {"latency_ns", unseen.latency.ns},
          {"lead_ns", unseen.lead.ns},       {"late_segments", unseen.late},
          {"late_by_ns", unseen.late_by.ns}, {"missing_by_ns", unseen.missing_by.ns}};
}

Json json_of(const SizePer& per) {
  Json out = {{"rate", json_number(per.rate)}};
  if (!per.refused.empty()) {
    out["refused"] = per.refused;
    out["to_record_ns"] = per.to_record.ns;
    return out;
  }
  out["latency_ns"] = per.latency.ns;
  out["lead_ns"] = per.lead.ns;
  out["likely_latency_ns"] = per.likely_latency.ns;
  if (per.beyond)
    out["tail"] = {{"exceedances", per.exceedances},
                   {"shape", json_number(per.shape)},
                   {"shape_at_most", json_number(per.shape_at_most)}};
  return out;
}

Json json_of(const SizeTrust& trust) {
  Json out = {{"segments", trust.segments},
              {"alike", json_number(trust.alike)},
              {"effective_segments", trust.effective()},
              {"block_segments", trust.block},
              {"one_process", trust.tested ? Json(!trust.change) : Json()}};
  if (trust.change) {
    out["change_segment"] = trust.change->segment;
    out["change_ns"] = trust.change->from.ns;
  }
  return out;
}

Json json_of(const SizeStrategy& strategy) {
  Json out = {{"latency_any_phase_ns", strategy.any_phase.latency.ns},
              {"latency_this_phase_ns", strategy.latency_this_phase.ns},
              {"lead_ns", strategy.lead.ns},
              {"lead_this_phase_ns", strategy.lead_this_phase.ns},
              {"lead_culprit_step", strategy.lead_culprit},
              {"interaction_capacity", strategy.interaction_capacity},
              {"force_capacity", strategy.force_capacity}};
  out["velocity_jump"] = strategy.jump_seen ? json_number(strategy.velocity_jump) : Json(nullptr);
  if (strategy.path) out["any_path_at_this_jump_ns"] = strategy.path->latency.ns;
  if (strategy.pauses_bound) out["pauses_bound_at_this_jump_ns"] = strategy.pauses_bound->ns;
  put_need(out, strategy.any_phase);
  out["unseen"] = Json::array();
  for (const SizeUnseen& one : strategy.unseen) out["unseen"].push_back(json_of(one));
  out["trust"] = json_of(strategy.trust);
  if (strategy.per) out["per"] = json_of(*strategy.per);
  if (strategy.rate) out["rate"] = json_of(*strategy.rate);
  return out;
}

Json json_of(const SizeHitches& kind, const SizeRecord& record) {
  Json out = {{"what", name_of(kind.what)},
              {"count", kind.count},
              {"shortest_ns", kind.shortest.ns},
              {"longest_ns", kind.longest.ns},
              {"usual_ns", kind.usual.ns},
              {"first_begin_ns", kind.first.ns},
              {"least_between_ns", kind.least_between.ns},
              {"median_between_ns", kind.median_between.ns},
              {"most_between_ns", kind.most_between.ns},
              {"mended", Json::object()}};
  for (std::size_t i = 0; i < kind.mended.size(); ++i) {
    const SizeHitches::Mended& mended = kind.mended[i];
    out["mended"][record.strategies[i].name] = {{"latency_ns", mended.latency.ns},
                                                {"with_all_above_ns", mended.with_all_above.ns},
                                                {"stiffness_N_per_m", json_number(mended.stiffness_N_per_m)}};
  }
  return out;
}

Json json_of(const SizeCycle& cycle) {
  if (!cycle.found) return {{"found", false}, {"reason", cycle.reason}, {"regularity", json_number(cycle.regularity)}};
  return {{"found", true},
          {"period_ns", cycle.period.ns},
          {"period_variation", json_number(cycle.period_variation)},
          {"steps_per_segment", cycle.steps_per_segment},
          {"least_steps", cycle.least_steps},
          {"most_steps", cycle.most_steps},
          {"pause_ns", cycle.pause.ns},
          {"longest_gap_ns", cycle.longest_gap.ns},
          {"first_boundary_step", cycle.first_boundary},
          {"segments", cycle.segments},
          {"confidence", json_number(cycle.confidence)},
          {"regularity", json_number(cycle.regularity)}};
}

}  // namespace

namespace {

Json json_of(const SizeWhatIf& one) {
  Json out = {{"what_if", one.text}, {"looks_back", one.causal}};
  if (!one.refused.empty()) {
    out["refused"] = one.refused;
    return out;
  }
  out["strategies"] = Json::object();
  for (const SizeWhatIf::Map& map : one.maps) {
    Json row = {{"latency_ns", map.latency.ns}};
    row["velocity_jump"] = map.jump_seen ? json_number(map.velocity_jump) : Json();
    if (map.rate_latency) row["rate_latency_ns"] = map.rate_latency->ns;
    if (map.adaptive) row["adaptive"] = {{"mean_ns", map.adaptive->mean.ns}, {"late_forces", map.adaptive->late}};
    out["strategies"][map.name] = row;
  }
  out["pause_bound_ns"] = one.pause_bound.ns;
  if (one.pace) out["pace_ns"] = one.pace->ns;
  out["drawings"] = one.drawings;
  out["drawings_left_out"] = one.left_out;
  out["pauses_over_budget"] = one.over_budget;
  out["drawings_per_s"] = json_number(one.drawings_per_s);
  out["longest_drawing_pause_ns"] = one.longest_pause.ns;
  out["longest_without_drawing_ns"] = one.longest_without.ns;
  out["simulated_against_real"] = json_number(one.simulated_against_real);
  out["segments_lost"] = json_number(one.segments_lost);
  return out;
}

Json json_of(const SizeWorstOrder& worst) {
  Json out = {{"span_ns", worst.span.ns}, {"hitches", worst.hitches}, {"most_in_a_span", worst.together}};
  if (!worst.file.empty()) {
    out["map"] = worst.map;
    out["file"] = worst.file;
  }
  out["strategies"] = Json::object();
  for (const SizeWorstOrder::Map& map : worst.maps)
    out["strategies"][map.name] = {{"latency_ns", map.latency.ns},
                                   {"lead_ns", map.lead.ns},
                                   {"worst_latency_ns", map.worst_latency.ns},
                                   {"worst_lead_ns", map.worst_lead.ns},
                                   {"orders_tried", map.tried}};
  return out;
}

Json json_of(const SizeFit& fit) {
  Json out = {{"map", fit.map}, {"fits", fit.fits()}};
  if (!fit.unknown.empty()) {
    out["unknown"] = fit.unknown;
    return out;
  }
  out["needed_latency_ns"] = fit.needed_latency.ns;
  if (fit.latency) out["latency_ns"] = fit.latency->ns;
  out["needed_lead_ns"] = fit.needed_lead.ns;
  if (fit.lead) out["lead_ns"] = fit.lead->ns;
  if (!fit.samples) return out;
  out["interaction_capacity"] = *fit.samples;
  out["force_capacity"] = *fit.forces;
  out["needed_interaction_capacity"] = fit.needed_samples;
  out["needed_force_capacity"] = fit.needed_forces;
  return out;
}

}  // namespace

std::string size_json(const SizeRecord& record) {
  Json out = {{"format", 1},
              {"input", record.input},
              {"steps", record.steps},
              {"left_out_steps", record.left_out},
              {"segments", record.segments},
              {"segments_from", record.segments_from},
              {"length_ns", record.length.ns},
              {"segment_ns", record.segment.ns},
              {"sampling_period_ns", record.sampling_period.ns},
              {"emission", record.interpolated ? "linear" : "hold"},
              {"damping_N_s_per_m", json_number(record.damping_N_s_per_m)}};
  if (record.rate) {
    out["rate"] = json_number(*record.rate);
    out["confidence"] = json_number(record.confidence);
    out["clean_segments_needed"] = record.clean_segments;
  }
  if (record.per) {
    out["per_ns"] = record.per->ns;
    out["confidence"] = json_number(record.confidence);
  }
  out["longest_pause"] = evenstep::json_of(record.pause);
  put_bounds(out, record.held, "");
  if (record.linear) put_bounds(out, *record.linear, "_linear");
  out["strategies"] = Json::object();
  for (const SizeStrategy& strategy : record.strategies) out["strategies"][strategy.name] = json_of(strategy);
  if (!record.other_jumps.empty()) {
    out["other_jumps"] = Json::array();
    for (const SizePath& path : record.other_jumps)
      out["other_jumps"].push_back({{"velocity_jump", json_number(path.jump)}, {"latency_ns", path.latency.ns}});
  }
  out["hitches"] = Json::array();
  for (const SizeHitches& kind : record.hitches) out["hitches"].push_back(json_of(kind, record));
  if (!record.what_ifs.empty()) {
    out["what_ifs"] = Json::array();
    for (const SizeWhatIf& one : record.what_ifs) out["what_ifs"].push_back(json_of(one));
  }
  if (record.worst_order) out["worst_order"] = json_of(*record.worst_order);
  if (record.fit) out["fit"] = json_of(*record.fit);
  if (const SizeStrategy* use = strategy_to_use(record)) out["use"] = use->name;
  if (record.cycle) out["cycle"] = json_of(*record.cycle);
  if (const auto& clock = record.clock)
    out["clock"] = {{"step_ns", clock->step.ns},
                    {"follows", clock->follows},
                    {"range_steps", json_number(clock->range_steps)},
                    {"dropped_steps", clock->dropped},
                    {"drops", clock->drops},
                    {"simulated_per_real", json_number(clock->pace.simulated_per_real())}};
  return json_text(out) + '\n';
}

std::string size_within_json(const SizeWithin& within) {
  const auto range = [](const auto& one) { return Json{{"least", one.least.ns}, {"most", one.most.ns}}; };
  Json out = {{"format", 1},
              {"visualization_ns", range(within.visualization)},
              {"step_ns", range(within.step)},
              {"sampling_period_ns", within.sampling_period.ns},
              {"emission", within.interpolated ? "linear" : "hold"}};
  if (within.steps) out["steps"] = {{"least", within.steps->least}, {"most", within.steps->most}};
  if (within.step_size) out["step_size_ns"] = within.step_size->ns;
  out["strategies"] = Json::object();
  for (const SizeWithin::Map& map : within.maps) {
    Json& row = out["strategies"][map.name];
    row = {{"how", name_of(map.how)},
           {"latency_ns", map.latency.ns},
           {"lead_ns", map.lead.ns},
           {"interaction_capacity", map.interaction_capacity},
           {"force_capacity", map.force_capacity}};
    if (map.how == SizeWithin::How::found) row["schedules_tried"] = map.tried;
  }
  return json_text(out) + '\n';
}

std::string size_rates_json(const SizeRecord& record) {
  Json out = {{"format", 1}, {"input", record.input}, {"segments", record.segments}};
  out["rate"] = json_number(*record.rate);
  out["confidence"] = json_number(record.confidence);
  out["clean_segments_needed"] = record.clean_segments;
  out["strategies"] = Json::object();
  for (const SizeStrategy& strategy : record.strategies) {
    if (strategy.rate) out["strategies"][strategy.name] = json_of(*strategy.rate);
  }
  return json_text(out) + '\n';
}

}  // namespace evenstep
