// Two loops that block, each on a thread of its own: they ask a clock for the time and sleep. Neither becomes a coroutine;
// only the clock changes. `blocking_loop` runs in virtual time, `blocking_loop wall` in real time.
#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <utility>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/scheduler/stepped_thread.h"
using namespace evenstep;

constexpr Duration kVisualization{11'100'000}, kStep{1'482'222};
constexpr double kSpeed_m_per_s = 0.1;
constexpr RealTime kEnd{1'000'000'000};

struct Shared {
  std::mutex mutex;
  double position_m = 0, force_N = 0;
  double before_m = 0, last_m = 0, jump_steps = 0;  // the largest change of velocity, in units of the even motion per step
  int reads = 0;
  double read() {
    const std::lock_guard lock(mutex);
    const double change_m = position_m - 2 * last_m + before_m;
    if (++reads > 2) jump_steps = std::max(jump_steps, std::abs(change_m) / (kSpeed_m_per_s * period_s({450, 1})));
    before_m = std::exchange(last_m, position_m);
    return position_m;
  }
};

// Stands in for a GPU: where yours draws and computes, this one sleeps for as long as that would take.
void gpu_works(BlockingClock& clock, Duration how_long) { clock.sleep_until(clock.now() + how_long, Lane::completion); }

void haptic_loop(BlockingClock& clock, Shared& shared) {
  for (std::int64_t k = 0;; ++k) {
    clock.sleep_until(tick_time({1000, 1}, k));
    const std::lock_guard lock(shared.mutex);
    shared.position_m = kSpeed_m_per_s * seconds(clock.now());  // a real device would be sent force_N here
  }
}
void simulation_loop(BlockingClock& clock, Shared& shared) {
  for (std::int64_t segment = 0;; ++segment) {
    clock.sleep_until(tick_time({30, 1}, segment));
    gpu_works(clock, kVisualization);
    for (int n = 0; n < 15; ++n) {
      const double x_m = shared.read();
      gpu_works(clock, kStep);
      const std::lock_guard lock(shared.mutex);
      shared.force_N = -200 * x_m;
    }
  }
}

std::uint64_t run_virtual(Shared& shared) {
  VirtualClock clock;
  InlineExecutor executor;
  Scheduler scheduler(clock, executor);
  SteppedThread haptic(scheduler, {.name = "tick", .lane = Lane::device}, [&](auto& time) { haptic_loop(time, shared); });
  SteppedThread steps(scheduler, {.name = "step"}, [&](auto& time) { simulation_loop(time, shared); });
  const RunStatus status = scheduler.run(kEnd);
  if (status.end != RunEnd::reached_end) std::printf("%s\n", status.message.c_str());
  std::printf("in virtual time: velocity jump %.2f steps, trace %016" PRIx64 "\n", shared.jump_steps,
              scheduler.trace_hash());
  return scheduler.trace_hash();
}
void run_wall(Shared& shared) {
  const WallEpoch epoch = WallEpoch::in({1'000'000});
  WallThread haptic(epoch, kEnd, [&](auto& time) { haptic_loop(time, shared); });
  WallThread steps(epoch, kEnd, [&](auto& time) { simulation_loop(time, shared); });
  haptic.join();
  steps.join();
}

int main(int argc, char**) {
  Shared shared, again;
  if (argc > 1) run_wall(shared);
  if (argc > 1) return std::printf("in real time: velocity jump %.2f steps\n", shared.jump_steps) < 0;
  const bool same = run_virtual(shared) == run_virtual(again);
  return same && std::abs(shared.jump_steps - 5.4) < 1e-9 ? 0 : 1;
}
