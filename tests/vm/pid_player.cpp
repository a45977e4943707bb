/// uhid_pid_player SECONDS VELOCITY_UM_PER_S TRAVEL_MM FULL_SCALE_N: simulates the force feedback device (mask flavour, 1
/// kHz) on the kernel's own HID core. Its hand moves evenly along x from the middle of the travel. It prints the node, runs
/// for SECONDS, then says what its motors did and what is left of the effects. Its clock is that of the machine.

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "uhid_pid_device.h"

using namespace evenstep;

int main(int argc, char** argv) {
  if (argc != 5) return std::fputs("uhid_pid_player SECONDS VELOCITY_UM_PER_S TRAVEL_MM FULL_SCALE_N\n", stderr), 2;
  const long seconds = std::atol(argv[1]);
  // This program stands for hardware, which waits for nobody. Without the right to this priority it may be late.
  const sched_param first{60};
  sched_setscheduler(0, SCHED_FIFO, &first);
  SimulatedPidOptions options;
  options.travel_m = glm::dvec3(static_cast<double>(std::atol(argv[3])) / 1e3);
  options.full_scale_N = static_cast<double>(std::atol(argv[4]));
  UhidPidDevice device(options, ConstantVelocity{{static_cast<double>(std::atol(argv[2])) / 1e6, 0, 0}});
  std::printf("%s\n", device.node().c_str());
  std::fflush(stdout);

  glm::dvec3 most_N{0}, least_N{0};
  int played = 0;
  timespec at{};
  clock_gettime(CLOCK_MONOTONIC, &at);
  for (long tick = 0; tick < seconds * 1000; ++tick) {
    at.tv_nsec += 1'000'000;
    if (at.tv_nsec >= 1'000'000'000) at.tv_nsec -= 1'000'000'000, ++at.tv_sec;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
    }
    device.report();
    const auto [force_N, playing] =
        device.look([](auto& firmware) { return std::pair(firmware.force_N(), firmware.playing()); });
    most_N = glm::max(most_N, force_N);
    least_N = glm::min(least_N, force_N);
    played = std::max(played, playing);
  }
  device.look([&](auto& firmware) {
    std::printf(
        "played %d effects, x from %.3f to %.3f N, y from %.3f to %.3f N; left: %d playing, %d allocated, actuators %s, "
        "%.3f N\n",
        played, least_N.x, most_N.x, least_N.y, most_N.y, firmware.playing(), firmware.allocated(),
        firmware.actuators_enabled() ? "on" : "off", glm::length(firmware.force_N()));
  });
}
