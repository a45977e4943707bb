#include "evenstep/device/hid/reference_driver.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

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

/// Before the first report nothing is known; this age is older than any that a report can have (device_clock.h).
constexpr Duration kOlderThanAny{2'000'000'000};

/// A device that is farther away reports an end of the range (reference_device.h).
bool is_end_of_range(std::int32_t position_nm) {
  using Limits = std::numeric_limits<std::int32_t>;
  return position_nm == Limits::min() || position_nm == Limits::max();
}

}  // namespace

ReferenceDriver::ReferenceDriver(HidTransport& transport, std::optional<DeviceClock> clock)
    : transport_(transport), clock_(std::move(clock)) {}

DeviceSample ReferenceDriver::read(RealTime now) {
  last_.read_at = now;
  last_.fresh = false;
  if (clock_ && !last_.taken_at) last_.taken_at = now - kOlderThanAny;
  std::array<std::byte, kBufferSize> buffer;
  bool has_returned = false;
  const auto come_back = [&] {
    has_returned = true;
    begin_anew();
  };
  const bool is_here = internal::drain(
      transport_, buffer, [&](std::span<const std::byte> report) { take(report); }, come_back);
  last_.away = !is_here || has_returned;
  last_.drivable = !last_.away;
  if (!last_.fresh) ++counters_.stale;
  if (last_.fresh && clock_) clock_->passed_on(*last_.taken_at, now);
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
  if (any_report_ && ahead <= 0) begin_anew();
  if (clock_) last_.taken_at = clock_->taken(report->device_time_us, last_.read_at);
  any_report_ = true;
  last_.sequence = report->sequence;
  last_.fresh = true;
  for (int axis = 0; axis < 3; ++axis) last_.position_m[axis] = report->position_nm[static_cast<std::size_t>(axis)] / 1e9;
  last_.at_range = std::any_of(report->position_nm.begin(), report->position_nm.end(), is_end_of_range);
}

void ReferenceDriver::begin_anew() {
  any_report_ = false;
  if (clock_) clock_->restart();
}

double ReferenceDriver::largest_force_N() const { return std::numeric_limits<std::int32_t>::max() / 1e6; }

void ReferenceDriver::write(const glm::dvec3& force_N) {
  assert(std::isfinite(force_N.x) && std::isfinite(force_N.y) && std::isfinite(force_N.z));
  const auto bytes = reference_device::encode({++output_sequence_, reference_device::to_uN(force_N)});
  internal::is_taken(transport_.write_newest(bytes), transport_, counters_);
}

void ReferenceDriver::stop() noexcept {
  internal::try_to_send(transport_, reference_device::encode(reference_device::OutputReport{++output_sequence_, {}}));
}

}  // namespace evenstep
