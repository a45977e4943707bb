// Time of one solver step on the paper's scene (20,270 particles, one substep, one tool dragged at 0.1 m/s), forces read
// after every step. The OpenCL driver is chosen outside: POCL_DEVICES=basic or pthread.
//   build/bench/bench_solver_steps --benchmark_repetitions=5 --benchmark_report_aggregates_only=true
#include <benchmark/benchmark.h>

#include <array>

#include "evenstep/sim/solver.h"

namespace {

using namespace evenstep;

constexpr double kSpeed_m_per_s = 0.1;
constexpr Rate kStepRate{2000, 1};  // 0.5 ms: one substep is below the limit of 0.645 ms

Scene paper_scene(bool digest, bool energy) {
  TissueScene tissue;
  const double a = tissue.spacing_m;
  tissue.grabs = {{glm::dvec3(13, 13, 26) * a, 1.5 * a}};
  return {tissue, kStepRate, 1, digest, energy};
}

void solver_steps(benchmark::State& state, SolverKind kind, bool digest, bool energy) {
  const auto solver = make_solver(kind, paper_scene(digest, energy));
  std::int64_t n = 0;
  for (auto _ : state) {
    // Out and back again: the block is never pulled further than 50 mm.
    const std::int64_t phase = n++ % 2000;
    const double way_m = static_cast<double>(phase < 1000 ? phase : 2000 - phase) * kSpeed_m_per_s * period_s(kStepRate);
    const std::array position_m{glm::dvec3(way_m, 0, 0)};
    benchmark::DoNotOptimize(solver->step(position_m));
    if (digest) benchmark::DoNotOptimize(solver->state_digest());
  }
  state.SetLabel(solver->info().name + " " + solver->info().device);
}

#define SOLVER_BENCHMARK(name, ...) \
  BENCHMARK_CAPTURE(solver_steps, name, __VA_ARGS__)->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime()->UseRealTime()
SOLVER_BENCHMARK(cpu_float, SolverKind::cpu_float, false, false);
SOLVER_BENCHMARK(cpu_double, SolverKind::cpu_double, false, false);
SOLVER_BENCHMARK(opencl, SolverKind::opencl, false, false);
SOLVER_BENCHMARK(opencl_digest, SolverKind::opencl, true, false);
SOLVER_BENCHMARK(opencl_energy, SolverKind::opencl, false, true);

}  // namespace

BENCHMARK_MAIN();
