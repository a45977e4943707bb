#pragma once
/// What the drivers have in common: taking the reports of a tick, sending a report, and stopping a device.

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "../surely.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hid_transport.h"

namespace evenstep::internal {

/// A limit, so that a device that reports faster than it is read cannot hang the tick. It is 16 times what any known queue
/// holds. An empty hidapi read takes 0.3 to 0.6 us (docs/devices/reference-device.md), so this is about half of a 1 ms tick.
inline constexpr int kMaxReadsPerTick = 1024;

[[noreturn]] inline void throw_gone(const HidTransport& transport) {
  const HidDeviceInfo& info = transport.info();
  throw DeviceError(info.path + ": device '" + info.product + "' is gone (unplugged or reset); plug it in and run again");
}

/// Passes every waiting report to `take`, cut to the size of the buffer; calls `returned` if the device is back. False: the
/// device is away. Throws DeviceError if it is gone.
template <class Take, class Returned>
bool drain(HidTransport& transport, std::span<std::byte> buffer, Take take, Returned returned) {
  for (int reads = 0; reads < kMaxReadsPerTick; ++reads) {
    const HidRead got = transport.read(buffer);
    switch (got.status) {
      case HidRead::Status::gone:
        throw_gone(transport);
      case HidRead::Status::nothing:
        return true;
      case HidRead::Status::away:
        return false;
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
  return true;
}

/// Whether the device accepted the report; a refusal is counted. Throws DeviceError if the device is gone.
inline bool is_taken(HidWrite sent, const HidTransport& transport, DeviceCounters& counters) {
  if (sent == HidWrite::gone) throw_gone(transport);
  if (sent == HidWrite::rejected) ++counters.write_failures;
  return sent == HidWrite::ok;
}

/// How many reports, taken at first, have been refused since the last call; adds them to the counters.
inline std::int64_t new_refusals(const HidTransport& transport, std::int64_t& seen, DeviceCounters& counters) {
  const std::int64_t refused = transport.refused_later();
  const std::int64_t since = refused - std::exchange(seen, refused);
  counters.write_failures += since;
  return since;
}

/// Sends a report and waits until its outcome is known; a refused report is tried three times. Too slow for ticks.
inline HidWrite send_surely(HidTransport& transport, std::span<const std::byte> report) {
  constexpr int kTries = 3;
  HidWrite sent = HidWrite::rejected;
  for (int tries = 0; tries < kTries && sent == HidWrite::rejected; ++tries) {
    const std::int64_t before = transport.refused_later();
    sent = transport.write(report);
    if (sent == HidWrite::ok) transport.wait_until_sent();
    if (sent == HidWrite::ok && transport.refused_later() != before) sent = HidWrite::rejected;
  }
  return sent;
}

/// Sends a report that a device must get before it is left alone; a failure is ignored.
inline void try_to_send(HidTransport& transport, std::span<const std::byte> report) noexcept {
  surely([&] { send_surely(transport, report); });
}

}  // namespace evenstep::internal
