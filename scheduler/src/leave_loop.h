#pragma once
/// How a loop that blocks is told that its run is over.

#include <exception>

#include "evenstep/scheduler/blocking_clock.h"

namespace evenstep::internal {

inline void leave_loop() {
  if (std::uncaught_exceptions() == 0) throw Stopped{};  // thrown out of a destructor it would end the program
}

}  // namespace evenstep::internal
