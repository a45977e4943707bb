// Where the time of a run goes: the paper's Figure 1 (one strategy, phase_locked) from t = 0 to its last event. The process
// CPU of all threads is split into solver, state digest and everything else (scheduler, maps, rings, devices, recorders).
//   POCL_DEVICES=basic build/bench/bench_figure_1 scenarios/paper/figure-1.toml [REPETITIONS]
// CPU time is read before and after each call of the solver. What the reading costs is measured and subtracted from the
// rest.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <utility>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_lanes.h"
#include "evenstep/harness/strategy_run.h"

namespace {

using namespace evenstep;

struct Spent {
  double total_s = 0, solver_s = 0, digest_s = 0, reading_s = 0, real_s = 0;
  std::int64_t events = 0;
  double rest_s() const { return total_s - solver_s - digest_s - reading_s; }
};

/// A solver that notes what it costs.
class WatchedSolver final : public Solver {
 public:
  WatchedSolver(std::unique_ptr<Solver> solver, Spent& spent) : solver_(std::move(solver)), spent_(spent) {}
  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s) override {
    const double before_s = process_cpu_seconds();
    const ToolResponse response = solver_->step(positions_m, step_s);
    spent_.solver_s += process_cpu_seconds() - before_s;
    readings_ += 2;
    return response;
  }
  std::span<const ToolContact> contacts() const override { return solver_->contacts(); }
  std::uint64_t state_digest() override {
    const double before_s = process_cpu_seconds();
    const std::uint64_t digest = solver_->state_digest();
    spent_.digest_s += process_cpu_seconds() - before_s;
    readings_ += 2;
    return digest;
  }
  void reset() override { solver_->reset(); }
  ParticleState particle_state() override { return solver_->particle_state(); }
  SolverVerdict verdict() override { return solver_->verdict(); }
  const SolverInfo& info() const override { return solver_->info(); }
  std::int64_t readings() const { return readings_; }

 private:
  std::unique_ptr<Solver> solver_;
  Spent& spent_;
  std::int64_t readings_ = 0;
};

double reading_costs_s() {
  constexpr int kReadings = 10'000;
  const double before_s = process_cpu_seconds();
  for (int i = 0; i < kReadings; ++i) process_cpu_seconds();
  return (process_cpu_seconds() - before_s) / kReadings;
}

/// One strategy as run_strategy runs it, with the solver watched.
Spent run_once(const Scenario& scenario, const StrategyPlan& plan) {
  Spent spent;
  const double reading_s = reading_costs_s();
  VirtualClock clock;
  SimulatedDevices devices(scenario, clock);
  DeviceExchange exchange(links_of(scenario, plan), devices.drivers());
  auto watched = std::make_unique<WatchedSolver>(make_scenario_solver(scenario, plan.kind), spent);
  const WatchedSolver& solver = *watched;
  StrategyLanes lanes(scenario, plan, std::move(watched), exchange, make_timing(scenario.timing), devices.drivers());
  InlineExecutor executor;
  Scheduler scheduler(clock, executor);
  lanes.spawn(scheduler, scheduler);

  const double cpu_s = process_cpu_seconds(), real_s = monotonic_seconds();
  const SlicedRun run = run_in_slices(scheduler, RealTime{scenario.run_duration.ns}, name_of(plan.kind), {});
  throw_if_failed(run.status, name_of(plan.kind));
  spent.real_s = monotonic_seconds() - real_s;
  spent.total_s = process_cpu_seconds() - cpu_s;
  spent.reading_s = static_cast<double>(solver.readings()) * reading_s / 2;  // one of two lies within the measured time
  spent.events = scheduler.event_count();
  return spent;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fputs("usage: bench_figure_1 SCENARIO [REPETITIONS]\n", stderr), 2;
  const ReadResult read = read_scenario(argv[1], {{"run.strategies=[\"phase_locked\"]", "expect=[]"}, std::nullopt});
  for (const Diagnostic& error : read.error_or({})) std::fprintf(stderr, "%s\n", text(error).c_str());
  if (!read) return 2;
  const StrategyPlan plan = evenstep::plan(*read).front();
  const double virtual_s = seconds(read->run_duration);

  std::printf("%8s %9s %9s %9s %9s %9s %10s %12s\n", "events", "CPU ms", "solver %", "digest %", "rest %", "rest ms",
              "us/event", "virtual/real");
  for (int i = 0; i < (argc > 2 ? std::atoi(argv[2]) : 5); ++i) {
    const Spent spent = run_once(*read, plan);
    const double percent = 100 / (spent.total_s - spent.reading_s);
    std::printf("%8lld %9.1f %9.2f %9.2f %9.2f %9.3f %10.3f %12.2f\n", static_cast<long long>(spent.events),
                (spent.total_s - spent.reading_s) * 1e3, spent.solver_s * percent, spent.digest_s * percent,
                spent.rest_s() * percent, spent.rest_s() * 1e3, spent.rest_s() * 1e6 / static_cast<double>(spent.events),
                virtual_s / spent.real_s);
  }
}
