#include "evenstep/reports/advice_record.h"
#include "evenstep/reports/json.h"

namespace evenstep {
namespace {

Json json_of(const AdviceChoice& choice) {
  Json needs = Json::array();
  if (choice.needs_stiffness) needs.push_back("stiffness");
  if (choice.needs_springs) needs.push_back("springs");
  if (!choice.governor.empty()) needs.push_back("governor");
  Json out = {{"number", choice.number},
              {"name", name_of(choice)},
              {"scenario", "choice-" + std::to_string(choice.number) + ".toml"},
              {"map", choice.map},
              {"bandwidth_Hz", choice.bandwidth_Hz > 0 ? json_number(choice.bandwidth_Hz) : Json(nullptr)},
              {"allowed_jump", choice.allowed_jump > 0 ? json_number(choice.allowed_jump) : Json(nullptr)},
              {"governor", choice.governor.empty() ? Json(nullptr) : Json(choice.governor)},
              {"accepted_rate", json_number(choice.accepted_rate)},
              {"adaptive", choice.adaptive},
              {"renderer", choice.renderer},
              {"needs", std::move(needs)}};
  if (!choice.failure.empty()) {
    out["failure"] = choice.failure;
    return out;
  }
  const bool maps = choice.map != "direct";
  out["latency_ns"] = maps ? Json(choice.latency.ns) : Json(nullptr);
  out["lead_ns"] = maps ? Json(choice.lead.ns) : Json(nullptr);
  out["latency_most_ns"] = choice.latency_most ? Json(choice.latency_most->ns) : Json(nullptr);
  out["bound_ns"] = choice.bound ? Json(choice.bound->ns) : Json(nullptr);
  out["delay_s"] = json_number(choice.delay_s);
  out["jump_step"] = json_number(choice.jump_step);
  out["force_jump_step"] = json_number(choice.force_jump_step);
  out["underrun_rate"] = json_number(choice.underrun_rate);
  if (choice.unseen) {
    out["unseen"] = {{"late_segments", choice.unseen->late},
                     {"played_segments", choice.unseen->played},
                     {"late_by_ns", choice.unseen->late_by.ns},
                     {"missing_by_ns", choice.unseen->missing_by.ns}};
  }
  out["late_any_phase"] = json_number(choice.late_any_phase);
  out["drawings_lost"] = json_number(choice.drawings_lost);
  out["simulated_lost"] = json_number(choice.simulated_lost);
  out["stop_error_m"] = json_number(choice.stop_error_m);
  out["runs_on_s"] = json_number(choice.runs_on_s);
  out["stiffness_from"] = choice.searched ? "search" : "law";
  out["stiffness_N_per_m"] = json_number(choice.stiffness_N_per_m);
  out["tried_N_per_m"] = json_number(choice.tried_N_per_m);
  out["comes_to_rest"] = choice.comes_to_rest ? Json(*choice.comes_to_rest) : Json(nullptr);
  out["ranked"] = choice.ranked;
  out["pareto"] = choice.on_front;
  out["beaten_by"] = choice.dominated_by;
  out["ties"] = choice.ties;
  return out;
}

Json number_of(const AdviceChoice* choice) { return choice == nullptr ? Json(nullptr) : Json(choice->number); }

}  // namespace

std::string advice_json(const AdviceRecord& record) {
  Json choices = Json::array();
  for (const AdviceChoice& choice : record.choices) choices.push_back(json_of(choice));
  const Json out = {{"input", record.input},
                    {"segments_from", record.segments_from},
                    {"steps", record.steps},
                    {"segments", record.segments},
                    {"length_ns", record.length.ns},
                    {"slot_ns", record.slot.ns},
                    {"warmup_ns", record.warmup.ns},
                    {"sampling_period_ns", record.sampling_period.ns},
                    {"pause_bound_ns", record.pause_bound.ns},
                    {"longest_pause", evenstep::json_of(record.pause)},
                    {"mass_kg", json_number(record.mass_kg)},
                    {"damping_N_s_per_m", json_number(record.damping_N_s_per_m)},
                    {"firmware_rate_Hz", json_number(record.firmware_rate_Hz)},
                    {"speed_m_per_s", json_number(record.speed_m_per_s)},
                    {"use", number_of(choice_to_use(record, true))},
                    {"use_with_forces_only", number_of(choice_to_use(record, false))},
                    {"conclusion", advice_conclusion(record)},
                    {"notes", record.notes},
                    {"choices", std::move(choices)}};
  return json_text(out, "choices") + "\n";
}

}  // namespace evenstep
