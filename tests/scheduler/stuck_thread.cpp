// A stepped thread that nothing can end. The program says so and terminates, instead of waiting for ever.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/scheduler/stepped_thread.h"

using namespace evenstep;

int main() {
  std::set_terminate([] { std::_Exit(3); });  // ctest would take the signal of abort() for a failure
  std::atomic<bool> never{false};
  VirtualClock clock;
  InlineExecutor executor;
  Scheduler scheduler(clock, executor);
  const SteppedThread loop(scheduler, {.name = "haptic", .real_time_limit = Duration{20'000'000}}, [&](BlockingClock& time) {
    time.sleep_until({100});
    never.wait(false);
  });
  const RunStatus status = scheduler.run(kNever);
  std::fprintf(stderr, "run: %s\n", status.message.c_str());
}
