#pragma once
/// What the drivers share: a tick's reports in, a report out, and the end of a device.

#include <algorithm>
#include <cstddef>
#include <span>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hid_transport.h"

namespace evenstep::internal {

/// A device that reports faster than it is read must not hang the tick. 16 times what any known queue holds; at the 0.3 to
/// 0.6 us of an empty hidapi read (docs/reference-device.md), about half of a 1 ms tick.
inline constexpr int kMaxReadsPerTick = 1024;

[[noreturn]] inline void throw_gone(const HidTransport& transport) {
  const HidDeviceInfo& info = transport.info();
  throw DeviceError(info.path + ": device '" + info.product + "' is gone (unplugged or reset); plug it in and run again");
}

/// Gives `take` every report that waits, as far as the buffer holds it; `returned` is called where the device is back. Throws
/// DeviceError where it is gone.
template <class Take, class Returned>
void drain(HidTransport& transport, std::span<std::byte> buffer, Take take, Returned returned) {
  for (int reads = 0; reads < kMaxReadsPerTick; ++reads) {
    const HidRead got = transport.read(buffer);
    switch (got.status) {
      case HidRead::Status::gone:
        throw_gone(transport);
      case HidRead::Status::nothing:
        return;
      case HidRead::Status::interrupted:  // by a signal: not unplugged
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

/// Whether the device took it; a refusal is counted. Throws DeviceError where it is gone.
inline bool is_taken(HidWrite sent, const HidTransport& transport, DeviceCounters& counters) {
  if (sent == HidWrite::gone) throw_gone(transport);
  if (sent == HidWrite::rejected) ++counters.write_failures;
  return sent == HidWrite::ok;
}

/// What a device must hear before it is left alone. Tried three times; that it fails is nobody's business any more.
inline void try_to_send(HidTransport& transport, std::span<const std::byte> report) noexcept {
  constexpr int kTries = 3;
  try {
    for (int tries = 0; tries < kTries && transport.write(report) == HidWrite::rejected; ++tries) continue;
  } catch (...) {  // a simulated hand may have left its world; the device has to be stopped all the same
  }
}

}  // namespace evenstep::internal
