#include "evenstep/campaigns/felt_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <stdexcept>

#include "cells.h"
#include "cost.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/scheduler/parallel_for.h"
#include "evenstep/sim/stability.h"
#include "reference.h"
#include "runs.h"
#include "src/study/foreign_substeps.h"
#include "src/study/machine.h"
#include "src/study/trace.h"

namespace evenstep {
namespace {

using internal::DeviceModel;
using internal::EvenForces;
using internal::FeltTicks;
using internal::kLeastTimed_s;
using internal::kMostCell_s;
using internal::StudyRun;

constexpr double kDivergedForces = 10;  // a point has diverged if its error is this many times the reference's force

/// Sums the squares of differences, and keeps the greatest.
class Sum {
 public:
  void add(const glm::dvec3& difference_N) {
    const double square = glm::dot(difference_N, difference_N);
    sum_ += square;
    most_ = std::max(most_, square);
    ++count_;
  }
  FeltError error() const {
    return {std::sqrt(sum_ / static_cast<double>(std::max<std::int64_t>(count_, 1))), std::sqrt(most_)};
  }

 private:
  double sum_ = 0, most_ = 0;
  std::int64_t count_ = 0;
};

/// The scenario with the method and step of a cell.
Scenario with_step(const Scenario& scenario, const StudyRun& run) {
  Scenario changed = scenario;
  changed.solver = run.solver;
  if (auto* tissue = std::get_if<TissueScene>(&changed.scene.body)) {
    tissue->method = run.method;
    tissue->iterations = run.iterations;
    tissue->substeps = run.step.substeps;
  } else if (const auto* foreign = std::get_if<ForeignScene>(&changed.scene.body)) {
    changed.scene.body = internal::with_substeps(*foreign, run.step.substeps);
  }
  return changed;
}

}  // namespace

namespace internal {

FeltCells::FeltCells(const Scenario& scenario, const FeltStudyControl& control)
    : scenario_(scenario), control_(control), cells_(felt_cells(scenario)) {
  run_control_.interrupted = control.interrupted;
  for (const StrategyPlan& plan : plan(scenario_)) {
    if (!traits_of(plan.kind).knows_motion) strategies_.push_back({plan, {}, {}});
  }
}

void FeltCells::prepare() {
  if (prepared_) return;
  prepared_ = true;
  take_reference();
  for (FeltStrategy& judged : strategies_) {
    judged.ideal_age_s = mean_ages_s(scenario_, judged.plan, DeviceModel::ideal, run_control_);
    judged.age_s = mean_ages_s(scenario_, judged.plan, DeviceModel::scenario, run_control_);
  }
}

FeltStudyRecord FeltCells::description() const {
  FeltStudyRecord record;
  const StudyMachine machine = study_machine();
  record.scenario = scenario_.name;
  record.file = scenario_.file;
  record.version = kVersion;
  record.machine = machine.name;
  record.compiler = machine.compiler;
  record.cpus = machine.cpus;
  record.load = machine.load;
  record.seed = scenario_.seed;
  record.scene = evenstep::describe(scenario_.scene);
  const JudgedSpan span = judged_span(scenario_);
  record.judged_from_s = seconds(span.from);
  record.judged_to_s = seconds(span.end);
  record.run_to_s = seconds(scenario_.run_duration);
  record.step_s = step_s();
  record.subject = subject_of(scenario_);
  return record;
}

void FeltCells::announce(const std::string& line) const {
  if (control_.announce) control_.announce(line);
}

/// Says what everything will cost, and reads the reference or computes it.
void FeltCells::take_reference() {
  const ReferencePlan plan = plan_reference(scenario_, finest_substeps(cells_));
  const bool kept = plan.order > 0 && !control_.cache_folder.empty();  // that of a scene without steps costs nothing
  const std::string key = kept ? reference_key(scenario_, plan) : "";
  const std::string file = kept ? reference_file(control_.cache_folder, key) : "";
  std::string objection;
  const bool stored = kept && read_reference(file, key, reference_, objection);
  if (!objection.empty())
    announce(fmt::format("the stored reference {} is not used: {}; it is computed again", file, objection));
  for (const std::string& line :
       cost_lines(scenario_, cells_, plan, {strategies_.size(), leads().size(), stored ? file : ""}))
    announce(line);
  if (!stored) {
    reference_ = solve_felt_reference(scenario_, plan, run_control_);
    if (kept && !interrupted()) {
      const std::string error = write_reference(file, key, reference_);
      if (!error.empty()) announce(fmt::format("the reference could not be kept in {}: {}", file, error));
    }
  }
  reference_.info.method = plan.order > 0 ? name_of(plan.method) : "none";
  reference_.info.stored = stored;
  reference_.info.file = file;
  if (!interrupted()) put_scale();
  if (interrupted()) reference_.info = {};  // it ended early, so there is none, and no file of it
}

void FeltCells::put_scale() {
  const JudgedSpan span = judged_span(scenario_);
  Sum scale;
  for (std::size_t tool = 0; tool < scenario_.devices.size(); ++tool) {
    const DeviceSpec& device = scenario_.devices[tool];
    const RealTime first{device.phase.ns};
    for (std::int64_t k = first_tick_at_or_after(device.rate, span.from, first); !interrupted(); ++k) {
      const RealTime at = tick_time(device.rate, k, first);
      if (at >= span.end) break;
      scale.add(reference_.at_N(tool, seconds(at)));
      ++ticks_;
    }
  }
  reference_.info.scale_N = scale.error().rms_N;
}

/// The leads of the strategies, each once: the even steps with one lead serve all strategies that have it.
std::vector<Duration> FeltCells::leads() const {
  std::vector<Duration> leads;
  for (const FeltStrategy& judged : strategies_) leads.push_back(judged.plan.lead);
  std::sort(leads.begin(), leads.end());
  leads.erase(std::unique(leads.begin(), leads.end()), leads.end());
  return leads;
}

std::string FeltCells::method_of(const StudyRun& run) const {
  if (std::holds_alternative<ForeignScene>(scenario_.scene.body)) return "own";
  return std::holds_alternative<TissueScene>(scenario_.scene.body) ? name_of(run.method) : "none";
}

std::vector<FeltPoint> FeltCells::cell(std::size_t c) {
  prepare();
  const StudyRun& run = cells_[c];
  const auto* foreign = std::get_if<ForeignScene>(&scenario_.scene.body);
  FeltPoint point{.solver = foreign ? foreign->name : name_of(run.solver),
                  .method = method_of(run),
                  .iterations = run.iterations,
                  .substep_s = step_s() / run.step.substeps,
                  .substeps = run.step.substeps};
  const Scenario changed = with_step(scenario_, run);
  std::vector<FeltPoint> points;
  try {
    const std::map<std::int64_t, EvenForces> even = step_and_time(changed, run, point);
    points.assign(strategies_.size(), point);
    for (std::size_t s = 0; s < points.size(); ++s) points[s].strategy = name_of(strategies_[s].plan.kind);
    if (point.state != StudyCell::State::measured || interrupted()) return points;
    parallel_for(points.size(), 0,
                 [&](std::size_t s) { compare(changed, strategies_[s], even.at(strategies_[s].plan.lead.ns), points[s]); });
  } catch (const SolverError& error) {
    point.state = error.fault() == SolverFault::unavailable ? StudyCell::State::unavailable : StudyCell::State::refused;
    point.reason = error.what();
    points.assign(strategies_.size(), point);
    for (std::size_t s = 0; s < points.size(); ++s) points[s].strategy = name_of(strategies_[s].plan.kind);
  }
  return points;
}

/// Steps through every lead, and then goes on with the first one until there are as many repeats as asked for.
std::map<std::int64_t, EvenForces> FeltCells::step_and_time(const Scenario& changed, const StudyRun& run, FeltPoint& point) {
  const auto solver = make_study_solver(scenario_, run, false);
  point.iterations = solver->info().iterations;
  const RealTime end = judged_span(changed).end;
  std::map<std::int64_t, EvenForces> even;
  std::vector<double> cpu_s;
  const double began_s = process_cpu_seconds();
  const std::vector<Duration> all = leads();
  const auto repeats = static_cast<std::size_t>(scenario_.study.repeats);
  for (std::size_t i = 0; i < std::max(all.size(), repeats) && !interrupted(); ++i) {
    if (i >= all.size() && process_cpu_seconds() - began_s > kMostCell_s) break;
    const Duration lead = all[std::min(i, all.size() - 1)];
    double cpu = 0, simulated_s = 0;
    while (cpu < kLeastTimed_s && !interrupted()) {
      solver->reset();
      const double before = process_cpu_seconds();
      EvenForces forces = step_evenly(*solver, changed, changed.scene.step_rate, lead, end, run_control_);
      cpu += process_cpu_seconds() - before;
      simulated_s += step_s() * static_cast<double>(forces.read.size());
      if (const std::string bad = first_bad(forces); !bad.empty()) {
        point.state = StudyCell::State::diverged;
        point.reason = bad;
        return even;
      }
      even.insert_or_assign(lead.ns, std::move(forces));
    }
    if (simulated_s > 0) cpu_s.push_back(cpu / simulated_s);
  }
  point.repeats = static_cast<int>(cpu_s.size());
  if (!cpu_s.empty()) point.cpu = cost_of(cpu_s);
  return even;
}

std::string FeltCells::first_bad(const EvenForces& forces) const {
  for (std::size_t n = 0; n < forces.read.size(); ++n) {
    for (std::size_t tool = 0; tool < scenario_.devices.size(); ++tool) {
      if (!std::isfinite(glm::length(forces.force_N[n][tool])))
        return fmt::format("not finite at {:.4g} s, on even steps", seconds(forces.read[n]));
    }
  }
  return {};
}

/// The differences along the chain, tick by tick.
void FeltCells::compare(const Scenario& changed, const FeltStrategy& judged, const EvenForces& even, FeltPoint& point) {
  FeltTicks ideal, felt;
  try {
    ideal = felt_ticks(changed, judged.plan, DeviceModel::ideal, run_control_);
    felt = felt_ticks(changed, judged.plan, DeviceModel::scenario, run_control_);
  } catch (const RunFailure& failure) {
    if (failure.reason != "diverged" && failure.reason != "unstable-step") throw;
    point.state = StudyCell::State::diverged;
    point.reason = failure.what();
    return;
  }
  if (interrupted()) return;
  Sum total, discretisation, remap, device;
  for (std::size_t tool = 0; tool < felt.size(); ++tool) {
    const Emission emission = scenario_.devices[tool].emission;
    // A held force is on average half a slot older than when it comes.
    const double newer_s = emission == Emission::hold ? step_s() / 2 : 0;
    for (std::size_t k = 0; k < felt[tool].size(); ++k) {
      const double t_s = seconds(felt[tool][k].at), then_s = t_s - judged.ideal_age_s[tool];
      const glm::dvec3 here_N = reference_.at_N(tool, then_s);
      const glm::dvec3 d = played_N(even, tool, then_s + newer_s, emission) - here_N;
      const glm::dvec3 with_ideal = ideal[tool][k].force_N - here_N;
      const glm::dvec3 e = felt[tool][k].force_N - reference_.at_N(tool, t_s - judged.age_s[tool]);
      discretisation.add(d);
      remap.add(with_ideal - d);
      device.add(e - with_ideal);
      total.add(e);
      point.saturated += felt[tool][k].saturated;
    }
  }
  point.total = total.error();
  point.discretisation = discretisation.error();
  point.remap = remap.error();
  point.device = device.error();
  double latency_s = 0;
  for (std::size_t tool = 0; tool < felt.size(); ++tool) {
    point.latency_s = std::max(point.latency_s, judged.ideal_age_s[tool]);
    latency_s = std::max(latency_s, judged.age_s[tool] + seconds(scenario_.devices[tool].force_delay));
  }
  point.device_latency_s = latency_s - point.latency_s;
  if (!(point.total.rms_N <= kDivergedForces * reference_.info.scale_N)) {
    point.state = StudyCell::State::diverged;
    point.reason = fmt::format("the error is {:.3g} times the force", point.total.rms_N / reference_.info.scale_N);
  }
}

void put_points(FeltStudyRecord& record, const std::vector<std::vector<FeltPoint>>& cells) {
  const std::size_t strategies = cells.empty() ? 0 : cells.front().size();
  for (std::size_t s = 0; s < strategies; ++s) {
    for (const std::vector<FeltPoint>& cell : cells) record.points.push_back(cell[s]);
  }
}

}  // namespace internal

namespace {

FeltStudyRecord all_cells(const Scenario& scenario, const FeltStudyControl& control) {
  internal::FeltCells study(scenario, control);
  FeltStudyRecord record = study.description();
  study.prepare();
  const auto report = [&](double fraction) {
    if (control.progress) control.progress(fraction);
  };
  std::vector<std::vector<FeltPoint>> cells;
  for (std::size_t c = 0; c < study.count() && !study.interrupted(); ++c) {
    report(static_cast<double>(c) / static_cast<double>(study.count()));
    std::vector<FeltPoint> cell = study.cell(c);
    if (!study.interrupted()) cells.push_back(std::move(cell));
  }
  report(1);
  record.reference = study.reference();
  record.ticks = study.ticks();
  internal::put_points(record, cells);
  record.interrupted = cells.size() < study.count();
  return record;
}

}  // namespace

std::string felt_study_objection(const Scenario& scenario) {
  if (scenario.case_spec) return "a [case] has no hand that feels a force; write a scenario with a [[device]]";
  const bool any = std::any_of(scenario.strategies.begin(), scenario.strategies.end(),
                               [](StrategyKind kind) { return !traits_of(kind).knows_motion; });
  const internal::JudgedSpan span = internal::judged_span(scenario);
  if (!(span.from < span.end)) return "the run judges nothing: its warm-up ends when it does";
  if (!any) return "'ideal' alone is what the others are compared with; name another strategy in [run] strategies";
  for (const DeviceSpec& device : scenario.devices) {
    if (device.hand)
      return fmt::format(
          "'{}' is held by a hand that feels the force, so nobody knows where it would be without an error; "
          "write a programmed motion",
          device.name);
    if (!std::holds_alternative<ForceRender>(device.render))
      return fmt::format(
          "'{}' computes its force from a local model, which has no latency of its own; write render = "
          "{{ kind = \"force\" }}",
          device.name);
    if (!knows_newtons(device.driver))
      return fmt::format("nobody knows the force of '{}' in newtons; write its full_scale", device.name);
  }
  return {};
}

FeltStudyRecord run_felt_study(const Scenario& scenario, const FeltStudyControl& control) {
  if (const std::string objection = felt_study_objection(scenario); !objection.empty())
    throw std::invalid_argument(objection);
  try {
    return all_cells(scenario, control);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

}  // namespace evenstep
