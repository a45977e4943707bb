// Time of one solver step of one substep with one tool dragged to and fro at 0.1 m/s, forces read after every step, beside a
// plain loop of the same arithmetic (plain_tissue.h; its forces must be the float solver's bit by bit, or nothing is timed).
// PoCL's drivers stand side by side in one process:
//   POCL_DEVICES="basic pthread" build/bench/bench_solver_steps --benchmark_repetitions=9
// The digest's and the energy's cost is that of opencl_basic_digest and _energy over opencl_basic.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <string>

#include "evenstep/sim/solver.h"
#include "plain_tissue.h"

namespace {

using namespace evenstep;
using bench::PlainTissue;

constexpr double kSpeed_m_per_s = 0.1;
constexpr Rate kStepRate{2000, 1};  // 0.5 ms: one substep is below the limit of 0.645 ms
constexpr std::int64_t kWarmUp_steps = 300;  // the wave has crossed the block: no denormal numbers before its front

struct Block {
  const char* name;
  std::array<int, 3> lattice;
  std::int64_t particles;
};
constexpr Block kBlocks[] = {
    {"1000", {10, 10, 10}, 1'000}, {"20270", {27, 27, 28}, 20'270}, {"99452", {46, 46, 47}, 99'452}};

TissueScene tissue_of(const Block& block) {
  TissueScene tissue;
  tissue.lattice = block.lattice;
  tissue.particle_count = block.particles;
  tissue.damping_per_s = 20;
  tissue.substeps = 1;
  const auto [nx, ny, nz] = block.lattice;
  tissue.grabs = {{glm::dvec3(nx / 2, ny / 2, nz - 2) * tissue.spacing_m, 1.5 * tissue.spacing_m}};
  return tissue;
}

/// Out and back again, 5 mm.
double way_m(std::int64_t n) {
  const std::int64_t phase = n % 200;
  return static_cast<double>(phase < 100 ? phase : 200 - phase) * kSpeed_m_per_s * period_s(kStepRate);
}

void steps(benchmark::State& state, SolverKind kind, const Block& block, const char* device, bool digest, bool energy) {
  SolverOptions options;
  options.opencl_device = device;
  const auto solver = make_solver(kind, {tissue_of(block), kStepRate, 1, digest, energy}, options);
  std::int64_t n = 0;
  const auto step = [&] { return solver->step(std::array{glm::dvec3(way_m(n++), 0, 0)}); };
  while (n < kWarmUp_steps) step();
  for (auto _ : state) {
    benchmark::DoNotOptimize(step());
    if (digest) benchmark::DoNotOptimize(solver->state_digest());
  }
  state.SetLabel(solver->info().name + " " + solver->info().device);
}

void plain_steps(benchmark::State& state, const Block& block, int threads) {
  PlainTissue tissue(tissue_of(block), period_s(kStepRate), threads);
  std::int64_t n = 0;
  const auto step = [&] { return tissue.step({way_m(n++), 0, 0}); };
  while (n < kWarmUp_steps) step();
  for (auto _ : state) benchmark::DoNotOptimize(step());
}

/// The yardstick does the solver's work: bit for bit the same forces over 500 steps.
bool is_same_arithmetic(const Block& block) {
  const auto solver = make_solver(SolverKind::cpu_float, {tissue_of(block), kStepRate, 1, false, false});
  PlainTissue plain(tissue_of(block), period_s(kStepRate), 1);
  for (std::int64_t n = 0; n < 500; ++n) {
    const glm::dvec3 force_N = solver->step(std::array{glm::dvec3(way_m(n), 0, 0)}).force_N[0];
    const std::array<double, 3> plain_N = plain.step({way_m(n), 0, 0});
    if (std::memcmp(&force_N, &plain_N, sizeof plain_N) != 0) return false;
  }
  return true;
}

template <class Function>
void register_timed(const std::string& name, const Block& block, Function function) {
  benchmark::RegisterBenchmark((name + "/" + block.name).c_str(), function)
      ->Unit(benchmark::kMicrosecond)->MeasureProcessCPUTime()->UseRealTime();
}

void register_block(const Block& block) {
  const auto solver = [&](const char* name, SolverKind kind, const char* device, bool digest = false, bool energy = false) {
    register_timed(name, block, [=, &block](benchmark::State& s) { steps(s, kind, block, device, digest, energy); });
  };
  register_timed("plain_1_thread", block, [&](benchmark::State& state) { plain_steps(state, block, 1); });
  register_timed("plain_2_threads", block, [&](benchmark::State& state) { plain_steps(state, block, 2); });
  solver("cpu_float", SolverKind::cpu_float, "");
  solver("cpu_double", SolverKind::cpu_double, "");
  solver("opencl_basic", SolverKind::opencl, "basic");
  solver("opencl_pthread", SolverKind::opencl, "pthread");
  solver("opencl_basic_digest", SolverKind::opencl, "basic", true);
  solver("opencl_basic_energy", SolverKind::opencl, "basic", false, true);
}

}  // namespace

int main(int argc, char** argv) {
  if (!is_same_arithmetic(kBlocks[0])) {
    std::fputs("bench_solver_steps: the plain loop's forces are not the float solver's\n", stderr);
    return 1;
  }
  for (const Block& block : kBlocks) register_block(block);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
