#pragma once
/// What the drivers have in common: taking the reports of a tick, sending a report, and stopping a device.

#include <algorithm>
#include <cstddef>
#include <span>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hid_transport.h"

namespace evenstep::internal {

/// A limit, so that a device that reports faster than it is read cannot hang the tick. It is 16 times what any known queue
/// holds. An empty hidapi read takes 0.3 to 0.6 us (docs/reference-device.md), so this is about half of a 1 ms tick.
inline constexpr int kMaxReadsPerTick = 1024;

[[noreturn]] inline void throw_gone(const HidTransport& transport) {
  const HidDeviceInfo& info = transport.info();
  throw DeviceError(info.path + ": device '" + info.product + "' is gone (unplugged or reset); plug it in and run again");
}

/// Passes every waiting report to `take`, cut to the size of the buffer; calls `returned` if the device is back. Throws
/// DeviceError if the device is gone.
template <class Take, class Returned>
void drain(HidTransport& transport, std::span<std::byte> buffer, Take take, Returned returned) {
  for (int reads = 0; reads < kMaxReadsPerTick; ++reads) {
    const HidRead got = transport.read(buffer);
    switch (got.status) {
      case HidRead::Status::gone:
        throw_gone(transport);
      case HidRead::Status::nothing:
        return;
      case HidRead::Status::interrupted:  // by a signal; the device is still there
        break;
      case HidRead::Status::returned:
        returned();
        break;
      case HidRead::Status::report:
        take(std::span<const std::byte>(buffer).first(std::min(got.size, buffer.size())));
        break;
    }
  }
}

/// Whether the device accepted the report; a refusal is counted. Throws DeviceError if the device is gone.
inline bool is_taken(HidWrite sent, const HidTransport& transport, DeviceCounters& counters) {
  if (sent == HidWrite::gone) throw_gone(transport);
  if (sent == HidWrite::rejected) ++counters.write_failures;
  return sent == HidWrite::ok;
}

/// Sends a report that a device must get before it is left alone. It is tried three times; a failure is then ignored.
inline void try_to_send(HidTransport& transport, std::span<const std::byte> report) noexcept {
  constexpr int kTries = 3;
  try {
    for (int tries = 0; tries < kTries && transport.write(report) == HidWrite::rejected; ++tries) continue;
  } catch (...) {  // a simulated hand may have diverged, but the device must be stopped nevertheless
  }
}

}  // namespace evenstep::internal
