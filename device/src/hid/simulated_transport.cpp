#include "evenstep/device/hid/simulated_transport.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace evenstep {
namespace {

constexpr std::int64_t kHidrawDepth = 63;
constexpr std::int64_t kLibusbDepth = 32;

/// The newest tick at or before `at`; -1 or less where there is none.
std::int64_t newest_tick(const SimulatedDeviceOptions& options, RealTime at) {
  return first_tick_at_or_after(options.rate, at + Duration{1}, options.first_tick) - 1;
}

reference_device::InputReport report_of(std::int64_t tick, const std::array<std::int32_t, 3>& position_nm,
                                        const SimulatedDeviceOptions& options) {
  const RealTime at = tick_time(options.rate, tick, options.first_tick);
  return {static_cast<std::uint32_t>(tick + 1), static_cast<std::uint32_t>(floor_mul_div(at.ns, 1, 1000)), position_nm};
}

glm::dvec3 force_of(const reference_device::OutputReport& report) {
  return {report.force_uN[0] / 1e6, report.force_uN[1] / 1e6, report.force_uN[2] / 1e6};
}

}  // namespace

SimulatedTransport::SimulatedTransport(const Clock& clock, ProgrammedMotion motion, SimulatedDeviceOptions options)
    : clock_(clock),
      motion_(std::move(motion)),
      options_(std::move(options)),
      info_{options_.name, reference_device::kVendorId, reference_device::kProductId, "evenstep reference device", ""} {
  // One report per ns at most, or two ticks would fall on one instant.
  assert(options_.rate.num > 0 && options_.rate.den > 0 && options_.rate.num / options_.rate.den <= 1'000'000'000);
}

SimulatedTransport::SimulatedTransport(const Clock& clock, Hand hand, SimulatedDeviceOptions options)
    : SimulatedTransport(clock, ProgrammedMotion{}, std::move(options)) {
  assert(options_.force_delay.ns >= 0);
  hand_ = std::move(hand);
}

glm::dvec3 SimulatedTransport::position_at(std::int64_t tick) {
  const RealTime at = tick_time(options_.rate, tick, options_.first_tick);
  if (!hand_) return position_m(motion_, at);
  try {
    return hand_->position_m(at);
  } catch (const HandDiverged& diverged) {
    throw HandDiverged(options_.name + ": " + diverged.what(), diverged.at);
  }
}

HidRead SimulatedTransport::read(std::span<std::byte> buffer) {
  advance();
  if (gone_) return {HidRead::Status::gone};
  if (queue_.empty()) return {HidRead::Status::nothing};
  const auto bytes = reference_device::encode(report_of(queue_.front().tick, queue_.front().position_nm, options_));
  queue_.pop_front();
  std::copy_n(bytes.begin(), std::min(bytes.size(), buffer.size()), buffer.begin());
  return {HidRead::Status::report, bytes.size()};
}

HidWrite SimulatedTransport::write(std::span<const std::byte> report) {
  advance();
  if (gone_) return HidWrite::gone;
  const auto decoded = reference_device::decode_output(report);
  if (!decoded) return HidWrite::rejected;
  output_ = *decoded;
  if (hand_) hand_->feel(clock_.now() + options_.force_delay, force_of(output_));
  return HidWrite::ok;
}

/// Nobody reads between two calls, so which of the new ticks the queue keeps is arithmetic: the first that fit (hidraw), or
/// the last ones (libusb). A stall of any length costs at most one queue of work, and a hand its
/// motion until then.
void SimulatedTransport::advance() {
  const std::int64_t newest = newest_tick(options_, clock_.now());
  if (options_.unplug_at_tick >= 0 && newest >= options_.unplug_at_tick) gone_ = true;
  if (gone_ || newest < next_tick_) return;
  const std::int64_t arrived = newest - next_tick_ + 1;
  const auto queued = static_cast<std::int64_t>(queue_.size());
  std::int64_t first_kept = next_tick_;
  std::int64_t kept = arrived;
  if (options_.queue == QueuePolicy::hidraw) {
    kept = std::min(arrived, kHidrawDepth - queued);
    dropped_ += arrived - kept;
  } else {
    kept = std::min(arrived, kLibusbDepth);
    first_kept = newest - kept + 1;
    const std::int64_t pushed_out = std::max<std::int64_t>(0, queued + kept - kLibusbDepth);
    queue_.erase(queue_.begin(), queue_.begin() + pushed_out);
    dropped_ += pushed_out + arrived - kept;
  }
  for (std::int64_t tick = first_kept; tick < first_kept + kept; ++tick) {
    queue_.push_back({tick, reference_device::to_nm(position_at(tick))});
  }
  if (hand_) position_at(newest);  // it moves on, whatever becomes of the report
  next_tick_ = newest + 1;
}

std::span<const std::byte> SimulatedTransport::report_descriptor() const { return reference_device::report_descriptor(); }

}  // namespace evenstep
