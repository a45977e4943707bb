#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evenstep/apps/explain.h"
#include "evenstep/campaigns/cost.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/campaigns/sweep.h"
#include "evenstep/harness/foresee.h"
#include "evenstep/harness/rendering.h"
#include "evenstep/harness/saturation_forecast.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/underrun_rate.h"
#include "evenstep/reports/json.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/reports/writers.h"
#include "evenstep/sim/solver.h"
#include "evenstep/sim/stability.h"
#include "src/commands.h"
#include "src/opencl_lines.h"
#include "src/output.h"
#include "src/progress.h"

namespace evenstep::app {
namespace {

using Json = nlohmann::ordered_json;

double ms(Duration d) { return static_cast<double>(d.ns) * 1e-6; }

/// What is known of a scenario: every fact is a line for people and a value for programs.
class Facts {
 public:
  void add(const std::string& key, Json value, const std::string& lines) {
    json_[key] = std::move(value);
    text_ += lines;
  }
  void add_to_list(const std::string& key, Json value, const std::string& lines) {
    json_[key].push_back(std::move(value));
    text_ += lines;
  }
  const std::string& text() const { return text_; }
  const Json& json() const { return json_; }

 private:
  std::string text_;
  Json json_ = Json::object();
};

Json json_of(const std::vector<Diagnostic>& errors) {
  Json list = Json::array();
  for (const Diagnostic& error : errors)
    list.push_back({{"file", error.file}, {"line", error.line}, {"column", error.column}, {"message", error.message}});
  return list;
}

void explain_solver(const Scenario& scenario, Facts& facts) {
  const Rate rate = scenario.scene.step_rate;
  facts.add("step_s", period_s(rate),
            fmt::format("  step size    1 / ({}/{} Hz) = {:.6g} ms of simulation time\n", rate.num, rate.den,
                        1e3 * period_s(rate)));
  facts.add("scene", describe(scenario.scene), fmt::format("  scene        {}\n", describe(scenario.scene)));
  const std::string stability = stability_lines(scenario);
  facts.add("stability", stability, stability);
  if (const std::string device = opencl_line(scenario); !device.empty())
    facts.add("opencl_device", device, fmt::format("  OpenCL       {}\n", device));
  const std::vector<std::string> absent = left_out(scenario.scene);
  facts.add("left_out", absent, absent.empty() ? "" : fmt::format("  not used     {}\n", fmt::join(absent, ", ")));
  if (!std::holds_alternative<ForeignScene>(scenario.scene.body)) return;
  const std::vector<std::string> lacks = make_solver(scenario.solver, scenario.scene)->info().lacks;
  facts.add("solver_lacks", lacks, lacks.empty() ? "" : fmt::format("  lacks        {}\n", fmt::join(lacks, ", ")));
}

void explain_case(const CaseSpec& spec, Facts& facts) {
  std::vector<std::string> methods;
  const std::vector<std::string> solvers = spec.solver_names();
  for (const Method method : spec.methods) methods.emplace_back(name_of(method));
  facts.add("case", {{"kind", spec.kind}, {"values", spec.values}},
            fmt::format("  case         {}, {} values from {} to {}\n", spec.kind, spec.values.size(), spec.values.front(),
                        spec.values.back()));
  facts.add("methods", methods, fmt::format("  methods      {}\n", fmt::join(methods, ", ")));
  facts.add("solvers", solvers, fmt::format("  solvers      {}\n", fmt::join(solvers, ", ")));
}

void explain_sweep(const SweepSpec& sweep, Facts& facts) {
  std::size_t points = sweep.seeds.size();
  std::string of = fmt::format("{} seed{}", points, points == 1 ? "" : "s");
  for (const SweepAxis& axis : sweep.grid) {
    points *= axis.values.size();
    of += fmt::format(" x {} of {}", axis.values.size(), axis.path);
  }
  facts.add("sweep_points", points, fmt::format("  sweep        {} points: {}\n", points, of));
}

void explain_device(const DeviceSpec& device, Facts& facts) {
  const bool linear = device.emission == Emission::linear;
  const auto* foreign = std::get_if<ForeignDriverSpec>(&device.driver);
  std::string lines = fmt::format("  device       {}: {}/{} Hz, phase {:.6g} ms, {} emission{}\n", device.name,
                                  device.rate.num, device.rate.den, ms(device.phase), linear ? "linear" : "hold",
                                  foreign ? fmt::format(", driver '{}', not evenstep's own", foreign->part.name) : "");
  if (device.hand) {
    lines +=
        fmt::format("               a hand of {:.6g} kg, {:.6g} N s/m, {:.6g} N/m that feels the force {:.6g} ms later\n",
                    device.hand->total_mass_kg(), device.hand->total_damping_N_s_per_m(),
                    device.hand->total_stiffness_N_per_m(), ms(device.force_delay));
  }
  facts.add_to_list("devices",
                    {{"name", device.name},
                     {"period_s", period_s(device.rate)},
                     {"phase_ns", device.phase.ns},
                     {"emission", linear ? "linear" : "hold"},
                     {"hand", device.hand.has_value()},
                     {"force_delay_ns", device.force_delay.ns}},
                    lines);
}

std::string adaptation_lines(const Scenario& scenario, const StrategyPlan& plan, Json& json) {
  const AdaptiveLatencyOptions& adapt = scenario.remap.adapt;
  const AdaptationForecast forecast = forecast_adaptation(scenario, plan);
  json["adaptive"] = {{"mean_s", forecast.mean_s}, {"largest_ns", forecast.largest.ns}, {"growths", forecast.growths}};
  return fmt::format(
             "               adaptive: from {:.6f} ms, {:.6f} to {:.6f} ms, {:.6g} ms above all needs of {:.6g} s, slew "
             "{:.6g} %\n",
             ms(adapt.start), ms(adapt.least), ms(adapt.most), ms(adapt.margin), seconds(adapt.window),
             static_cast<double>(adapt.slew_ppm) * 1e-4) +
         fmt::format("               mean {:.6f} ms, largest {:.6f} ms, grows {} times on this timing\n",
                     1e3 * forecast.mean_s, ms(forecast.largest), forecast.growths);
}

void explain_strategy(const Scenario& scenario, const StrategyPlan& plan, Facts& facts) {
  Json json = {{"name", name_of(plan.kind)},
               {"lead_ns", plan.lead.ns},
               {"latency_ns", plan.latency.ns},
               {"interaction_capacity", plan.interaction_capacity},
               {"force_capacity", plan.force_capacity}};
  std::string lines =
      fmt::format("  {:<12} lead {:.6f} ms, latency {:.6f} ms, rings {} samples, {} forces\n", name_of(plan.kind),
                  ms(plan.lead), ms(plan.latency), plan.interaction_capacity, plan.force_capacity);
  if (plan.needed) {
    json["needed_interaction_capacity"] = plan.needed->samples;
    json["needed_force_capacity"] = plan.needed->forces;
    const bool enough = plan.needed->samples <= plan.interaction_capacity && plan.needed->forces <= plan.force_capacity;
    lines += fmt::format("               {}: this timing needs {} and {}\n", enough ? "these are enough" : "too small",
                         plan.needed->samples, plan.needed->forces);
  }
  if (plan.adapts) lines += adaptation_lines(scenario, plan, json);
  for (const DeviceSpec& device : scenario.devices) {
    const std::string rendering = rendering_line(scenario, plan, device);
    json["rendering"][device.name] = rendering;
    lines += fmt::format("               {}: {}\n", device.name, rendering);
  }
  if (plan.sizing.has_steps()) {
    const auto& [any, here] = plan.sizing;
    json["latency_any_phase_ns"] = any.latency.ns;
    json["lead_any_phase_ns"] = any.lead.ns;
    json["latency_this_phase_ns"] = here.latency.ns;
    json["lead_this_phase_ns"] = here.lead.ns;
    StrategyPlan::Predicted worst;
    for (const StrategyPlan::Predicted& device : plan.predicted) {
      worst.interaction_underruns = std::max(worst.interaction_underruns, device.interaction_underruns);
      worst.late_forces = std::max(worst.late_forces, device.late_forces);
    }
    json["samples_missing"] = worst.interaction_underruns;
    json["forces_late"] = worst.late_forces;
    lines += fmt::format(
        "               least: any device phase {:.6f} ms (least lead {:.6f}, step {}), this phase {:.6f} ms "
        "(least lead {:.6f}, step {})\n",
        ms(any.latency), ms(any.lead), any.latency_culprit, ms(here.latency), ms(here.lead), here.latency_culprit);
    if (const std::optional<TrustedLatency> trusted = trusted_latency(scenario, plan.kind)) {
      if (trusted->per.refused.empty()) json["latency_for_an_hour_ns"] = trusted->per.latency.ns;
      lines += fmt::format("               for an hour, 95 % sure: {}\n", text(*trusted));
    }
    lines += fmt::format("               with these: {} samples missing, {} forces late\n", worst.interaction_underruns,
                         worst.late_forces);
  }
  facts.add_to_list("strategies", std::move(json), lines);
}

/// Says what will be saturated, and returns the expectations that cannot be judged because of it.
std::vector<Diagnostic> explain_saturation(const Scenario& scenario, const std::vector<StrategyPlan>& plans, Facts& facts) {
  const std::vector<ForetoldSaturation> foretold = foretell_saturation(scenario);
  facts.add("saturation", Json::array(), "");
  for (const ForetoldSaturation& one : foretold) {
    facts.add_to_list("saturation",
                      {{"device", one.device},
                       {"cause", name_of(one.cause)},
                       {"first_ns", one.first.ns},
                       {"limit", one.limit},
                       {"expected", one.expected}},
                      fmt::format("  saturation   {}{}\n", text(one), one.expected ? " (expected)" : ""));
  }
  return foretold_errors(scenario, plans, foretold);
}

/// Says what must go wrong in a run; false if nothing is known.
bool explain_failures(const Scenario& scenario, const std::vector<StrategyPlan>& plans, Facts& facts) {
  facts.add("must_fail", Json::array(), "");
  if (scenario.expect_stop) return false;
  const auto* tissue = std::get_if<TissueScene>(&scenario.scene.body);
  if (tissue && !scenario.scene.allow_unstable) {
    const Rate rate = scenario.scene.step_rate;
    const int least = auto_substeps(*tissue, rate);
    const int substeps = tissue->substeps > 0 ? tissue->substeps : least;
    if (period_s(rate) / substeps > step_limit(*tissue).step_s) {
      const std::string why =
          fmt::format("the step is above its limit, and the run will not start; substeps = \"auto\" or at least {}", least);
      facts.add_to_list("must_fail", {{"why", why}}, fmt::format("must fail: {}\n", why));
      return true;
    }
  }
  const std::vector<ExpectationResult> failures = foresee_failures(scenario, plans);
  if (failures.empty()) return false;
  for (const ExpectationResult& failure : failures) {
    annotate(AnnotationLevel::error, {failure.file, failure.line, failure.column}, "evenstep: must fail",
             failure_message(failure));
    facts.add_to_list("must_fail",
                      {{"signal", failure.signal},
                       {"metric", failure.metric},
                       {"file", failure.file},
                       {"line", failure.line},
                       {"column", failure.column},
                       {"value", failure.value ? Json(*failure.value) : Json(nullptr)},
                       {"unit", failure.unit},
                       {"min", failure.min ? Json(*failure.min) : Json(nullptr)},
                       {"max", failure.max ? Json(*failure.max) : Json(nullptr)},
                       {"why", failure.where}},
                      "");
  }
  facts.add("verdict", "must fail", "must fail:\n" + verdict_table(failures, false));
  return true;
}

void explain_head(const Scenario& scenario, Facts& facts) {
  facts.add("file", scenario.file, scenario.file + "\n");
  facts.add("name", scenario.name, "  " + scenario.name + "\n");
  facts.add("because", scenario.because,
            scenario.because.empty() ? "" : fmt::format("  because      {}\n", scenario.because));
  facts.add("verdict", "open", "");
  std::string notes;
  for (const Diagnostic& note : scenario.notes)
    notes += fmt::format("  note         {}:{}:{}: {}\n", note.file, note.line, note.column, note.message);
  facts.add("notes", json_of(scenario.notes), notes);
}

void explain_run(const Scenario& scenario, Facts& facts) {
  facts.add("run",
            {{"duration_ns", scenario.run_duration.ns}, {"judged_from_ns", scenario.warmup.ns}, {"seed", scenario.seed}},
            fmt::format("  run          {:.6g} s, judged from {:.6g} s, seed {}\n", seconds(scenario.run_duration),
                        seconds(scenario.warmup), scenario.seed));
  const NominalUnits& nominal = scenario.nominal;
  const std::size_t recorded = scenario.timing.trace.size();
  facts.add("timing",
            {{"segment_ns", nominal.segment.ns},
             {"visualization_ns", nominal.visualization.ns},
             {"step_ns", nominal.step_run_time.ns},
             {"slot_ns", nominal.slot.ns},
             {"recorded_segments", recorded}},
            fmt::format("  timing       segment {:.6f} ms, visualization {:.6f} ms, step {:.6f} ms, slot {:.6f} ms{}\n",
                        ms(nominal.segment), ms(nominal.visualization), ms(nominal.step_run_time), ms(nominal.slot),
                        recorded == 0 ? ""
                        : scenario.timing.source
                            ? fmt::format(" (means of {} segments of '{}')", recorded, scenario.timing.source->name)
                            : fmt::format(" (means of {} recorded segments)", recorded)));
}

/// What the longest pause consists of, and whether simulated time passes as fast as real time.
void explain_pauses(const ForetoldSchedule& foretold, Facts& facts) {
  const PauseParts& pause = foretold.longest_pause;
  const std::string parts = text(pause), pace = text(foretold.pace);
  facts.add("longest_pause", evenstep::json_of(pause), parts.empty() ? "" : fmt::format("  pause        {}\n", parts));
  facts.add("simulated_per_real", json_number(foretold.pace.simulated_per_real()),
            pace.empty() ? "" : fmt::format("  pace         {}\n", pace));
}

/// What the governor does with drawings that exceed its budget.
std::string gives_up(const FrameGovernor& governor) {
  std::string text;
  if (!governor.budget)
    text = "gives up no drawing";
  else if (governor.over_budget == OverBudget::merge)
    text = "what a drawing takes longer is drawn in the next pauses, and those due there are left out";
  else
    text = fmt::format("a drawing that is expected to take longer is left out, {}",
                       governor.over_budget == OverBudget::hold ? "its pause is kept" : "and the steps follow at once");
  if (governor.pace) text += "; no segment begins before its turn, so fewer steps where work is faster";
  return text;
}

void explain_governor(const FrameGovernor& governor, const ForetoldDrawings& drawings, Facts& facts) {
  constexpr std::array kOverBudget{"skip", "hold", "merge"};
  const char* over = kOverBudget.at(static_cast<std::size_t>(governor.over_budget));
  const bool forecasts = governor.budget && governor.over_budget != OverBudget::merge;
  std::vector<std::string> parts;
  if (governor.spread) parts.emplace_back("spread");
  if (governor.split > 1) parts.push_back(fmt::format("split {}", governor.split));
  if (governor.budget) parts.push_back(fmt::format("budget {:.6g} ms {}", ms(*governor.budget), over));
  if (forecasts) parts.push_back(fmt::format("forecast {}", governor.forecast));
  if (governor.pace) parts.push_back(fmt::format("pace {:.6f} ms", ms(*governor.pace)));
  if (parts.empty()) parts.emplace_back("changes nothing");
  Json json = {{"split", governor.split}};
  if (governor.spread) json["steps"] = "spread";
  if (governor.budget) json.update({{"budget_ns", governor.budget->ns}, {"over_budget", over}});
  if (forecasts) json["forecast"] = governor.forecast;
  if (governor.pace) json["pace_ns"] = governor.pace->ns;
  json.update({{"gives_up", gives_up(governor)}, {"drawings", drawings.finished}, {"left_out", drawings.left_out}});
  facts.add("governor", std::move(json),
            fmt::format("  governor     {}: {}; on this timing {} drawings finished and {} left out where it is judged\n",
                        fmt::join(parts, ", "), gives_up(governor), drawings.finished, drawings.left_out));
}

void explain_faults(const ForetoldSchedule& foretold, Facts& facts) {
  for (const ForetoldFault& fault : foretold.faults) {
    const std::string until = fault.to      ? fmt::format("to {:.10g} s", seconds(*fault.to - RealTime{}))
                              : fault.lasts ? "until the end of the run"
                                            : "and not over when the run ends";
    facts.add_to_list("faults",
                      {{"name", fault.name},
                       {"from_ns", fault.from.ns},
                       {"to_ns", fault.to ? Json(fault.to->ns) : Json(nullptr)},
                       {"lasts", fault.lasts}},
                      fmt::format("  fault        {}: {:.10g} s {}\n", fault.name, seconds(fault.from - RealTime{}), until));
  }
  if (foretold.faults.empty()) return;
  const std::optional<RealTime> last = foretold.last_end();
  facts.add("faults_end_ns", last ? Json(last->ns) : Json(nullptr),
            last ? fmt::format("  faults end   {:.10g} s: recovery_time counts from there\n", seconds(*last - RealTime{}))
                 : "  faults end   not in this run, so there is no recovery_time\n");
}

/// How the forces come, and the least that each strategy needs for it.
void explain_source(const Scenario& scenario, const std::vector<StrategyPlan>& plans, Facts& facts) {
  if (!scenario.timing.elsewhere) return;
  const SourceSpec& source = *scenario.timing.elsewhere;
  Json json = {{"delay_ns", source.delay.ns}, {"jitter_ns", source.jitter.ns},   {"lost", source.lost},
               {"late", source.late},         {"late_by_ns", source.late_by.ns}, {"clock_rate_error_ppm", source.clock_ppm}};
  std::vector<std::string> least;
  for (const StrategyPlan& plan : plans) {
    if (plan.sizing.has_steps()) {
      const Duration latency = plan.sizing.any_phase.latency;
      json["least_latency_ns"][name_of(plan.kind)] = latency.ns;
      least.push_back(fmt::format("{} {:.6f} ms", name_of(plan.kind), ms(latency)));
    } else if (plan.least_entries > 0) {
      const int set = scenario.playing.chunk.entries;
      json["entries"] = set;
      json["least_entries"][name_of(plan.kind)] = plan.least_entries;
      least.push_back(fmt::format("{} {} entries of {} set{}", name_of(plan.kind), plan.least_entries, set,
                                  plan.least_entries > set ? ", so ticks will run dry" : ""));
    }
  }
  facts.add(
      "source", std::move(json),
      fmt::format("  source       delay {:.6g} ms, jitter {:.6g} ms, lost {:.6g} %, late {:.6g} % by {:.6g} ms, clock {} "
                  "ppm{}{}\n",
                  ms(source.delay), ms(source.jitter), 100 * source.lost, 100 * source.late, ms(source.late_by),
                  source.clock_ppm, least.empty() ? "" : "; at least ", fmt::join(least, ", ")));
}

/// Says what a run on a wall clock would be refused for.
void explain_build(const Scenario& scenario, Facts& facts) {
  for (const Diagnostic& missing : missing_in_build(scenario, ClockKind::wall))
    facts.add_to_list("wall_clock_refused", text(missing), fmt::format("  wall clock   refused: {}\n", text(missing)));
}

/// Explains the scenario. Returns what a run could not judge; the fact `verdict` says that the run must fail.
std::vector<Diagnostic> explain(const Scenario& scenario, Facts& facts) {
  explain_head(scenario, facts);
  if (scenario.case_spec) {
    explain_case(*scenario.case_spec, facts);
    facts.add("expectations", scenario.expectations.size(),
              fmt::format("  expectations {}\n\n", scenario.expectations.size()));
    return {};
  }
  explain_run(scenario, facts);
  const ForetoldSchedule foretold = foretell_schedule(scenario);
  if (!scenario.timing.elsewhere) explain_pauses(foretold, facts);
  if (scenario.timing.governor) explain_governor(*scenario.timing.governor, foretold.drawings, facts);
  explain_faults(foretold, facts);
  explain_solver(scenario, facts);
  explain_build(scenario, facts);
  for (const DeviceSpec& device : scenario.devices) explain_device(device, facts);
  const std::vector<StrategyPlan> plans = plan(scenario);
  explain_source(scenario, plans, facts);
  for (const StrategyPlan& plan : plans) explain_strategy(scenario, plan, facts);
  std::vector<Diagnostic> saturated = explain_saturation(scenario, plans, facts);
  if (scenario.sweep) explain_sweep(*scenario.sweep, facts);
  facts.add("expectations", scenario.expectations.size(), fmt::format("  expectations {}\n", scenario.expectations.size()));
  for (const std::string& line : explain_rates(scenario))
    facts.add_to_list("rates", line, fmt::format("               {}\n", line));
  if (explain_failures(scenario, plans, facts) || !saturated.empty()) facts.add("verdict", "must fail", "");
  facts.add("errors", json_of(saturated), "\n");
  return saturated;
}

}  // namespace

Diagnostic refusal_of(const Scenario& scenario, const SolverError& error) {
  const Place& place = scenario.scene_place;
  return {place.file, place.line, place.column, std::string(error.what()) + "; " + error.remedy()};
}

namespace {
int substeps_of(const Scenario& scenario, const TissueScene& tissue) {
  return tissue.substeps > 0 ? tissue.substeps : auto_substeps(tissue, scenario.scene.step_rate);
}
}  // namespace

std::string stability_lines(const Scenario& scenario) {
  const auto* tissue = std::get_if<TissueScene>(&scenario.scene.body);
  if (tissue == nullptr) return "";
  const StepLimit limit = step_limit(*tissue);
  const int substeps = substeps_of(scenario, *tissue);
  const double substep_s = period_s(scenario.scene.step_rate) / substeps;
  const std::string method = fmt::format("  method       {}, {} substep{} of {:.4g} ms\n", name_of(tissue->method), substeps,
                                         substeps == 1 ? "" : "s", 1e3 * substep_s);
  if (!std::isfinite(limit.step_s)) return method + "  stability    implicit: stable at any step\n";
  const std::string limits = fmt::format(
      "  stability    dt_max {:.4g} ms in every configuration ({:.4g} ms at rest, not safe), k_max {:.4g} N/m at this "
      "substep\n               {}\n",
      1e3 * limit.step_s, 1e3 * limit.rest_state_step_s,
      tissue->stiffness_N_per_m * stiffness_margin(tissue->method, limit, substep_s), what_sets(*tissue, limit));
  return method + limits + instability_line(scenario);
}

std::string instability_line(const Scenario& scenario) {
  const auto* tissue = std::get_if<TissueScene>(&scenario.scene.body);
  if (tissue == nullptr) return "";
  const StepLimit limit = step_limit(*tissue);
  const double substep_s = period_s(scenario.scene.step_rate) / substeps_of(scenario, *tissue);
  if (substep_s <= limit.step_s) return "";
  return fmt::format("  UNSTABLE     the substep is {:.4g} times dt_max: {}\n", substep_s / limit.step_s,
                     scenario.scene.allow_unstable
                         ? "allow_unstable lets it start, and its forces may be wrong or grow without end"
                         : "a run is refused; more substeps, less stiffness, or allow_unstable = true");
}

std::string rendering_lines(const Scenario& scenario) {
  std::string lines;
  const auto local = [](const DeviceSpec& device) { return std::holds_alternative<LocalRender>(device.render); };
  if (std::none_of(scenario.devices.begin(), scenario.devices.end(), local)) return lines;
  for (const StrategyPlan& plan : plan(scenario)) {
    for (const DeviceSpec& device : scenario.devices) {
      if (local(device))
        lines += fmt::format("  {:<12} {}: {}\n", name_of(plan.kind), device.name, rendering_line(scenario, plan, device));
    }
  }
  return lines;
}

namespace {

struct CheckArguments {
  std::vector<std::string> paths, set;
  bool cost = false;
  bool json = false;
};

/// Measures what the parts of the run cost.
ExitCode explain_cost(const Scenario& scenario, const std::atomic<bool>& interrupted, Facts& facts) {
  const auto not_measured = [&](const std::string& why) {
    facts.add("cost", nullptr, fmt::format("  cost         nothing is measured: {}\n\n", why));
  };
  if (scenario.case_spec) {
    not_measured("a [case] runs its solvers without a loop");
    return ExitCode::pass;
  }
  CostOptions options;
  options.interrupted = &interrupted;
  CountProgress progress(isatty(STDERR_FILENO));
  options.progress = [&, done = 0](const std::string& part) mutable { progress.update(++done, 0, part); };
  CostReport report;
  try {
    report = measure_costs(scenario, options);
  } catch (const std::runtime_error& stop) {  // of the solver or of the run
    not_measured(fmt::format("the run stops: {}", stop.what()));
    return scenario.expect_stop ? ExitCode::pass : ExitCode::run_failed;
  }
  facts.add("cost", Json::parse(cost_json(report)), cost_text(report) + "\n");
  if (interrupted) return ExitCode::interrupted;
  if (report.same_bits()) return ExitCode::pass;
  spdlog::error("{}: error: a part that must not change a bit changes some (\"differ\" above); please report it",
                scenario.file);
  return ExitCode::not_reproducible;
}

/// One scenario; what is wrong with it goes into the facts and into `errors`.
ExitCode check_one(const std::string& file, const ReadOptions& options, bool cost, const std::atomic<bool>& interrupted,
                   Facts& facts, std::vector<Diagnostic>& errors) {
  const ReadResult read = read_scenario(file, options);
  if (read && !read->timing.trace_damage.empty()) {
    spdlog::warn("{}: {}", read->timing.trace_file, read->timing.trace_damage);
    facts.add("damage", read->timing.trace_damage, "");
  }
  errors = read ? check_expectations(*read) : read.error();
  if (errors.empty()) errors = missing_in_build(*read);
  if (errors.empty() && read->sweep) errors = check_sweep(file, options);
  if (errors.empty()) {
    try {
      errors = explain(*read, facts);
      // As of a run: what cannot be judged is the scenario's mistake, not the program's failure.
      ExitCode code = !errors.empty()                     ? ExitCode::usage
                      : facts.json()["verdict"] == "open" ? ExitCode::pass
                                                          : ExitCode::expectation_failed;
      if (cost) code = worse(code, explain_cost(*read, interrupted, facts));
      return code;
    } catch (const SolverError& error) {
      errors = {refusal_of(*read, error)};
    } catch (const RunFailure& failure) {  // of a map that the program registers
      errors = {{file, 0, 0, std::string(failure.what()) + "; " + failure.remedy}};
    }
  }
  facts.add("file", file, "");
  facts.add("verdict", "refused", "");
  facts.add("errors", json_of(errors), "");
  return ExitCode::usage;
}

ExitCode check_scenarios(const CheckArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  const std::optional<std::vector<std::string>> files = scenario_files(arguments.paths);
  if (!files) return ExitCode::usage;
  ExitCode code = ExitCode::pass;
  Json documents = Json::array();
  for (const std::string& file : *files) {
    if (interrupted) return ExitCode::interrupted;
    Facts facts;
    std::vector<Diagnostic> errors;
    const ReadOptions options{arguments.set, std::nullopt, registry};
    code = worse(code, check_one(file, options, arguments.cost, interrupted, facts, errors));
    print(errors);
    if (arguments.json)
      documents.push_back(facts.json());
    else
      fmt::print("{}", facts.text());
    std::fflush(stdout);
  }
  const bool one_was_named = files->size() == 1 && files->front() == arguments.paths.front();
  if (arguments.json) fmt::print("{}\n", (one_was_named ? documents.front() : documents).dump(2));
  return code;
}

}  // namespace

void add_check(Commands& commands) {
  auto [command, arguments] =
      commands.add<CheckArguments>("check", "read and explain scenarios, run nothing", check_scenarios);
  command.operands("scenario", arguments.paths, "scenario files, or folders of them");
  command.repeated("--set", arguments.set, "path=value, overrides the file");
  command.flag("--cost", arguments.cost,
               "also measure what each part of the run costs here, kept or left out, in pairs with it and without it");
  command.flag("--json", arguments.json, "print the facts as JSON; for a folder or several files a list of them");
}

}  // namespace evenstep::app

namespace evenstep {

Explained explain_scenario(const std::string& file, const ReadOptions& options) {
  app::Facts facts;
  Explained explained;
  const std::atomic<bool> interrupted{false};
  explained.exit = app::check_one(file, options, false, interrupted, facts, explained.errors);
  explained.json = facts.json().dump();
  explained.damage = facts.json().value("damage", "");
  return explained;
}

}  // namespace evenstep
