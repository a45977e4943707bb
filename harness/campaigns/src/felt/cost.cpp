#include "cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/sim/stability.h"
#include "src/study/machine.h"

namespace evenstep::internal {
namespace {

std::vector<StudyStep> default_steps(const Scenario& scenario, Method method) {
  TissueScene tissue = std::get<TissueScene>(scenario.scene.body);
  tissue.method = method;
  const int longest = auto_substeps(tissue, scenario.scene.step_rate);
  return {{longest, 1}, {std::min(2 * longest, kMaxSubsteps), 1}, {std::min(4 * longest, kMaxSubsteps), 1}};
}

/// CPU time of a step of the solver. The hands are in motion meanwhile, so that iterations have something to solve.
double step_cost_s(Solver& solver, const Scenario& scenario, Rate rate) {
  constexpr double kEnough_s = 0.03;
  constexpr int kFew = 4, kMany = 64;
  RealTime begin = kNever;
  for (const DeviceSpec& device : scenario.devices) begin = std::min(begin, device.motion.begin);
  std::array<glm::dvec3, kMaxTools> positions_m{};
  double began_s = 0;
  for (std::int64_t n = -1;; ++n) {
    if (n == 0) began_s = process_cpu_seconds();  // the first step, which gives the tools their origin, is not timed
    for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool)
      positions_m[tool] = position_m(scenario.devices[tool].motion, tick_time(rate, n + 1, begin));
    solver.step({positions_m.data(), scenario.devices.size()});
    const double spent_s = process_cpu_seconds() - began_s;
    if (n >= kMany || (n >= kFew && spent_s > kEnough_s)) return spent_s / static_cast<double>(n + 1);
  }
}

/// Rounded to two digits.
std::string about(double cpu_s) {
  if (cpu_s < 0.1) return "less than 0.1 CPU s";
  return cpu_s >= 100 ? fmt::format("about {:.0f} CPU s", std::round(cpu_s / 10) * 10)
                      : fmt::format("about {:.2g} CPU s", cpu_s);
}

std::string step_text(double seconds) {
  return seconds >= 1e-3 ? fmt::format("{:.4g} ms", seconds * 1e3) : fmt::format("{:.4g} us", seconds * 1e6);
}

std::string name_of(const Scenario& scenario, const StudyRun& run) {
  const std::string solver = evenstep::name_of(run.solver);
  if (const auto* foreign = std::get_if<ForeignScene>(&scenario.scene.body))
    return fmt::format("{:<29}{:>9}", foreign->name, step_text(period_s(scenario.scene.step_rate) / run.step.substeps));
  if (!std::holds_alternative<TissueScene>(scenario.scene.body)) return fmt::format("{:<18}{:<11}", "no method", solver);
  return fmt::format("{:<18}{:<11}{:>9}{}", evenstep::name_of(run.method), solver,
                     step_text(period_s(scenario.scene.step_rate) / run.step.substeps),
                     run.iterations > 0 ? fmt::format(", {} iterations", run.iterations) : "");
}

/// CPU time of a cell: once through the run for every lead or repeat, and twice for every strategy; empty, with the reason,
/// where the solver refuses.
std::optional<double> cell_cost_s(const Scenario& scenario, const StudyRun& run, const FeltWork& work, double steps,
                                  std::string& reason) {
  try {
    const auto solver = make_study_solver(scenario, run, false);
    const double once_s = steps * step_cost_s(*solver, scenario, scenario.scene.step_rate);
    const auto leads = static_cast<double>(work.leads), repeats = static_cast<double>(scenario.study.repeats);
    const double within = once_s > 0 ? std::ceil(kMostCell_s / once_s) : repeats;
    const double even = std::max(leads, std::min(repeats, within)) * std::max(once_s, kLeastTimed_s);
    return even + 2 * static_cast<double>(work.strategies) * once_s;
  } catch (const SolverError& error) {
    reason = error.what();
    return std::nullopt;
  }
}

}  // namespace

std::vector<StudyRun> felt_cells(const Scenario& scenario) {
  const StudySpec& study = scenario.study;
  std::vector<StudyRun> cells;
  if (!std::holds_alternative<TissueScene>(scenario.scene.body)) {
    // Only the program knows how its solver integrates, but it has steps, and they can be cut.
    const bool has_steps = std::holds_alternative<ForeignScene>(scenario.scene.body);
    const std::vector<StudyStep> steps = !has_steps            ? std::vector<StudyStep>{{1, 1}}
                                         : study.steps.empty() ? std::vector<StudyStep>{{1, 1}, {2, 1}, {4, 1}}
                                                               : study.steps;
    for (const StudyStep& step : steps) cells.push_back({SolverKind::cpu_double, Method::symplectic_euler, 0, step});
    return cells;
  }
  for (const SolverKind solver : study.solvers) {
    for (const Method method : study.methods) {
      const std::vector<StudyStep> steps = study.steps.empty() ? default_steps(scenario, method) : study.steps;
      const bool ladder = iterates(method) && !study.iterations.empty();
      for (const int iterations : ladder ? study.iterations : std::vector<int>{0}) {
        for (const StudyStep& step : steps) cells.push_back({solver, method, iterations, step});
      }
    }
  }
  return cells;
}

int finest_substeps(const std::vector<StudyRun>& cells) {
  int finest = 1;
  for (const StudyRun& run : cells) finest = std::max(finest, iterates(run.method) ? 1 : run.step.substeps);
  return finest;
}

std::vector<std::string> cost_lines(const Scenario& scenario, const std::vector<StudyRun>& cells, const ReferencePlan& plan,
                                    const FeltWork& work) {
  std::vector<std::string> lines;
  const double end_s = seconds(plan.until);
  double total_s = 0;
  if (!work.stored_file.empty()) {
    lines.push_back(fmt::format("reference   stored: {}", work.stored_file));
  } else {
    // Runs on 1, 2 and 4 parts of a step; without a method just one.
    const auto solver = make_reference_solver(scenario, plan, 1);
    total_s = (plan.order > 0 ? 7 : 1) * end_s / period_s(plan.rate) * step_cost_s(*solver, scenario, plan.rate);
    lines.push_back(fmt::format("reference   {}", about(total_s)));
  }
  for (const StudyRun& run : cells) {
    std::string reason;
    const std::optional<double> cost_s =
        cell_cost_s(scenario, run, work, end_s / period_s(scenario.scene.step_rate), reason);
    total_s += cost_s.value_or(0);
    lines.push_back(fmt::format("point       {}  {}", name_of(scenario, run),
                                cost_s ? about(*cost_s) + " with every strategy" : reason));
  }
  lines.push_back(fmt::format("all         {} on this machine, as a few steps of each suggest", about(total_s)));
  return lines;
}

}  // namespace evenstep::internal
