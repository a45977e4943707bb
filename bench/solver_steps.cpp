// The time of a solver step with one substep (and, on OpenCL, with four, as Figure 1 has), while a tool is dragged to and
// fro at 0.1 m/s and forces are read after every step. It is compared with a plain loop of the same arithmetic
// (plain_tissue.h). Nothing is timed unless the forces of that loop are bit by bit those of the float solver. All OpenCL
// devices are measured side by side in one process, or those with DEVICE in their name; PoCL has two drivers. A million and
// four million particles are measured if they are named.
//   POCL_DEVICES="basic pthread" OMP_WAIT_POLICY=passive build/bench/bench_solver_steps [ROUNDS [PARTICLES [DEVICE]]]
// OMP_WAIT_POLICY is passive because otherwise the process CPU of a candidate would include OpenMP threads that still spin
// after the one before. In every round each solver makes a few steps, so that whatever the machine does hits all of them
// alike.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/sim/opencl_devices.h"
#include "evenstep/sim/solver.h"
#ifdef EVENSTEP_WITH_BULLET
#include "bullet_block.h"
#endif
#include "plain_tissue.h"

namespace {

using namespace evenstep;
using bench::PlainTissue;

constexpr double kSpeed_m_per_s = 0.1;
constexpr Rate kStepRate{2000, 1};           // 0.5 ms: one substep is below the limit of 0.645 ms
constexpr std::int64_t kWarmUp_steps = 300;  // the wave has crossed the block: no denormal numbers are left before it

struct Block {
  const char* name;
  std::array<int, 3> lattice;
  std::int64_t particles;
};
constexpr Block kBlocks[] = {{"1000", {10, 10, 10}, 1'000},           {"20270", {27, 27, 28}, 20'270},
                             {"99452", {46, 46, 47}, 99'452},         {"499280", {79, 79, 80}, 499'280},
                             {"1000000", {100, 100, 100}, 1'000'000}, {"4000000", {160, 160, 157}, 4'000'000}};
constexpr std::int64_t kMostUnasked = 500'000;

TissueScene tissue_of(const Block& block, int substeps = 1) {
  TissueScene tissue;
  tissue.lattice = block.lattice;
  tissue.particle_count = block.particles;
  tissue.damping_per_s = 20;
  tissue.substeps = substeps;
  const auto [nx, ny, nz] = block.lattice;
  tissue.tools = {{glm::dvec3(nx / 2, ny / 2, nz - 2) * tissue.spacing_m, 1.5 * tissue.spacing_m}};
  return tissue;
}

/// 5 mm out and back again.
double way_m(std::int64_t n) {
  const std::int64_t phase = n % 200;
  return static_cast<double>(phase < 100 ? phase : 200 - phase) * kSpeed_m_per_s * period_s(kStepRate);
}

/// A way to make a step, and how long a step took in each round.
struct Candidate {
  std::string name, device;
  std::function<void()> step;
  std::vector<double> real_us, cpu_us;
  std::int64_t warm_up = kWarmUp_steps;
};

Candidate make_candidate(const Block& block, const char* name, SolverKind kind, const std::string& device, int substeps = 1,
                         bool digest = false, bool energy = false) {
  SolverOptions options;
  options.opencl_device = device;
  const Rate rate{kStepRate.num, kStepRate.den * substeps};
  const std::shared_ptr<Solver> solver = make_solver(kind, {tissue_of(block, substeps), rate, 1, digest, energy}, options);
  const auto step = [solver, digest, n = std::int64_t{0}]() mutable {
    solver->step(std::array{glm::dvec3(way_m(n++), 0, 0)});
    if (digest) solver->state_digest();
  };
  return {name, solver->info().device, step, {}, {}};
}

Candidate make_plain(const Block& block, const char* name, int threads) {
  const auto tissue = std::make_shared<PlainTissue>(tissue_of(block), period_s(kStepRate), threads);
  return {name, "", [tissue, n = std::int64_t{0}]() mutable { tissue->step({way_m(n++), 0, 0}); }, {}, {}};
}

Candidate make_floor(const Block& block) {
  const auto floor = std::make_shared<bench::DivideAndRootFloor>(tissue_of(block));
  return {"divide and root alone", "", [floor] { floor->step(); }, {}, {}};
}

#ifdef EVENSTEP_WITH_BULLET
Candidate make_bullet(const Block& block) {
  const auto body = std::make_shared<bench::BulletBlock>(tissue_of(block), period_s(kStepRate), 4);
  return {"Bullet, 4 iterations", "", [body, n = std::int64_t{0}]() mutable { body->step(way_m(n++)); }, {}, {}, 10};
}
#endif

/// Whether the yardstick does the solver's work: the forces of 500 steps must be the same bit for bit.
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

void time_steps(Candidate& candidate, int steps) {
  const double real_s = monotonic_seconds(), cpu_s = process_cpu_seconds();
  for (int i = 0; i < steps; ++i) candidate.step();
  candidate.real_us.push_back((monotonic_seconds() - real_s) / steps * 1e6);
  candidate.cpu_us.push_back((process_cpu_seconds() - cpu_s) / steps * 1e6);
}

double least(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }
double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}
double median_ratio(std::vector<double> values, const std::vector<double>& to) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] /= to[i];
  return median(values);
}
double median_difference(std::vector<double> values, const std::vector<double>& from) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= from[i];
  return median(values);
}

/// Prints real time and process CPU (all threads), and both divided by those of the plain loop on as many threads. All are
/// medians over the rounds.
void print_table(const Block& block, const std::vector<Candidate>& candidates) {
  const Candidate &one_thread = candidates[0], &two_threads = candidates[1];
  std::printf("%s particles, us per step\n%-22s%9s%9s%9s%9s%10s | %14s%9s | %9s%9s%9s\n", block.name, "", "wall", "median",
              "CPU", "median", "steps/s", "wall/1 thread", "CPU/1", "wall/2", "CPU/2", "CPU-1 us");
  for (const Candidate& candidate : candidates) {
    std::printf("%-22s%9.1f%9.1f%9.1f%9.1f%10.0f | %14.2f%9.2f | %9.2f%9.2f%9.1f  %s\n", candidate.name.c_str(),
                least(candidate.real_us), median(candidate.real_us), least(candidate.cpu_us), median(candidate.cpu_us),
                1e6 / least(candidate.real_us), median_ratio(candidate.real_us, one_thread.real_us),
                median_ratio(candidate.cpu_us, one_thread.cpu_us), median_ratio(candidate.real_us, two_threads.real_us),
                median_ratio(candidate.cpu_us, two_threads.cpu_us), median_difference(candidate.cpu_us, one_thread.cpu_us),
                candidate.device.c_str());
  }
  std::printf("two threads make %.2f times the steps of one (plain loop)\n\n",
              median_ratio(one_thread.real_us, two_threads.real_us));
}

void run_block(const Block& block, int rounds, const std::string& device) {
  std::vector<Candidate> candidates;
  candidates.push_back(make_plain(block, "plain loop, 1 thread", 1));
  candidates.push_back(make_plain(block, "plain loop, 2 threads", 2));
  candidates.push_back(make_candidate(block, "cpu float", SolverKind::cpu_float, ""));
  candidates.push_back(make_candidate(block, "cpu double", SolverKind::cpu_double, ""));
  for (const OpenClListed& there : opencl_devices()) {
    const std::string name = opencl_text({there}, 0);
    if (name.find(device) == std::string::npos) continue;
    candidates.push_back(make_candidate(block, "opencl", SolverKind::opencl, name));
    candidates.push_back(make_candidate(block, "  four substeps", SolverKind::opencl, name, 4));
    candidates.push_back(make_candidate(block, "  with digest", SolverKind::opencl, name, 1, true));
    candidates.push_back(make_candidate(block, "  with energy", SolverKind::opencl, name, 1, false, true));
  }
  candidates.push_back(make_floor(block));
#ifdef EVENSTEP_WITH_BULLET
  candidates.push_back(make_bullet(block));
#endif
  const int steps_per_round = static_cast<int>(std::max<std::int64_t>(5, 400'000 / block.particles));  // some ms each
  for (Candidate& candidate : candidates) {
    for (std::int64_t i = 0; i < candidate.warm_up; ++i) candidate.step();
  }
  for (int round = 0; round < rounds; ++round) {
    for (Candidate& candidate : candidates) time_steps(candidate, steps_per_round);
  }
  print_table(block, candidates);
}

}  // namespace

int main(int argc, char** argv) {
  if (!is_same_arithmetic(kBlocks[0])) {
    std::fputs("bench_solver_steps: the plain loop's forces are not the float solver's\n", stderr);
    return 1;
  }
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 50;
  for (const Block& block : kBlocks) {
    if (argc <= 2 ? block.particles <= kMostUnasked : std::strcmp(argv[2], block.name) == 0)
      run_block(block, rounds, argc > 3 ? argv[3] : "");
  }
}
