#include "evenstep/device/hid/reference_driver.h"

#include <array>
#include <cassert>
#include <cmath>
#include <span>

#include "evenstep/device/hid/reference_device.h"
#include "report_exchange.h"

namespace evenstep {
namespace {

/// Leaves room for data that a newer firmware might append. An even longer report is cut, but its head is complete.
constexpr std::size_t kBufferSize = 64;
static_assert(kBufferSize >= reference_device::kInputSize);

/// No known queue holds more (hidraw: 64 slots). A report that is older than the newest by at most this is late or repeated;
/// if it is even older, the device has started to count anew.
constexpr std::int32_t kDeepestQueue = 64;

}  // namespace

ReferenceDriver::ReferenceDriver(HidTransport& transport) : transport_(transport) {}

DeviceSample ReferenceDriver::read(RealTime now) {
  last_.read_at = now;
  last_.fresh = false;
  std::array<std::byte, kBufferSize> buffer;
  internal::drain(
      transport_, buffer, [&](std::span<const std::byte> report) { take(report); }, [&] { any_report_ = false; });
  if (!last_.fresh) ++counters_.stale;
  internal::new_refusals(transport_, refusals_seen_, counters_);  // counted only: every tick sends its force
  return last_;
}

void ReferenceDriver::take(std::span<const std::byte> bytes) {
  const auto report = reference_device::decode_input(bytes);
  if (!report) {
    ++counters_.malformed;
    return;
  }
  ++counters_.reports;
  // Computed modulo 2^32, so that the count may wrap around; positive means newer.
  const auto ahead = static_cast<std::int32_t>(report->sequence - last_.sequence);
  if (any_report_ && ahead <= 0 && ahead >= -kDeepestQueue) return;
  if (any_report_ && ahead > 1) counters_.lost += ahead - 1;
  any_report_ = true;
  last_.sequence = report->sequence;
  last_.fresh = true;
  for (int axis = 0; axis < 3; ++axis) last_.position_m[axis] = report->position_nm[static_cast<std::size_t>(axis)] / 1e9;
}

void ReferenceDriver::write(const glm::dvec3& force_N) {
  assert(std::isfinite(force_N.x) && std::isfinite(force_N.y) && std::isfinite(force_N.z));
  const auto bytes = reference_device::encode({++output_sequence_, reference_device::to_uN(force_N)});
  internal::is_taken(transport_.write_newest(bytes), transport_, counters_);
}

void ReferenceDriver::stop() noexcept {
  internal::try_to_send(transport_, reference_device::encode(reference_device::OutputReport{++output_sequence_, {}}));
}

}  // namespace evenstep
