#include "evenstep/catalogue/run_trial.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/step_timing.h"
#include "evenstep/time/digest.h"
#include "hand_over.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kDigests = 16;  // digests of the state along a run, so a difference can be located to a sixteenth

bool is_interrupted(const std::atomic<bool>* interrupted) { return interrupted != nullptr && interrupted->load(); }

/// The steps of a trial as work for an executor.
class TrialStep final : public Work {
 public:
  TrialStep(Trial& trial, Solver& solver, std::int64_t steps, const std::atomic<bool>* interrupted)
      : trial_(trial),
        solver_(solver),
        steps_(steps),
        interrupted_(interrupted),
        digest_every_(std::max<std::int64_t>(1, trial.steps / kDigests)),
        tools_(static_cast<std::size_t>(trial.scene.tool_count)) {}
  void run() override {
    std::array<glm::dvec3, kMaxTools> positions_m{};
    const std::span hands(positions_m.data(), tools_);
    trial_.hands(done_, hands);
    response_ = solver_.step(hands);
    ++done_;
    for (std::size_t tool = 0; tool < tools_; ++tool) {
      const glm::dvec3& f = response_.force_N[tool];
      for (const double component : {f.x, f.y, f.z}) digest_ = mix(digest_, component);
    }
    if (done_ % digest_every_ == 0) digest_ = mix(digest_, solver_.state_digest());
  }
  std::int64_t done() const { return done_; }
  /// Whether it is at its end, or was stopped before.
  bool finished() const { return done_ == steps_ || is_interrupted(interrupted_); }
  const ToolResponse& response() const { return response_; }
  /// The digest of the forces so far, of states along the way, and of the current state.
  std::uint64_t digest() { return mix(digest_, solver_.state_digest()); }

 private:
  Trial& trial_;
  Solver& solver_;
  std::int64_t steps_;
  const std::atomic<bool>* interrupted_;
  std::int64_t digest_every_, done_ = 0;
  std::size_t tools_;
  ToolResponse response_;
  std::uint64_t digest_ = 0;
};

/// Visualizations of any length between steps of any length, in segments of one step to forty.
ProgrammedTiming irregular_timing(std::uint64_t seed) {
  ProgrammedTiming timing;
  timing.steps = {1, 7, 15, 40};
  timing.visualization_variation = timing.step_variation = 0.5;
  timing.first_step = 1;
  timing.preemption = Preemption{2, {3'000'000}, {40'000'000}};
  timing.seed = seed;
  return timing;
}

Task irregular_lane(Scheduler& scheduler, StepTiming& timing, TrialStep& step) {
  SegmentTiming segment;
  while (!step.finished()) {
    timing.next(segment);
    co_await scheduler.until(segment.begin, Lane::launch, "segment");
    if (segment.visualization) co_await scheduler.external(segment.visualization->end, nullptr, "visualization");
    for (const Interval& slot : segment.steps) {
      if (step.finished()) break;
      co_await scheduler.until(slot.begin, Lane::launch, "launch");
      co_await scheduler.external(slot.end, &step, "step");
    }
  }
}

/// The irregular schedule repeats what the even one has already run, so a failure in it is not a result of the cell.
void throw_if_failed(const RunStatus& status) {
  if (status.end == RunEnd::limit)
    throw RunFailure("limit", "irregular schedule: " + status.message, "fewer steps in the [case]");
  if (status.end != RunEnd::failed) return;
  try {
    std::rethrow_exception(status.failure);
  } catch (const SolverError& error) {
    throw RunFailure(name_of(error.fault()), std::string("irregular schedule: ") + error.what(), error.remedy());
  }
}

/// The digest of the first `steps` steps, launched at irregular times.
std::uint64_t irregular_digest(Trial& trial, Solver& solver, std::int64_t steps, std::uint64_t seed,
                               const std::atomic<bool>* interrupted) {
  TrialStep step(trial, solver, steps, interrupted);
  const std::unique_ptr<StepTiming> timing = make_programmed_timing(irregular_timing(seed));
  VirtualClock clock;
  InlineExecutor executor;
  Scheduler scheduler(clock, executor, {{}, std::nullopt, false});
  scheduler.spawn(irregular_lane(scheduler, *timing, step));
  throw_if_failed(scheduler.run(RealTime{INT64_MAX / 2}));
  return step.digest();
}

/// Records that the solver refused the scene, or why it is unavailable.
void say_no(const SolverError& error, CaseCell& cell) {
  if (error.fault() == SolverFault::out_of_memory) throw RunFailure(name_of(error.fault()), error.what(), error.remedy());
  cell.status = error.fault() == SolverFault::unavailable ? CellStatus::unavailable : CellStatus::refused;
  cell.detail = std::string(error.what()) + "; " + error.remedy();
}

/// Records the length of the substeps divided by the limit, for every cell, whether it ran or was refused.
void put_step_over_limit(const Scene& scene, CaseCell& cell) {
  const auto& tissue = std::get<TissueScene>(scene.body);
  const double limit_s = step_limit(tissue).step_s;
  if (tissue.substeps > 0 && std::isfinite(limit_s))
    cell.metrics["step_over_limit"] = period_s(scene.step_rate) / tissue.substeps / limit_s;
}

void run_evenly(Trial& trial, Solver& solver, const std::atomic<bool>* interrupted, CaseCell& cell) {
  TrialStep step(trial, solver, trial.steps, interrupted);
  bool bounded = true;
  while (!step.finished() && bounded) {
    step.run();
    if (step.done() % trial.observe_every == 0 || step.finished())
      bounded = trial.observe(step.done(), step.response(), solver);
  }
  cell.steps = step.done();
  if (bounded) {
    cell.status = CellStatus::ok;
    trial.judge(solver, cell);
  } else {
    cell.status = CellStatus::diverged;
  }
  cell.digest = step.digest();
}

}  // namespace

CaseCell run_cell(const CaseKind& kind, CellSpec spec, std::uint64_t seed, const std::atomic<bool>* interrupted) {
  spec.interrupted = interrupted;
  CaseCell cell;
  cell.value = spec.value;
  const CaseCell not_run = cell;
  if (is_interrupted(interrupted)) return not_run;
  try {
    const std::unique_ptr<Trial> trial = kind.make(spec);
    if (is_interrupted(interrupted)) return not_run;
    trial->scene.needs_state_digest = true;
    put_step_over_limit(trial->scene, cell);
    const std::unique_ptr<Solver> solver =
        spec.spec.foreign ? make_case_solver(*spec.spec.foreign, trial->scene) : make_solver(spec.solver, trial->scene);
    run_evenly(*trial, *solver, interrupted, cell);
    solver->reset();
    cell.schedule_differs = irregular_digest(*trial, *solver, cell.steps, seed, interrupted) != cell.digest;
  } catch (const SolverError& error) {
    say_no(error, cell);
  }
  return is_interrupted(interrupted) ? not_run : cell;
}

}  // namespace evenstep::internal
