#include "pairs.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>

#include "evenstep/clock/wall_clock.h"

namespace evenstep {

Measured measured(std::vector<double> of_pairs) {
  if (of_pairs.empty()) return {};
  std::sort(of_pairs.begin(), of_pairs.end());
  const std::size_t n = of_pairs.size();
  // The true median lies outside the (k+1)-th least and largest with twice the chance that at most k of n fair coins show
  // heads. k is the largest for which that is at most 5 %.
  double coins = std::pow(0.5, static_cast<double>(n)), below = coins;
  std::size_t k = 0;
  while (2 * k + 2 < n) {
    coins *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    below += coins;
    if (2 * below > 0.05) break;
    ++k;
  }
  return {(of_pairs[(n - 1) / 2] + of_pairs[n / 2]) / 2, of_pairs[k], of_pairs[n - 1 - k]};
}

namespace internal {
namespace {

constexpr int kWarmUp_steps = 20;

struct StepResult {
  ToolResponse response;
  std::uint64_t digest = 0;
};

StepResult one_step(Side& side, const std::array<glm::dvec3, kMaxTools>& tools_m) {
  const std::span tools(tools_m.data(), static_cast<std::size_t>(side.scene.tool_count));
  StepResult result;
  result.response =
      side.scene.variable_step ? side.solver->step(tools, period_s(side.scene.step_rate)) : side.solver->step(tools);
  if (side.scene.needs_state_digest) result.digest = side.solver->state_digest();
  return result;
}

bool same_forces(const ToolResponse& a, const ToolResponse& b) {
  return std::memcmp(a.force_N.data(), b.force_N.data(), sizeof a.force_N) == 0;
}

/// Both sides and where they are on the path.
class Race {
 public:
  Race(Side& with, Side& without, const ToolPath& path) : with_(with), without_(without), path_(path) {}

  /// Some steps of both; returns their CPU times, with first.
  std::pair<double, double> run(std::int64_t steps, bool with_first) {
    if (at_ + steps > static_cast<std::int64_t>(path_.size())) restart();
    steps = std::min(steps, static_cast<std::int64_t>(path_.size()));
    std::vector<StepResult> ours(static_cast<std::size_t>(steps)), theirs(ours.size());
    double with_s = 0, without_s = 0;
    if (with_first) with_s = timed(with_, ours);
    without_s = timed(without_, theirs);
    if (!with_first) with_s = timed(with_, ours);
    for (std::size_t n = 0; n < ours.size(); ++n) {
      same_bits = same_bits && same_forces(ours[n].response, theirs[n].response);
      if (with_.scene.needs_state_digest && without_.scene.needs_state_digest)
        same_bits = same_bits && ours[n].digest == theirs[n].digest;
    }
    at_ += steps;
    done += steps;
    return {with_s, without_s};
  }

  bool same_bits = true;
  std::int64_t done = 0;

 private:
  void restart() {
    with_.solver->reset();
    without_.solver->reset();
    at_ = 0;
  }
  double timed(Side& side, std::vector<StepResult>& results) {
    const double began_s = process_cpu_seconds();
    for (std::size_t n = 0; n < results.size(); ++n) results[n] = one_step(side, path_[static_cast<std::size_t>(at_) + n]);
    return process_cpu_seconds() - began_s;
  }

  Side& with_;
  Side& without_;
  const ToolPath& path_;
  std::int64_t at_ = 0;
};

double resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  double size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// What a child tells its parent.
struct Told {
  double cpu_s = 0, resident_bytes = 0;
  char error[200] = {};
};

Told open_here(const std::function<void()>& open) {
  Told told;
  const double cpu_s = process_cpu_seconds(), resident = resident_bytes();
  try {
    open();
  } catch (const std::exception& error) {
    std::strncpy(told.error, error.what(), sizeof told.error - 1);
  }
  told.cpu_s = process_cpu_seconds() - cpu_s;
  told.resident_bytes = resident_bytes() - resident;
  return told;
}

std::optional<Told> open_in_child(const std::function<void()>& open) {
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  const pid_t child = fork();
  if (child == 0) {
    const Told told = open_here(open);
    const bool written = write(ends[1], &told, sizeof told) == static_cast<ssize_t>(sizeof told);
    _exit(written ? 0 : 1);  // nothing of the parent's is tidied up twice
  }
  close(ends[1]);
  Told told;
  const bool whole = child > 0 && read(ends[0], &told, sizeof told) == static_cast<ssize_t>(sizeof told);
  close(ends[0]);
  if (child > 0) waitpid(child, nullptr, 0);
  return whole ? std::optional(told) : std::nullopt;
}

}  // namespace

StepPairs step_pairs(Side& with, Side& without, const ToolPath& path, const CostOptions& options) {
  StepPairs pairs;
  pairs.compared_particles = with.scene.needs_state_digest && without.scene.needs_state_digest;
  Race race(with, without, path);
  const auto [warm_with_s, warm_without_s] = race.run(kWarmUp_steps, true);
  const double step_s = (warm_with_s + warm_without_s) / (2 * kWarmUp_steps);
  const auto steps = static_cast<std::int64_t>(std::clamp(options.steps_seconds / std::max(step_s, 1e-9), 1.0, 1e4));
  for (int pair = 0; pair < options.step_pairs && !(options.interrupted && *options.interrupted); ++pair) {
    const auto [with_s, without_s] = race.run(steps, pair % 2 == 0);
    pairs.with_s.push_back(with_s);
    pairs.without_s.push_back(without_s);
  }
  pairs.same_bits = race.same_bits;
  pairs.steps = race.done;
  return pairs;
}

Opened opened_in_children(const std::function<void()>& open, int times) {
  std::vector<double> cpu_ms, resident_MiB;
  for (int n = 0; n < times; ++n) {
    const std::optional<Told> told = open_in_child(open);
    if (!told) return {.error = "the process that opened it ended early"};
    if (told->error[0] != 0) return {.error = told->error};
    cpu_ms.push_back(1e3 * told->cpu_s);
    resident_MiB.push_back(told->resident_bytes / (1 << 20));
  }
  return {measured(cpu_ms), measured(resident_MiB), ""};
}

}  // namespace internal
}  // namespace evenstep
