#include "choices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

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

/// Primes, so that no pace of segments falls in step with them. The hand that stops moves half of the time, and then twice
/// as fast as the line's.
constexpr double kLargerJump = 0.14;  // steps: twice the default
constexpr int kStopsEvery_ms = 331, kSlip_ms = 167;

std::string rate_text(Rate rate) {
  return rate.den == 1 ? fmt::format("{} Hz", rate.num) : fmt::format("{}/{} Hz", rate.num, rate.den);
}

std::string governor_text(const FrameGovernor& governor) {
  constexpr const char* kOver[] = {"skip", "hold", "merge"};
  std::vector<std::string> keys;
  if (governor.spread) keys.emplace_back("steps = \"spread\"");
  if (governor.split > 1) keys.push_back(fmt::format("split = {}", governor.split));
  if (governor.budget) {
    keys.push_back(fmt::format("budget = \"{} ns\", over_budget = \"{}\"", governor.budget->ns,
                               kOver[static_cast<int>(governor.over_budget)]));
    if (governor.over_budget != OverBudget::merge) keys.push_back(fmt::format("forecast = {}", governor.forecast));
  }
  if (governor.pace) keys.push_back(fmt::format("pace = \"{} ns\"", governor.pace->ns));
  return fmt::format("{{ {} }}", fmt::join(keys, ", "));
}

std::string timing_text(const AdvicePace& pace, const AdviceScenario& own) {
  std::string out = fmt::format("[timing]\ntrace = \"{}\"", own.trace);
  if (own.governor) out += fmt::format("\ngovernor = {}", governor_text(*own.governor));
  if (pace.governor) out += fmt::format("   # what if: {}", text_of(*pace.governor));
  return out + "\n\n";
}

std::string remap_text(const AdvicePace& pace, const AdviceScenario& own) {
  std::string out = "\n[remap]\n";
  if (!pace.bandwidth.empty()) out += fmt::format("bandwidth = \"{}\"\n", pace.bandwidth);
  if (pace.jump) out += fmt::format("jump      = {}\n", *pace.jump);
  if (!is_remap(pace.map)) return out;
  if (!own.latency) return out + "latency   = \"minimal\"\n";
  const AdviceLatency& latency = *own.latency;
  if (!latency.adaptive)
    return out + fmt::format("latency   = \"{} ns\"\nlead      = \"{} ns\"\n", latency.latency.ns, latency.lead.ns);
  const std::int64_t least = std::min(std::max(latency.lead.ns, std::int64_t{0}), latency.latency.ns);
  return out + fmt::format(
                   "latency   = \"adaptive\"\nlead      = \"{} ns\"\n"
                   "adapt     = {{ start = \"{} ns\", min = \"{} ns\", max = \"{} ns\" }}\n",
                   latency.lead.ns, latency.latency.ns, least, latency.latency.ns);
}

/// A device whose hand moves as programmed.
std::string programmed_text(const AdviceSetting& setting, const AdviceRenderer& renderer, const char* name,
                            const char* shows, const std::string& motion) {
  return fmt::format(
      "[[device]]\nname        = {:<22}# {}\nrate        = \"{}\"\nmotion      = {{ {} }}\nrender      = {}\n"
      "force_limit = \"2000 N\"\n",
      name, shows, rate_text(setting.sampling), motion, renderer.of_line);
}

std::string stops_text(const AdviceSetting& setting, const AdviceRenderer& renderer) {
  // It stops at another place of the segment each time, and goes as far as the line.
  return programmed_text(setting, renderer, "\"stops\"", "shows what runs on where a hand stops",
                         fmt::format("kind = \"stick-slip\", velocity = [\"{} m/s\", \"0 m/s\", \"0 m/s\"], stick = \"{} "
                                     "ms\", slip = \"{} ms\"",
                                     setting.speed_m_per_s, kStopsEvery_ms - kSlip_ms, kSlip_ms));
}

std::string device_text(const AdviceSetting& setting, const AdviceRenderer& renderer) {
  // The line's force would be largest where the loop carries the stiffest springs, so advise.cpp limits how far its hand
  // goes.
  std::string out = programmed_text(setting, renderer, "\"line\"", "shows the jumps: its hand moves evenly",
                                    fmt::format("kind = \"constant-velocity\", velocity = [\"{} m/s\", \"0 m/s\", \"0 "
                                                "m/s\"], start = \"smooth 0.2 s\"",
                                                setting.speed_m_per_s));
  out += fmt::format(
      "\n[[device]]\nname   = \"hand\"                     # feels the force: released, it must come to rest\nrate   = "
      "\"{}\"\nmotion = {{ kind = \"hand\", mass = \"{} kg\", damping = \"{} N s/m\", offset = [\"5 mm\", \"0 mm\", \"0 "
      "mm\"] }}\nrender = {}\n",
      rate_text(setting.sampling), setting.mass_kg, setting.damping_N_s_per_m, renderer.of_hand);
  if (renderer.needs_springs)
    out += fmt::format(
        "driver = \"pid\"\npid    = {{ travel = [\"40 mm\", \"40 mm\", \"0 mm\"], full_scale = \"200 N\", gain = 1.0, "
        "springs = [\"x\", \"y\"], firmware_rate = \"{}\" }}\n",
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

double stops_speed(double speed_m_per_s) { return speed_m_per_s * kStopsEvery_ms / kSlip_ms; }

const AdviceRenderer& renderer_called(const std::string& name) {
  return *std::find_if(std::begin(kRenderers), std::end(kRenderers),
                       [&](const AdviceRenderer& renderer) { return renderer.name == name; });
}

std::vector<const AdviceRenderer*> renderers_of(const AdvicePace& pace, const std::vector<std::string>& names) {
  std::vector<const AdviceRenderer*> all, few;
  for (const std::string& name : names) {
    // A force that is played as it comes has no next one to move to.
    if (pace.map == StrategyKind::direct && name == "linear" && names.size() > 1) continue;
    all.push_back(&renderer_called(name));
    if (name == "hold" || name == "local") few.push_back(all.back());
  }
  return pace.all_renderers || few.empty() ? all : few;
}

double waiting_share(const std::vector<SegmentTiming>& segments) {
  std::int64_t waited = 0;
  for (std::size_t k = 1; k < segments.size(); ++k) {
    const SegmentTiming& before = segments[k - 1];
    RealTime busy = before.visualization ? before.visualization->end : before.begin;
    if (!before.steps.empty()) busy = std::max(busy, before.steps.back().end);
    waited += std::max<std::int64_t>((segments[k].begin - busy).ns, 0);
  }
  const Duration length = segments.back().begin - segments.front().begin;
  return length.ns > 0 ? static_cast<double>(waited) / static_cast<double>(length.ns) : 0;
}

std::vector<WhatIf> default_governors(const std::vector<SegmentTiming>& segments) {
  const WhatIf split{.split = 2}, pace{.pace_percentile = 0.9}, own_lane{.own_lane = 1};
  WhatIf budget;
  std::vector<WhatIf> out;
  constexpr double kMaterial = 0.1;  // of the time
  if (waiting_share(segments) >= kMaterial) out.push_back({.spread = true});
  out.push_back(split);
  std::vector<std::int64_t> drawings;
  for (const SegmentTiming& segment : segments) {
    if (segment.visualization) drawings.push_back((segment.visualization->end - segment.visualization->begin).ns);
  }
  if (!drawings.empty()) {
    constexpr std::int64_t kRound = 100'000;  // ns
    const auto at = drawings.begin() + static_cast<std::ptrdiff_t>(drawings.size() * 9 / 10);
    std::nth_element(drawings.begin(), at, drawings.end());
    budget.budget = Duration{std::max((*at + kRound - 1) / kRound, std::int64_t{1}) * kRound};
    out.push_back(budget);
  }
  out.insert(out.end(), {pace, own_lane, {.own_lane = 1, .spread = true}});
  return out;
}

std::vector<AdvicePace> paces(bool has_pauses, bool has_clock, const AdviseOptions& options,
                              const std::vector<WhatIf>& governors) {
  std::vector<AdvicePace> list{{.map = StrategyKind::direct, .all_renderers = true}};
  // Without pauses every step is a segment, which `paper` has no use for.
  if (has_pauses) list.push_back({.map = StrategyKind::paper});
  if (has_clock) list.push_back({.map = StrategyKind::clocked, .all_renderers = true});
  AdvicePace locked{.map = StrategyKind::phase_locked, .all_renderers = true};
  for (const Rate bandwidth : options.bandwidths) {
    locked.bandwidth = rate_text(bandwidth);
    list.push_back(locked);
  }
  locked.all_renderers = false;
  AdvicePace rougher = locked;
  rougher.jump = kLargerJump;
  list.push_back(rougher);
  AdvicePace at_rate = locked;
  at_rate.at_rate = true;
  list.push_back(at_rate);
  AdvicePace adaptive = locked;
  adaptive.adaptive = true;
  list.push_back(adaptive);
  AdvicePace predicted = locked;
  predicted.map = StrategyKind::predict;
  list.push_back(predicted);
  for (const WhatIf& governor : governors) {
    locked.governor = governor;
    list.push_back(locked);
  }
  return list;
}

std::string scenario_text(const AdviceSetting& setting, const AdvicePace& pace, const AdviceRenderer& renderer,
                          const AdviceScenario& own, bool stops) {
  const char* const strategy = name_of(pace.map);
  std::string out = fmt::format(
      "format  = 1\nname    = {}\nbecause = \"One choice of evenstep advise: its run gives the numbers of its row.\"\n\n"
      "[run]\nwarmup     = \"{} ns\"\nstrategies = [\"{}\"]\nlive       = \"{}\"\n\n",
      json_text(Json(fmt::format("{}: {}", setting.input, own.name))), own.warmup.ns, strategy,
      pace.map == StrategyKind::predict ? "phase_locked" : strategy);
  out += timing_text(pace, own);
  out += fmt::format("[scene]\nsolver    = \"cpu-double\"\nkind      = \"spring\"\nstiffness = \"{} N/m\"\n\n",
                     own.stiffness_N_per_m);
  out += stops ? stops_text(setting, renderer) : device_text(setting, renderer);
  if (!pace.bandwidth.empty() || is_remap(pace.map)) out += remap_text(pace, own);
  if (own.search_to_N_per_m && !stops)
    out += fmt::format(
        "\n[study]   # evenstep study finds what the row carries\nstiffness_limit = {{ from = \"{} N/m\", to = "
        "\"{} N/m\" }}\n",
        own.search_from_N_per_m, *own.search_to_N_per_m);
  return out;
}

std::string expectations_text(const AdviceChoice& choice) {
  std::string out;
  const auto of = [&](const char* device, const char* kind) { return fmt::format("{}.{}.{}", device, kind, choice.map); };
  expect(out, of("line", "interaction"), "velocity_jump", choice.jump_step, "step");
  expect(out, of("line", "force"), "velocity_jump", choice.force_jump_step, "step");
  expect(out, of("line", "buffers"), "underrun_rate", choice.underrun_rate, "");
  const double spread_s = choice.latency_most ? seconds(*choice.latency_most) - seconds(choice.latency) : 0;
  expect(out, of("closed_loop", "hand"), "loop_delay", choice.delay_s + spread_s, "s");
  if (!choice.searched) expect(out, of("closed_loop", "hand"), "predicted_stiffness_limit", choice.stiffness_N_per_m, "N/m");
  if (choice.comes_to_rest) expect(out, of("closed_loop", "hand"), "stable", *choice.comes_to_rest ? 1 : 0, "");
  if (choice.latency_most) expect(out, of("line", "force"), "schedule_latency_mean", seconds(choice.latency), "s");
  const Duration latency = choice.latency_most.value_or(choice.latency);
  if (latency.ns > 0) expect(out, of("line", "buffers"), "latency", seconds(latency), "s");
  return out;
}

std::string stops_expectations_text(const AdviceChoice& choice) {
  std::string out;
  expect(out, fmt::format("stops.interaction.{}", choice.map), "error_max", choice.stop_error_m, "m");
  return out;
}

}  // namespace evenstep::internal
