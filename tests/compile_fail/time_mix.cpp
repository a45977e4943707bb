// One snippet, chosen by -DCASE=n; every one but 0 must fail to compile (CMakeLists.txt says with which words).
#include <cstdint>

#include "evenstep/time/time.h"

using namespace evenstep;

int takes_real_time(RealTime) { return 0; }

int main() {
  [[maybe_unused]] RealTime real{1};
  [[maybe_unused]] SimTime sim{1};
  [[maybe_unused]] Duration duration{1};
  [[maybe_unused]] const std::int64_t nanoseconds = 1;
#if CASE == 0
  real = real + duration - duration;
  duration = real - real + duration * 3;
  sim = sim_time({450, 1}, 7);
  return takes_real_time(real) + (real < kNever) + (sim == SimTime{7}) + (duration > Duration{nanoseconds});
#elif CASE == 1
  static_cast<void>(real - sim);
#elif CASE == 2
  static_cast<void>(sim - real);
#elif CASE == 3
  static_cast<void>(sim + duration);
#elif CASE == 4
  real = sim;
#elif CASE == 5
  static_cast<void>(sim - sim);
#elif CASE == 6
  static_cast<void>(real + real);
#elif CASE == 7
  const RealTime from_seconds = 0.5;
#elif CASE == 8
  static_cast<void>(real + nanoseconds);
#elif CASE == 9
  static_cast<void>(real < sim);
#elif CASE == 10
  static_cast<void>(real == sim);
#elif CASE == 11
  takes_real_time(sim);
#elif CASE == 12
  const RealTime from_duration = duration;
#elif CASE == 13
  const Duration from_integer = nanoseconds;
#elif CASE == 14
  const double fraction = real.ns * 0.5;
  const RealTime from_fraction{fraction};
#elif CASE == 15
  const SimTime from_real = real;
#else
#error no such case
#endif
}
