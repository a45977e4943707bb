/// uhid_player RATE_HZ SECONDS VELOCITY_UM_PER_S: simulates the reference device on the kernel's own HID core. Its hand
/// moves evenly along x. It prints the node, sends reports at this rate for SECONDS, each up to 1.4 periods late, then says
/// what came back. Its clock is that of the machine.

#include <sched.h>
#include <time.h>

#include <cstdio>
#include <cstdlib>

#include "evenstep/device/hid/reference_device.h"
#include "uhid_device.h"

using namespace evenstep;

namespace {

// Wherever the ticks are between two reports, some reports are the newest at the first tick after they were taken, and some
// only at the second: the first of two in a row that are more than a period late.
constexpr int kLateTenths[] = {0, 10, 4, 14, 12, 8, 2, 6};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fputs("uhid_player RATE_HZ SECONDS VELOCITY_UM_PER_S\n", stderr), 2;
  const long rate = std::atol(argv[1]), seconds = std::atol(argv[2]), velocity = std::atol(argv[3]);
  UhidDevice::Spec spec;
  spec.report_descriptor.assign(reference_device::report_descriptor().begin(), reference_device::report_descriptor().end());
  UhidDevice device(spec);
  std::printf("%s\n", device.node().c_str());
  std::fflush(stdout);
  // This program stands for hardware, which waits for nobody. Without the right to this priority it may be late.
  const sched_param first{60};
  sched_setscheduler(0, SCHED_FIFO, &first);
  timespec began{};
  clock_gettime(CLOCK_MONOTONIC, &began);
  const long period_ns = 1'000'000'000 / rate;
  for (long k = 0; k < rate * seconds; ++k) {
    const long long late_ns = period_ns / 10 * kLateTenths[k % 8];
    const long long at_ns = began.tv_nsec + (k + 1LL) * period_ns + late_ns;
    const timespec at{began.tv_sec + at_ns / 1'000'000'000, static_cast<long>(at_ns % 1'000'000'000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
    }
    const long long x_nm = static_cast<long long>(k) * velocity * 1000 / rate;
    device.send(reference_device::encode(reference_device::InputReport{static_cast<std::uint32_t>(k + 1),
                                                                       static_cast<std::uint32_t>(k * (period_ns / 1000)),
                                                                       {static_cast<std::int32_t>(x_nm), 0, 0}}));
  }
  long forces = 0, lost = 0, back = 0;
  std::uint32_t last_sequence = 0;
  std::int32_t most_uN = 0, last_uN = 0;
  for (const Bytes& bytes : device.outputs()) {
    const auto output = reference_device::decode_output(bytes);
    if (!output) continue;
    ++forces;
    lost += output->sequence - last_sequence - 1;
    last_sequence = output->sequence;
    last_uN = output->force_uN[0];
    most_uN = std::max(most_uN, std::abs(last_uN));
    back += output->force_uN[0] > 0;  // a spring that is pulled along +x pulls back
  }
  std::printf(
      "%ld reports out, %ld forces in, %ld of them lost on the way, %ld in the wrong direction; largest %d uN, last %d uN\n",
      rate * seconds, forces, lost, back, most_uN, last_uN);
}
