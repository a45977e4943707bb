#include "evenstep/scheduler/loop_clock.h"

#include <stdexcept>

#include "src/loop_thread.h"

namespace evenstep {
namespace {

BlockingClock& clock_of_loop() {
  if (internal::clock_of_this_thread == nullptr)
    throw std::logic_error("LoopClock: this thread runs no loop; it must be that of a SteppedThread or a WallThread");
  return *internal::clock_of_this_thread;
}

}  // namespace

LoopClock::time_point LoopClock::now() { return time_point(duration(clock_of_loop().now().ns)); }
void LoopClock::sleep_until(time_point at) { clock_of_loop().sleep_until({at.time_since_epoch().count()}); }

}  // namespace evenstep
