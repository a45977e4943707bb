#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "commands.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/campaigns/sweep.h"
#include "evenstep/harness/foresee.h"
#include "evenstep/harness/rendering.h"
#include "evenstep/harness/saturation_forecast.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/underrun_rate.h"
#include "evenstep/reports/writers.h"
#include "evenstep/sim/solver.h"
#include "evenstep/sim/stability.h"

namespace evenstep::app {
namespace {

double ms(Duration d) { return static_cast<double>(d.ns) * 1e-6; }

void explain_solver(const Scenario& scenario) {
  const Rate rate = scenario.scene.step_rate;
  fmt::print("  step size    1 / ({}/{} Hz) = {:.6g} ms of simulation time\n", rate.num, rate.den, 1e3 * period_s(rate));
  fmt::print("  scene        {}\n", describe(scenario.scene));
  fmt::print("{}", stability_lines(scenario));
}

void explain_case(const CaseSpec& spec) {
  std::vector<std::string> methods, solvers;
  for (const Method method : spec.methods) methods.emplace_back(name_of(method));
  for (const SolverKind solver : spec.solvers) solvers.emplace_back(name_of(solver));
  fmt::print("  case         {}, {} values from {} to {}\n", spec.kind, spec.values.size(), spec.values.front(),
             spec.values.back());
  fmt::print("  methods      {}\n  solvers      {}\n", fmt::join(methods, ", "), fmt::join(solvers, ", "));
}

void explain_sweep(const SweepSpec& sweep) {
  std::size_t points = sweep.seeds.size();
  std::string of = fmt::format("{} seed{}", points, points == 1 ? "" : "s");
  for (const SweepAxis& axis : sweep.grid) {
    points *= axis.values.size();
    of += fmt::format(" x {} of {}", axis.values.size(), axis.path);
  }
  fmt::print("  sweep        {} points: {}\n", points, of);
}

void explain_adaptation(const Scenario& scenario, const StrategyPlan& plan) {
  const AdaptiveLatencyOptions& adapt = scenario.remap.adapt;
  const AdaptationForecast forecast = forecast_adaptation(scenario, plan);
  fmt::print(
      "               adaptive: from {:.6f} ms, {:.6f} to {:.6f} ms, {:.6g} ms above all needs of {:.6g} s, slew "
      "{:.6g} %\n",
      ms(adapt.start), ms(adapt.least), ms(adapt.most), ms(adapt.margin), seconds(adapt.window),
      static_cast<double>(adapt.slew_ppm) * 1e-4);
  fmt::print("               mean {:.6f} ms, largest {:.6f} ms, grows {} times on this timing\n", 1e3 * forecast.mean_s,
             ms(forecast.largest), forecast.growths);
}

/// Prints what will be saturated, and returns the expectations that cannot be judged for it.
std::vector<Diagnostic> explain_saturation(const Scenario& scenario, const std::vector<StrategyPlan>& plans) {
  const std::vector<ForetoldSaturation> foretold = foretell_saturation(scenario);
  for (const ForetoldSaturation& one : foretold)
    fmt::print("  saturation   {}{}\n", text(one), one.expected ? " (expected)" : "");
  return foretold_errors(scenario, plans, foretold);
}

/// What must go wrong in a run, as text; empty if nothing is known.
std::string foreseen(const Scenario& scenario, const std::vector<StrategyPlan>& plans) {
  if (scenario.expect_stop) return {};
  const auto* tissue = std::get_if<TissueScene>(&scenario.scene.body);
  if (tissue && !scenario.scene.allow_unstable) {
    const Rate rate = scenario.scene.step_rate;
    const int least = auto_substeps(*tissue, rate);
    const int substeps = tissue->substeps > 0 ? tissue->substeps : least;
    if (period_s(rate) / substeps > step_limit(*tissue).step_s)
      return fmt::format(
          "must fail: the step is above its limit, and the run will not start; substeps = \"auto\" or at least {}\n", least);
  }
  const std::vector<ExpectationResult> failures = foresee_failures(scenario, plans);
  return failures.empty() ? "" : "must fail:\n" + verdict_table(failures, false);
}

/// Explains the scenario. False if it must fail.
bool explain(const Scenario& scenario) {
  fmt::print("{}\n  {}\n", scenario.file, scenario.name);
  if (!scenario.because.empty()) fmt::print("  because      {}\n", scenario.because);
  if (scenario.case_spec) {
    explain_case(*scenario.case_spec);
    fmt::print("  expectations {}\n\n", scenario.expectations.size());
    return true;
  }
  fmt::print("  run          {:.6g} s, judged from {:.6g} s, seed {}\n", seconds(scenario.run_duration),
             seconds(scenario.warmup), scenario.seed);
  const NominalUnits& nominal = scenario.nominal;
  fmt::print(
      "  timing       segment {:.6f} ms, visualization {:.6f} ms, step {:.6f} ms, slot {:.6f} ms{}\n", ms(nominal.segment),
      ms(nominal.visualization), ms(nominal.step_run_time), ms(nominal.slot),
      scenario.timing.trace.empty() ? "" : fmt::format(" (means of {} recorded segments)", scenario.timing.trace.size()));
  explain_solver(scenario);
  for (const DeviceSpec& device : scenario.devices) {
    fmt::print("  device       {}: {}/{} Hz, phase {:.6g} ms, {} emission\n", device.name, device.rate.num, device.rate.den,
               ms(device.phase), device.emission == Emission::linear ? "linear" : "hold");
    if (!device.hand) continue;
    fmt::print("               a hand of {:.6g} kg, {:.6g} N s/m, {:.6g} N/m that feels the force {:.6g} ms later\n",
               device.hand->total_mass_kg(), device.hand->total_damping_N_s_per_m(), device.hand->total_stiffness_N_per_m(),
               ms(device.force_delay));
  }
  const std::vector<StrategyPlan> plans = plan(scenario);
  for (const StrategyPlan& plan : plans) {
    fmt::print("  {:<12} lead {:.6f} ms, latency {:.6f} ms, rings {} samples, {} forces\n", name_of(plan.kind),
               ms(plan.lead), ms(plan.latency), plan.interaction_capacity, plan.force_capacity);
    if (plan.adapts) explain_adaptation(scenario, plan);
    for (const DeviceSpec& device : scenario.devices)
      fmt::print("               {}: {}\n", device.name, rendering_line(scenario, plan, device));
    if (plan.sizing.steps.empty()) continue;
    const auto& [steps, any, here] = plan.sizing;
    fmt::print(
        "               least: any device phase {:.6f} ms (lead {:.6f}, step {}), this phase {:.6f} ms (lead {:.6f}, step "
        "{})\n",
        ms(any.latency), ms(any.lead), any.latency_culprit, ms(here.latency), ms(here.lead), here.latency_culprit);
    fmt::print("               with these: {} samples missing, {} forces late\n", plan.predicted_interaction_underruns,
               plan.predicted_late_forces);
  }
  const std::vector<Diagnostic> saturated = explain_saturation(scenario, plans);
  if (scenario.sweep) explain_sweep(*scenario.sweep);
  fmt::print("  expectations {}\n", scenario.expectations.size());
  for (const std::string& line : explain_rates(scenario)) fmt::print("               {}\n", line);
  const std::string failures = foreseen(scenario, plans);
  fmt::print("{}\n", failures);
  print(saturated);
  return failures.empty() && saturated.empty();
}

}  // namespace

std::string stability_lines(const Scenario& scenario) {
  const auto* tissue = std::get_if<TissueScene>(&scenario.scene.body);
  if (tissue == nullptr) return "";
  const Rate rate = scenario.scene.step_rate;
  const StepLimit limit = step_limit(*tissue);
  const int substeps = tissue->substeps > 0 ? tissue->substeps : auto_substeps(*tissue, rate);
  const double substep_s = period_s(rate) / substeps;
  const std::string method = fmt::format("  method       {}, {} substep{} of {:.4g} ms\n", name_of(tissue->method), substeps,
                                         substeps == 1 ? "" : "s", 1e3 * substep_s);
  if (!std::isfinite(limit.step_s)) return method + "  stability    implicit: stable at any step\n";
  const std::string limits = fmt::format(
      "  stability    dt_max {:.4g} ms in every configuration ({:.4g} ms at rest, not safe), k_max {:.4g} N/m at this "
      "substep\n               {}\n",
      1e3 * limit.step_s, 1e3 * limit.rest_state_step_s,
      tissue->stiffness_N_per_m * stiffness_margin(tissue->method, limit, substep_s), what_sets(*tissue, limit));
  if (substep_s <= limit.step_s) return method + limits;
  return method + limits +
         fmt::format("  UNSTABLE     the substep is {:.4g} times dt_max: {}\n", substep_s / limit.step_s,
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
};

ExitCode check_scenarios(const CheckArguments& arguments, const std::atomic<bool>&) {
  const std::optional<std::vector<std::string>> files = scenario_files(arguments.paths);
  if (!files) return ExitCode::usage;
  ExitCode code = ExitCode::pass;
  for (const std::string& file : *files) {
    const ReadResult read = read_scenario(file, {arguments.set, std::nullopt});
    std::vector<Diagnostic> errors = read ? check_expectations(*read) : read.error();
    if (errors.empty() && read->sweep) errors = check_sweep(file, arguments.set);
    if (errors.empty()) {
      try {
        if (!explain(*read)) code = worse(code, ExitCode::expectation_failed);
        continue;
      } catch (const SolverError& error) {
        errors.push_back({file, 0, 0, std::string(error.what()) + "; " + error.remedy()});
      }
    }
    print(errors);
    code = worse(code, ExitCode::usage);
  }
  return code;
}

}  // namespace

void add_check(Commands& commands) {
  auto [command, arguments] =
      commands.add<CheckArguments>("check", "read and explain scenarios, run nothing", check_scenarios);
  command.operands("scenario", arguments.paths, "scenario files, or folders of them");
  command.repeated("--set", arguments.set, "path=value, overrides the file");
}

}  // namespace evenstep::app
