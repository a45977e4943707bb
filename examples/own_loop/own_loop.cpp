// Own devices, solver and coroutines under evenstep's clock: two arms at 1 kHz, and 15 steps after each visualization of
// 11.1 ms, 30 times a second (the paper's figure 1). `own_loop` runs in virtual time, `own_loop wall` in real time.
#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <utility>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/scheduler/live_lanes.h"
#include "evenstep/scheduler/scheduler.h"
using namespace evenstep;

constexpr Duration kVisualization{11'100'000}, kStep{1'482'222};
constexpr double kSpeed_m_per_s = 0.1;

struct Arm {
  double position_m = 0, force_N = 0;
  void exchange(RealTime now) { position_m = kSpeed_m_per_s * seconds(now); }  // a real one would send force_N, too
};
struct Spring final : Work {
  double position_m[2] = {}, force_N[2] = {};
  void run() override {
    std::transform(position_m, position_m + 2, force_N, [](double x) { return -200 * x; });
  }
};
struct Jump {  // the largest change of velocity that the physics sees, in units of the even motion per step
  double before_m = 0, last_m = 0, steps = 0;
  int reads = 0;
  void add(double x_m) {
    const double change_m = std::abs(x_m - 2 * last_m + before_m);
    if (++reads > 2) steps = std::max(steps, change_m / (kSpeed_m_per_s * period_s({450, 1})));
    before_m = std::exchange(last_m, x_m);
  }
};

Task haptic_lane(Scheduler& scheduler, Arm& arm) {
  for (std::int64_t k = 0;; ++k) {
    co_await scheduler.until(tick_time({1000, 1}, k), Lane::device, "tick");
    arm.exchange(scheduler.now());
    scheduler.note(arm.force_N);
  }
}
Task simulation_lane(Scheduler& scheduler, Arm (&arms)[2], Jump& jump) {
  Spring spring;
  for (std::int64_t segment = 0;; ++segment) {
    RealTime end = tick_time({30, 1}, segment) + kVisualization;
    co_await scheduler.external(end, nullptr, "visualization");
    for (int n = 0; n < 15; ++n) {
      co_await scheduler.turn(Lane::launch, "launch");  // so that a tick at this instant comes first
      for (const int i : {0, 1}) spring.position_m[i] = arms[i].position_m;
      jump.add(arms[0].position_m);
      end = end + kStep;
      co_await scheduler.external(end, &spring, "step");
      for (const int i : {0, 1}) arms[i].force_N = (1 + i) * spring.force_N[i];
    }
  }
}

std::uint64_t run(const char* name, Clock& clock, Executor& executor, Jump& jump, SchedulerOptions options = {}) {
  Arm arms[2];
  Scheduler scheduler(clock, executor, options);
  for (Arm& arm : arms) scheduler.spawn(haptic_lane(scheduler, arm));
  scheduler.spawn(simulation_lane(scheduler, arms, jump));
  scheduler.run({1'000'000'000});
  std::printf("%s: velocity jump %.2f steps, trace %016" PRIx64 "\n", name, jump.steps, scheduler.trace_hash());
  return scheduler.trace_hash();
}

int main(int argc, char**) {
  Jump jump, again, permuted;
  WallClock wall(WallEpoch::in({1'000'000}));
  WorkerExecutor worker(wall);
  if (argc > 1) return run("in real time", wall, worker, jump) == 0;
  VirtualClock clocks[3];
  InlineExecutor executor;
  const std::uint64_t hash = run("in virtual time", clocks[0], executor, jump);
  const bool same = run("once more", clocks[1], executor, again) == hash;
  const bool other = run("ties permuted", clocks[2], executor, permuted, {.permute_ties = 1}) != hash;
  return same && other && std::abs(jump.steps - 5.4) < 1e-9 && permuted.steps == jump.steps ? 0 : 1;
}
