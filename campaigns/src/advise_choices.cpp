#include "advise_choices.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "evenstep/reports/json.h"
#include "evenstep/text/quantity.h"

namespace evenstep::internal {
namespace {

constexpr AdviceRenderer kRenderers[]{
    {"hold", R"({ kind = "force", emission = "hold" })", R"({ kind = "force", emission = "hold" })", false, false},
    {"linear", R"({ kind = "force" })", R"({ kind = "force" })", false, false},
    {"local", R"({ kind = "local" })", R"({ kind = "local" })", true, false},
    // What the device renders by itself is at each tick what `local` would send; only the hand can tell them apart.
    {"device_spring", R"({ kind = "local" })", R"({ kind = "device_spring" })", true, true}};

std::string rate_text(Rate rate) {
  return rate.den == 1 ? fmt::format("{} Hz", rate.num) : fmt::format("{}/{} Hz", rate.num, rate.den);
}

std::string device_text(const AdviceSetting& setting, const AdviceRenderer& renderer) {
  const std::string rate = rate_text(setting.sampling);
  // The springs of the line would be stretched by most where the loop carries most: advise.cpp limits its way.
  std::string out = fmt::format(
      "[[device]]\nname        = \"line\"                # shows the jumps: its hand moves evenly\nrate        = \"{}\"\n"
      "motion      = {{ kind = \"constant-velocity\", velocity = [\"{} m/s\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.2 "
      "s\" }}\nrender      = {}\nforce_limit = \"2000 N\"\n\n",
      rate, setting.speed_m_per_s, renderer.of_line);
  out += fmt::format(
      "[[device]]\nname   = \"hand\"                     # feels the force: released, it must come to rest\nrate   = "
      "\"{}\"\nmotion = {{ kind = \"hand\", mass = \"{} kg\", damping = \"{} N s/m\", offset = [\"5 mm\", \"0 mm\", \"0 "
      "mm\"] }}\nrender = {}\n",
      rate, setting.mass_kg, setting.damping_N_s_per_m, renderer.of_hand);
  if (renderer.needs_springs)
    out += fmt::format(
        "driver = \"pid\"\npid    = {{ travel = [\"40 mm\", \"40 mm\", \"0 mm\"], full_scale = \"200 N\", gain = 1.0, "
        "springs "
        "= [\"x\", \"y\"], firmware_rate = \"{}\" }}\n",
        rate_text(setting.firmware_rate));
  return out;
}

/// An expectation that holds for this very number, to a millionth of it.
void expect(std::string& out, const std::string& signal, const char* metric, double value, const char* unit) {
  constexpr double kSlack = 1e-6;
  const auto limit = [&](const char* key, double number) {
    return *unit == '\0' ? fmt::format("{} = {}\n", key, number) : fmt::format("{} = \"{} {}\"\n", key, number, unit);
  };
  out += fmt::format("\n[[expect]]\nsignal = \"{}\"\nmetric = \"{}\"\n", signal, metric);
  if (value == 0) {
    out += "equals = 0\n";
    return;
  }
  out += limit("min", value * (1 - kSlack)) + limit("max", value * (1 + kSlack));
}

}  // namespace

const AdviceRenderer& renderer_called(const std::string& name) {
  return *std::find_if(std::begin(kRenderers), std::end(kRenderers),
                       [&](const AdviceRenderer& renderer) { return renderer.name == name; });
}

std::vector<const AdviceRenderer*> renderers_of(const AdvicePace& pace, const std::vector<std::string>& names) {
  std::vector<const AdviceRenderer*> all, few;
  for (const std::string& name : names) {
    // Forces that are played as they come have no next one to go to.
    if (pace.map == StrategyKind::direct && name == "linear" && names.size() > 1) continue;
    all.push_back(&renderer_called(name));
    if (name == "hold" || name == "local") few.push_back(all.back());
  }
  return pace.all_renderers || few.empty() ? all : few;
}

std::vector<WhatIf> default_governors(const std::vector<SegmentTiming>& segments) {
  WhatIf split, budget, pace, own_lane;
  split.split = 2;
  pace.pace_percentile = 0.9;
  own_lane.own_lane = 1;
  std::vector<std::int64_t> drawings;
  for (const SegmentTiming& segment : segments) {
    if (segment.visualization) drawings.push_back((segment.visualization->end - segment.visualization->begin).ns);
  }
  if (drawings.empty()) return {split, pace, own_lane};
  constexpr std::int64_t kRound = 100'000;  // ns
  const auto at = drawings.begin() + static_cast<std::ptrdiff_t>(drawings.size() * 9 / 10);
  std::nth_element(drawings.begin(), at, drawings.end());
  budget.budget = Duration{std::max((*at + kRound - 1) / kRound, std::int64_t{1}) * kRound};
  return {split, budget, pace, own_lane};
}

std::vector<AdvicePace> paces(bool has_pauses, const AdviseOptions& options, const std::vector<WhatIf>& governors) {
  std::vector<AdvicePace> list{{.map = StrategyKind::direct, .all_renderers = true}};
  // Without pauses every step is a segment, which `paper` has no use for.
  if (has_pauses) list.push_back({.map = StrategyKind::paper});
  AdvicePace locked{.map = StrategyKind::phase_locked, .all_renderers = true};
  for (const Rate bandwidth : options.bandwidths) {
    locked.bandwidth = rate_text(bandwidth);
    list.push_back(locked);
  }
  locked.all_renderers = false;
  AdvicePace at_rate = locked;
  at_rate.at_rate = true;
  list.push_back(at_rate);
  for (const WhatIf& governor : governors) {
    locked.governor = governor;
    list.push_back(locked);
  }
  return list;
}

std::string scenario_text(const AdviceSetting& setting, const AdvicePace& pace, const AdviceRenderer& renderer,
                          const AdviceScenario& own) {
  const char* const strategy = name_of(pace.map);
  std::string out = fmt::format(
      "format  = 1\nname    = {}\nbecause = \"One choice of evenstep advise: its run gives the numbers of its row.\"\n\n"
      "[run]\nwarmup     = \"{} ns\"\nstrategies = [\"{}\"]\nlive       = \"{}\"\n\n"
      "[timing]\ntrace = \"{}\"{}\n\n"
      "[scene]\nsolver    = \"cpu-double\"\nkind      = \"spring\"\nstiffness = \"{} N/m\"\n\n",
      json_text(Json(fmt::format("{}: {}", setting.input, own.name))), own.warmup.ns, strategy, strategy, own.trace,
      pace.governor ? fmt::format("   # what if: {}", text_of(*pace.governor)) : "", own.stiffness_N_per_m);
  out += device_text(setting, renderer);
  if (!is_remap(pace.map)) return out;
  out += "\n[remap]\n";
  if (!pace.bandwidth.empty()) out += fmt::format("bandwidth = \"{}\"\n", pace.bandwidth);
  if (!own.latency) return out + "latency   = \"minimal\"\n";
  return out + fmt::format("latency   = \"{} ns\"\nlead      = \"{} ns\"\n", own.latency->latency.ns, own.latency->lead.ns);
}

std::string expectations_text(const AdviceChoice& choice) {
  std::string out;
  const auto of = [&](const char* device, const char* kind) { return fmt::format("{}.{}.{}", device, kind, choice.map); };
  expect(out, of("line", "interaction"), "velocity_jump", choice.jump_step, "step");
  expect(out, of("line", "force"), "velocity_jump", choice.force_jump_step, "step");
  expect(out, of("line", "buffers"), "underrun_rate", choice.underrun_rate, "");
  expect(out, of("closed_loop", "hand"), "loop_delay", choice.delay_s, "s");
  expect(out, of("closed_loop", "hand"), "predicted_stiffness_limit", choice.stiffness_N_per_m, "N/m");
  if (choice.comes_to_rest) expect(out, of("closed_loop", "hand"), "stable", *choice.comes_to_rest ? 1 : 0, "");
  if (choice.latency.ns > 0) expect(out, of("line", "buffers"), "latency", seconds(choice.latency), "s");
  return out;
}

}  // namespace evenstep::internal
