#include "evenstep/campaigns/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cells.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/version.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/sim/stability.h"
#include "machine.h"

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

std::vector<StudyStep> steps_of(const std::vector<StudyRun>& runs) {
  std::vector<StudyStep> steps;
  for (const StudyRun& run : runs) steps.push_back(run.step);
  return steps;
}

}  // namespace

namespace internal {

StudyCells::StudyCells(const Scenario& scenario, const StudyControl& control)
    : scenario_(scenario), control_(control), runs_(runs_of(scenario)), plan_(scenario, steps_of(runs_)) {
  if (plan_.samples < 1)
    throw RunFailure("limit", "the study's steps share no instant within its duration", "a longer [study] duration");
}

StudyRecord StudyCells::description() const {
  StudyRecord record;
  record.scenario = scenario_.name;
  record.file = scenario_.file;
  record.version = kVersion;
  const StudyMachine machine = study_machine();
  record.machine = machine.name;
  record.compiler = machine.compiler;
  record.cpus = machine.cpus;
  record.load = machine.load;
  record.repeats = scenario_.study.repeats;
  const auto& tissue = std::get<TissueScene>(scenario_.scene.body);
  record.particles = tissue.particle_count;
  record.stiffness_N_per_m = tissue.stiffness_N_per_m;
  record.step_limit_s = step_limit_s(scenario_, Method::symplectic_euler);
  record.step_s = step_s();
  record.rest_s = plan_.rest_s(scenario_);
  record.duration_s = plan_.duration_s(scenario_);
  record.samples = plan_.samples;
  return record;
}

const StudyReferenceRun& StudyCells::reference() {
  if (reference_) return *reference_;
  int finest = 1;
  for (const StudyRun& run : runs_) finest = std::max(finest, iterates(run.method) ? 1 : run.step.substeps);
  return reference_.emplace(solve_reference(scenario_, plan_, finest, control_.interrupted));
}

StudyCell StudyCells::cell(std::size_t i) {
  const StudyRun& run = runs_[i];
  reference();
  StudyCell cell{.solver = name_of(run.solver),
                 .method = name_of(run.method),
                 .iterations = run.iterations,
                 .substep_s = step_s() * run.step.steps / run.step.substeps,
                 .substeps = run.step.substeps};
  try {
    judge(run, cell);
    if (cell.state == StudyCell::State::measured) time(run, cell);
  } catch (const SolverError& error) {
    cell.state = state_of(error.fault());
    cell.reason = error.fault() == SolverFault::unstable_step
                      ? fmt::format("above the limit of {:.4g} ms", 1e3 * step_limit_s(scenario_, run.method))
                      : error.what();
  }
  return cell;
}

void StudyCells::judge(const StudyRun& run, StudyCell& cell) {
  const auto solver = make_study_solver(scenario_, run, true);
  cell.iterations = solver->info().iterations;
  if (run.solver == SolverKind::opencl) opencl_device_ = solver->info().device;
  const StudyTrace trace = trace_of(*solver, scenario_, plan_, run.step, control_.interrupted);
  if (trace.first_bad_sample >= 0) {
    cell.state = StudyCell::State::diverged;
    cell.reason = fmt::format("not finite at {:.4g} ms", plan_.duration_s(scenario_) * 1e3 *
                                                             static_cast<double>(trace.first_bad_sample) /
                                                             static_cast<double>(plan_.samples));
    return;
  }
  cell.error = error_of(trace, reference().trace, reference().info.scale);
  const double motion_m = reference().info.scale[StudyQuantity::position];
  if (motion_m == 0 || cell.error[StudyQuantity::position] <= kDivergedTimes * motion_m) return;
  cell.state = StudyCell::State::diverged;
  cell.reason = fmt::format("the error is {:.3g} times the motion", cell.error[StudyQuantity::position] / motion_m);
}

/// Measures the time without the energy, which only the comparison needs.
void StudyCells::time(const StudyRun& run, StudyCell& cell) const {
  const auto solver = make_study_solver(scenario_, run, false);
  std::vector<double> cpu_s, wall_s;
  const double simulated_s = plan_.rest_s(scenario_) + plan_.duration_s(scenario_), began_s = process_cpu_seconds();
  while (static_cast<int>(cpu_s.size()) < scenario_.study.repeats) {
    double cpu = 0, wall = 0, rounds = 0;
    for (; rounds == 0 || (cpu < kLeastTimed_s && wall < kLeastTimed_s); ++rounds) {
      solver->reset();
      const double cpu_before = process_cpu_seconds(), wall_before = monotonic_seconds();
      step_through(*solver, scenario_, plan_, run.step, control_.interrupted);
      cpu += process_cpu_seconds() - cpu_before;
      wall += monotonic_seconds() - wall_before;
    }
    cpu_s.push_back(cpu / rounds / simulated_s);
    wall_s.push_back(wall / rounds / simulated_s);
    if (process_cpu_seconds() - began_s > kMostCell_s) break;
  }
  cell.repeats = static_cast<int>(cpu_s.size());
  cell.cpu = cost_of(cpu_s);
  cell.wall = cost_of(wall_s);
}

void put_orders(StudyRecord& record) {
  for (std::size_t i = 1; i < record.cells.size(); ++i) {
    StudyCell& fine = record.cells[i];
    const StudyCell& coarse = record.cells[i - 1];
    if (fine.state != StudyCell::State::measured || coarse.state != StudyCell::State::measured ||
        coarse.solver != fine.solver || coarse.method != fine.method || coarse.iterations != fine.iterations ||
        coarse.substep_s <= fine.substep_s)
      continue;
    const StudyValues& estimate = record.reference.estimate;
    for (const StudyQuantity q : kStudyQuantities) {
      if (fine.at_floor(q, estimate) || coarse.at_floor(q, estimate)) continue;
      fine.order[q] = std::log(coarse.error[q] / fine.error[q]) / std::log(coarse.substep_s / fine.substep_s);
    }
  }
}

}  // namespace internal

namespace {

StudyRecord all_cells(const Scenario& scenario, const StudyControl& control) {
  internal::StudyCells cells(scenario, control);
  StudyRecord record = cells.description();
  const auto report = [&](double fraction) {
    if (control.progress) control.progress(fraction);
  };
  try {
    record.reference = cells.reference().info;
    for (std::size_t i = 0; i < cells.count(); ++i) {
      report(static_cast<double>(i) / static_cast<double>(cells.count()));
      record.cells.push_back(cells.cell(i));
    }
  } catch (const internal::StudyInterrupted&) {
    record.interrupted = true;
  }
  report(1);
  record.opencl_device = cells.opencl_device();
  internal::put_orders(record);
  return record;
}

}  // namespace

StudyRecord run_study(const Scenario& scenario, const StudyControl& control) {
  if (!std::holds_alternative<TissueScene>(scenario.scene.body))
    throw std::invalid_argument("only a tissue has steps to compare; a study needs kind = \"tissue\"");
  try {
    return all_cells(scenario, control);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

}  // namespace evenstep
