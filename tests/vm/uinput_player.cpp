/// uinput_player MILLISECONDS VELOCITY_UM_PER_S : simulates a force feedback device on the kernel's own input core, with 1 m
/// of travel in 2^31 counts. Its hand moves evenly along x. It prints the node, reports a thousand times a second for
/// MILLISECONDS, at uneven intervals of 0.4 ms to 2 ms, then says what came back. A report has the position of the hand at
/// the moment of the report.

#include <sched.h>
#include <time.h>

#include <cstdio>
#include <cstdlib>

#include "uinput_device.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fputs("uinput_player MILLISECONDS VELOCITY_UM_PER_S\n", stderr), 2;
  const long reports = std::atol(argv[1]), velocity_um = std::atol(argv[2]);
  constexpr int kMost = 1 << 30;
  UinputDevice device(kMost);
  std::printf("%s\n", device.node().c_str());
  std::fflush(stdout);
  // This program stands for hardware, which waits for nobody. Without the right to this priority it may be late.
  const sched_param first{60};
  sched_setscheduler(0, SCHED_FIFO, &first);
  timespec began{}, now{};
  clock_gettime(CLOCK_MONOTONIC, &began);
  for (long k = 0; k < reports; ++k) {
    // Reports are late by 0 to 1.26 ms. Wherever the ticks are, the events that they read differ in age by 0.84 ms or more.
    const long long at_ns = began.tv_nsec + (k + 1LL) * 1'000'000 + 140'000 * (k * 3 % 10);
    const timespec at{began.tv_sec + at_ns / 1'000'000'000, static_cast<long>(at_ns % 1'000'000'000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
    }
    clock_gettime(CLOCK_MONOTONIC, &now);
    const double elapsed_s =
        static_cast<double>(now.tv_sec - began.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec - began.tv_nsec);
    device.report(static_cast<int>(elapsed_s * static_cast<double>(velocity_um) * 1e-6 * 2 * kMost), 0);
  }
  const UinputDevice::Told told = device.told();
  std::printf("%ld reports out, %s uploads in, levels of x from %d to %d; left: %zu effects\n", reports,
              told.uploads > 100 ? "more than 100" : "too few", told.least_level, told.most_level, told.effects.size());
}
