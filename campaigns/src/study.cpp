#include "evenstep/campaigns/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/version.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/sim/stability.h"
#include "study_machine.h"
#include "study_trace.h"

namespace evenstep {
namespace {

using internal::cost_of;
using internal::kLeastTimed_s;
using internal::kMostCell_s;
using internal::StudyPlan;
using internal::StudyRun;
using internal::StudyTrace;

constexpr double kDivergedTimes = 10;  // a cell has diverged if its error is this many times the reference's motion

double step_limit_s(const Scenario& scenario, Method method) {
  TissueScene tissue = std::get<TissueScene>(scenario.scene.body);
  tissue.method = method;
  return step_limit(tissue).step_s;
}

/// Halvings (or doublings) of the scene's step. Explicit: from the first one above the limit to the fourth below it.
/// Implicit: from the scene's step to its eighth.
std::vector<StudyStep> default_steps(const Scenario& scenario, Method method) {
  const Rate rate = scenario.scene.step_rate;
  const std::int64_t most =
      std::max<std::int64_t>(1, floor_mul_div(scenario.study.duration.ns, rate.num, rate.den * 8'000'000'000));
  if (iterates(method)) return {{1, 1}, {2, 1}, {4, 1}, {8, 1}};
  const double limit_s = step_limit_s(scenario, method), step_s = period_s(rate);
  std::vector<StudyStep> steps;
  StudyStep step;
  while (step_s * step.steps < limit_s && step.steps * 2 <= most) step.steps *= 2;
  while (step_s / step.substeps / 2 > limit_s && step.substeps < kMaxSubsteps / 64) step.substeps *= 2;
  for (int below = 0; below < 4;) {
    steps.push_back(step);
    below += step_s * step.steps / step.substeps < limit_s;
    if (step.steps > 1)
      step.steps /= 2;
    else
      step.substeps *= 2;
  }
  return steps;
}

std::vector<StudyRun> runs_of(const Scenario& scenario) {
  const StudySpec& study = scenario.study;
  std::vector<StudyRun> runs;
  for (const SolverKind solver : study.solvers) {
    for (const Method method : study.methods) {
      const std::vector<StudyStep> steps = study.steps.empty() ? default_steps(scenario, method) : study.steps;
      const bool ladder = iterates(method) && !study.iterations.empty();
      for (const int iterations : ladder ? study.iterations : std::vector<int>{0}) {
        for (const StudyStep& step : steps) runs.push_back({solver, method, iterations, step});
      }
    }
  }
  return runs;
}

StudyCell::State state_of(SolverFault fault) {
  return fault == SolverFault::unavailable ? StudyCell::State::unavailable : StudyCell::State::refused;
}

class Study {
 public:
  Study(const Scenario& scenario, const StudyControl& control)
      : scenario_(scenario), control_(control), runs_(runs_of(scenario)), plan_(scenario, steps_of(runs_)) {
    if (plan_.samples < 1)
      throw RunFailure("limit", "the study's steps share no instant within its duration", "a longer [study] duration");
  }

  StudyRecord run() {
    describe();
    int finest = 1;
    for (const StudyRun& run : runs_) finest = std::max(finest, iterates(run.method) ? 1 : run.step.substeps);
    const internal::StudyReferenceRun reference = internal::solve_reference(scenario_, plan_, finest);
    record_.reference = reference.info;
    for (std::size_t i = 0; i < runs_.size() && !interrupted(); ++i) {
      report(static_cast<double>(i) / static_cast<double>(runs_.size()));
      StudyCell judged = cell(runs_[i], reference);
      if (judged.state == StudyCell::State::measured && judged.repeats == 0) break;  // interrupted before its cost was known
      record_.cells.push_back(std::move(judged));
      put_order(i);
    }
    report(1);
    record_.interrupted = record_.cells.size() < runs_.size();
    return std::move(record_);
  }

 private:
  static std::vector<StudyStep> steps_of(const std::vector<StudyRun>& runs) {
    std::vector<StudyStep> steps;
    for (const StudyRun& run : runs) steps.push_back(run.step);
    return steps;
  }
  bool interrupted() const { return control_.interrupted && *control_.interrupted; }
  void report(double fraction) const {
    if (control_.progress) control_.progress(fraction);
  }

  void describe() {
    record_.scenario = scenario_.name;
    record_.file = scenario_.file;
    record_.version = kVersion;
    const internal::StudyMachine machine = internal::study_machine();
    record_.machine = machine.name;
    record_.compiler = machine.compiler;
    record_.cpus = machine.cpus;
    record_.load = machine.load;
    record_.repeats = scenario_.study.repeats;
    const auto& tissue = std::get<TissueScene>(scenario_.scene.body);
    record_.particles = tissue.particle_count;
    record_.stiffness_N_per_m = tissue.stiffness_N_per_m;
    record_.step_limit_s = step_limit_s(scenario_, Method::symplectic_euler);
    record_.step_s = period_s(scenario_.scene.step_rate);
    record_.rest_s = plan_.rest_s(scenario_);
    record_.duration_s = plan_.duration_s(scenario_);
    record_.samples = plan_.samples;
  }

  StudyCell cell(const StudyRun& run, const internal::StudyReferenceRun& reference) {
    StudyCell cell{.solver = name_of(run.solver),
                   .method = name_of(run.method),
                   .iterations = run.iterations,
                   .substep_s = record_.step_s * run.step.steps / run.step.substeps,
                   .substeps = run.step.substeps};
    try {
      judge(run, reference, cell);
      if (cell.state == StudyCell::State::measured) time(run, cell);
    } catch (const SolverError& error) {
      cell.state = state_of(error.fault());
      cell.reason = error.fault() == SolverFault::unstable_step
                        ? fmt::format("above the limit of {:.4g} ms", 1e3 * step_limit_s(scenario_, run.method))
                        : error.what();
    }
    return cell;
  }

  void judge(const StudyRun& run, const internal::StudyReferenceRun& reference, StudyCell& cell) {
    const auto solver = internal::make_study_solver(scenario_, run, true);
    cell.iterations = solver->info().iterations;
    if (run.solver == SolverKind::opencl) record_.opencl_device = solver->info().device;
    const StudyTrace trace = internal::trace_of(*solver, scenario_, plan_, run.step);
    if (trace.first_bad_sample >= 0) {
      cell.state = StudyCell::State::diverged;
      cell.reason =
          fmt::format("not finite at {:.4g} ms", record_.duration_s * 1e3 * static_cast<double>(trace.first_bad_sample) /
                                                     static_cast<double>(plan_.samples));
      return;
    }
    cell.error = internal::error_of(trace, reference.trace, record_.reference.scale);
    const double motion_m = record_.reference.scale[StudyQuantity::position];
    if (motion_m == 0 || cell.error[StudyQuantity::position] <= kDivergedTimes * motion_m) return;
    cell.state = StudyCell::State::diverged;
    cell.reason = fmt::format("the error is {:.3g} times the motion", cell.error[StudyQuantity::position] / motion_m);
  }

  /// Measures the time without the energy, which only the comparison needs.
  void time(const StudyRun& run, StudyCell& cell) {
    const auto solver = internal::make_study_solver(scenario_, run, false);
    std::vector<double> cpu_s, wall_s;
    const double simulated_s = record_.rest_s + record_.duration_s, began_s = process_cpu_seconds();
    while (static_cast<int>(cpu_s.size()) < record_.repeats && !interrupted()) {
      double cpu = 0, wall = 0, rounds = 0;
      for (; rounds == 0 || (cpu < kLeastTimed_s && wall < kLeastTimed_s); ++rounds) {
        solver->reset();
        const double cpu_before = process_cpu_seconds(), wall_before = monotonic_seconds();
        internal::step_through(*solver, scenario_, plan_, run.step);
        cpu += process_cpu_seconds() - cpu_before;
        wall += monotonic_seconds() - wall_before;
      }
      cpu_s.push_back(cpu / rounds / simulated_s);
      wall_s.push_back(wall / rounds / simulated_s);
      if (process_cpu_seconds() - began_s > kMostCell_s) break;
    }
    cell.repeats = static_cast<int>(cpu_s.size());
    if (cpu_s.empty()) return;
    cell.cpu = cost_of(cpu_s);
    cell.wall = cost_of(wall_s);
  }

  void put_order(std::size_t i) {
    StudyCell& fine = record_.cells[i];
    if (i == 0 || fine.state != StudyCell::State::measured) return;
    const StudyCell& coarse = record_.cells[i - 1];
    if (coarse.state != StudyCell::State::measured || coarse.solver != fine.solver || coarse.method != fine.method ||
        coarse.iterations != fine.iterations || coarse.substep_s <= fine.substep_s)
      return;
    const StudyValues& estimate = record_.reference.estimate;
    for (const StudyQuantity q : kStudyQuantities) {
      if (fine.at_floor(q, estimate) || coarse.at_floor(q, estimate)) continue;
      fine.order[q] = std::log(coarse.error[q] / fine.error[q]) / std::log(coarse.substep_s / fine.substep_s);
    }
  }

  const Scenario& scenario_;
  const StudyControl& control_;
  std::vector<StudyRun> runs_;
  StudyPlan plan_;
  StudyRecord record_;
};

}  // namespace

StudyRecord run_study(const Scenario& scenario, const StudyControl& control) {
  if (!std::holds_alternative<TissueScene>(scenario.scene.body))
    throw std::invalid_argument("only a tissue has steps to compare; a study needs kind = \"tissue\"");
  try {
    return Study(scenario, control).run();
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

}  // namespace evenstep
