#include "evenstep/device/hid/simulated_transport.h"

#include <utility>

namespace evenstep {
namespace {

/// A device that was plugged in again counts its reports and its time from then on.
reference_device::InputReport report_of(const SimulatedReport& report, const SimulatedDeviceOptions& options,
                                        std::int64_t first) {
  const Rate clock_rate = options.clock_rate.num > 0 ? options.clock_rate : options.rate;
  const RealTime at = tick_time(clock_rate, report.tick - first, options.first_tick);
  return {.sequence = static_cast<std::uint32_t>(report.tick - first + 1),
          .device_time_us = static_cast<std::uint32_t>(floor_mul_div(at.ns, 1, 1000)),
          .position_nm = reference_device::to_nm(report.position_m)};
}

glm::dvec3 force_of(const reference_device::OutputReport& report) {
  return {report.force_uN[0] / 1e6, report.force_uN[1] / 1e6, report.force_uN[2] / 1e6};
}

}  // namespace

SimulatedTransport::SimulatedTransport(const Clock& clock, HeldBy by, SimulatedDeviceOptions options)
    : clock_(clock),
      reports_(std::move(by), std::move(options)),
      info_{reports_.options().name, reference_device::kVendorId, reference_device::kProductId, "evenstep reference device",
            ""} {}

bool SimulatedTransport::is_gone() {
  const RealTime now = clock_.now();
  reports_.advance(now);
  if (!reports_.take_returned()) return reports_.is_gone();
  motors_.lose(reports_.lost_at());
  output_ = {};
  first_tick_ = reports_.next_tick();
  has_returned_ = true;
  reports_.advance(now);
  return reports_.is_gone();
}

HidRead SimulatedTransport::read(std::span<std::byte> buffer) {
  if (is_gone()) return {reports_.is_away() ? HidRead::Status::away : HidRead::Status::gone};
  if (std::exchange(has_returned_, false)) return {HidRead::Status::returned};
  if (reports_.take_interruption()) return {HidRead::Status::interrupted};
  const auto report = reports_.take();
  if (!report) return {HidRead::Status::nothing};
  return deliver(*report, reference_device::encode(report_of(*report, reports_.options(), first_tick_)), buffer);
}

HidWrite SimulatedTransport::write(std::span<const std::byte> report) {
  const auto decoded = reference_device::decode_output(report);
  if (is_gone()) {
    if (decoded) motors_.ask_away(force_of(*decoded));
    return reports_.is_away() ? HidWrite::rejected : HidWrite::gone;
  }
  bool lost = false;
  if (!decoded || reports_.write_fault(lost) == HidWrite::rejected) return HidWrite::rejected;
  if (lost) return HidWrite::ok;
  output_ = *decoded;
  motors_.heard(clock_.now());
  motors_.render(clock_.now(), force_of(output_));
  reports_.feel(clock_.now(), force_of(output_));
  return HidWrite::ok;
}

MotorState SimulatedTransport::motors() {
  MotorState state;
  if (!is_gone()) {
    motors_.until(clock_.now());
    state.force_N = force_of(output_);
  }
  motors_.tell(state);
  return state;
}

std::span<const std::byte> SimulatedTransport::report_descriptor() const { return reference_device::report_descriptor(); }

}  // namespace evenstep
