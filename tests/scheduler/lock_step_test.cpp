#include <memory>

#include "rig.h"

namespace evenstep::test {
namespace {

/// The data between the two lanes of a haptic loop: instants with values, for one writer and one reader, never cleared.
struct TimedRing {
  std::vector<std::pair<RealTime, double>> entries;
  void push(RealTime at, double value) { entries.emplace_back(at, value); }
  double newest_at(RealTime at) const {  // 0 before the first
    double value = 0;
    for (const auto& [time, v] : entries) {
      if (time <= at) value = v;
    }
    return value;
  }
};

struct Loop {
  std::uint64_t seed;
  TimedRing samples;
  TimedRing forces;
  CountingWork work;
};

Task device_lane(Scheduler& scheduler, Loop& loop) {
  for (int k = 0; k < 60; ++k) {
    co_await scheduler.until({k * 100}, Lane::device, "tick");
    const double force = loop.forces.newest_at(scheduler.now());
    loop.samples.push(scheduler.now(), 0.01 * k - 0.3 * force);
    scheduler.note(force);
    scheduler.note(static_cast<std::uint64_t>(loop.forces.entries.size()));
  }
}

Task simulation_lane(Scheduler& scheduler, Loop& loop) {
  RealTime end{0};
  for (std::uint64_t n = 0; n < 60; ++n) {
    co_await scheduler.turn(Lane::launch, "launch");
    const RealTime read{scheduler.now().ns - 10 * draw(loop.seed, 2 * n, 20)};
    const double position = loop.samples.newest_at(read);
    scheduler.note(position);
    scheduler.note(static_cast<std::uint64_t>(loop.samples.entries.size()));
    // Steps are multiples of 20 ns, also 0 ns, and ticks are 100 ns apart. So a fifth of the launches ties with a tick.
    end = RealTime{scheduler.now().ns + 20 * draw(loop.seed, 2 * n + 1, 10)};
    co_await scheduler.external(end, &loop.work, "step");
    loop.forces.push(scheduler.now() + Duration{40}, position + 0.001 * static_cast<double>(n));
  }
}

bool sorts_before(const Scheduler::Key& a, const Scheduler::Key& b) {
  return std::pair(a.time, a.lane) < std::pair(b.time, b.lane);
}

/// Always runs the scheduler whose next event comes first; if the keys are equal, the first scheduler.
void run_in_lock_step(Scheduler& a, Scheduler& b) {
  for (;;) {
    const auto key_a = a.next();
    const auto key_b = b.next();
    if (!key_a && !key_b) return;
    const bool b_first = key_b && (!key_a || sorts_before(*key_b, *key_a));
    REQUIRE((b_first ? b : a).run_one());
  }
}

TEST_CASE(
    "Two lanes on two schedulers in lock step give the merged events and the chain of one scheduler, 1000 random "
    "schedules") {
  int ties = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Loop one{.seed = seed};
    VirtualRig together;
    together.scheduler.spawn(device_lane(together.scheduler, one));
    together.scheduler.spawn(simulation_lane(together.scheduler, one));
    REQUIRE(together.scheduler.run(kNever).end == RunEnd::idle);

    Loop two{.seed = seed};
    VirtualRig device;
    VirtualRig simulation;
    device.scheduler.spawn(device_lane(device.scheduler, two));
    simulation.scheduler.spawn(simulation_lane(simulation.scheduler, two));
    run_in_lock_step(device.scheduler, simulation.scheduler);

    const std::vector<Event> merged = merge(device.scheduler.events(), simulation.scheduler.events());
    const std::vector<Event>& events = together.scheduler.events();
    REQUIRE(merged.size() == events.size());
    for (std::size_t i = 0; i < merged.size(); ++i) {
      REQUIRE(chain(0, merged[i]) == chain(0, events[i]));
      if (i > 0 && events[i].time == events[i - 1].time && events[i].lane != events[i - 1].lane) ++ties;
    }
    REQUIRE(chain(merged) == together.scheduler.trace_hash());
    REQUIRE(chain(merge(simulation.scheduler.events(), device.scheduler.events())) == chain(merged));
  }
  CHECK(ties > 10'000);  // the schedules really have ties
}

}  // namespace
}  // namespace evenstep::test
