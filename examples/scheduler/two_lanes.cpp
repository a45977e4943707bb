/// A device that ticks at 1 kHz and a simulation that steps at 250 Hz, both in virtual time.
#include <cstdio>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/scheduler/scheduler.h"

using namespace evenstep;

Task every(Scheduler& scheduler, Duration period, Lane lane, EventName name, int& count) {
  for (RealTime at = RealTime{0} + period;; at = at + period) {
    co_await scheduler.until(at, lane, name);
    ++count;
  }
}

int main() {
  VirtualClock clock;
  InlineExecutor executor;
  Scheduler scheduler(clock, executor);
  int ticks = 0, steps = 0;
  scheduler.spawn(every(scheduler, Duration{1'000'000}, Lane::device, "tick", ticks));
  scheduler.spawn(every(scheduler, Duration{4'000'000}, Lane::launch, "step", steps));
  const RunStatus status = scheduler.run(RealTime{12'000'001});
  std::printf("%d ticks, %d steps, the last at %.6f ms\n", ticks, steps, static_cast<double>(scheduler.now().ns) * 1e-6);
  return status.end == RunEnd::reached_end ? 0 : 1;
}
