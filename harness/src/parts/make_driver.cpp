#include "make_driver.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <functional>
#include <numeric>
#include <utility>

#include "evenstep/device/evdev/simulated_evdev.h"
#include "evenstep/device/hid/pid_driver.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_board.h"
#include "evenstep/device/hid/simulated_pid_device.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "evenstep/device/inverse3/simulated_inverse3.h"
#include "evenstep/scheduler/random.h"
#include "registered_device.h"
#include "src/live/read_only_device.h"

namespace evenstep::internal {
namespace {

/// A `Device` that is held by a hand that feels the force, or that follows a programmed motion.
template <class Device, class Options>
std::unique_ptr<Device> under_hand(const DeviceSpec& device, const Clock& clock, const Options& options) {
  if (device.hand) return std::make_unique<Device>(clock, Hand(*device.hand, device.motion), options);
  return std::make_unique<Device>(clock, device.motion, options);
}

DeviceError refusal(const HidTransport& transport, const std::string& why) {
  const HidDeviceInfo& info = transport.info();
  return DeviceError(
      fmt::format("{}: '{}' ({:04x}:{:04x}): {}", info.path, info.product, info.vendor_id, info.product_id, why));
}

/// The rate of the device's ticks, measured by the host's clock.
Rate rate_by_host(Rate rate, std::int64_t clock_ppm) {
  if (clock_ppm == 0) return rate;
  constexpr std::int64_t kMillion = 1'000'000;
  const std::int64_t num = rate.num * (kMillion + clock_ppm), den = rate.den * kMillion;
  const std::int64_t common = std::gcd(num, den);
  return {num / common, den / common};
}

std::function<Duration(std::int64_t)> age_of(const DeviceSpec& device) {
  const ReportAge& age = device.age;
  if (age.least.ns == 0 && age.jitter.ns == 0) return nullptr;
  return [least = age.least, jitter = age.jitter,
          stream = RandomStream(age.seed, device.name + ".report_age")](std::int64_t tick) {
    const auto choices = static_cast<std::uint64_t>(jitter.ns) + 1;
    return least + Duration{static_cast<std::int64_t>(stream.below(static_cast<std::uint64_t>(tick), choices))};
  };
}

SimulatedDeviceOptions simulated_options(const DeviceSpec& device) {
  SimulatedDeviceOptions options{.rate = rate_by_host(device.rate, device.age.clock_ppm),
                                 .first_tick = RealTime{device.phase.ns},
                                 .queue = device.queue,
                                 .force_delay = device.force_delay,
                                 .age = age_of(device),
                                 .clock_rate = device.rate,
                                 .name = device.name,
                                 .faults = device.faults};
  if (device.unplug)
    options.unplug_at_tick = first_tick_at_or_after(device.rate, RealTime{device.unplug->ns}, options.first_tick);
  if (device.returns)
    options.return_at_tick = first_tick_at_or_after(device.rate, RealTime{device.returns->ns}, options.first_tick);
  return options;
}

/// What simulated devices that play effects have in common.
template <class Options, class Spec>
Options simulated_effects(const Spec& spec, const DeviceSpec& device) {
  Options options;
  options.reports = simulated_options(device);
  options.travel_m = spec.options.travel_m;
  options.full_scale_N = spec.options.full_scale_N.value_or(options.full_scale_N);
  options.full_slope_N_per_m = spec.options.full_slope_N_per_m;
  options.firmware_rate = spec.firmware_rate;
  return options;
}

std::unique_ptr<SimulatedDevice> simulated_board(const PidSpec& spec, const DeviceSpec& device, const Clock& clock) {
  auto board = simulated_effects<SimulatedBoardOptions>(spec, device);
  board.kind = *spec.board;
  board.pool_effects = spec.pool_effects;
  board.block_load_error_at = spec.block_load_error_at;
  board.events = spec.events;
  return under_hand<SimulatedBoard>(device, clock, board);
}

// For each alternative of DriverSpec, its simulated device and its driver.

std::unique_ptr<SimulatedDevice> simulated(const ReferenceSpec&, const DeviceSpec& device, const Clock& clock) {
  return under_hand<SimulatedTransport>(device, clock, simulated_options(device));
}

std::unique_ptr<HapticDevice> driver(const ReferenceSpec&, const DeviceSpec& device, HidTransport& transport) {
  const HidDeviceInfo& info = transport.info();
  if (info.vendor_id != reference_device::kVendorId || info.product_id != reference_device::kProductId) {
    throw refusal(
        transport,
        "not a reference device; one that `evenstep devices` calls PID needs driver = \"pid\" and its travel and full "
        "scale in pid = { ... }");
  }
  return std::make_unique<ReferenceDriver>(
      transport, follows_clock(device) ? std::optional(DeviceClock(device.age.least)) : std::nullopt);
}

std::unique_ptr<SimulatedDevice> simulated(const PidSpec& spec, const DeviceSpec& device, const Clock& clock) {
  if (spec.board) return simulated_board(spec, device, clock);
  auto pid = simulated_effects<SimulatedPidOptions>(spec, device);
  pid.descriptor.flavour = spec.flavour;
  pid.descriptor.axes = spec.options.travel_m.z > 0 ? 3 : 2;
  pid.events = spec.events;
  pid.pool_effects = spec.pool_effects;
  pid.block_load_error_at = spec.block_load_error_at;
  return under_hand<SimulatedPidDevice>(device, clock, pid);
}

std::unique_ptr<HapticDevice> driver(const PidSpec& spec, const DeviceSpec&, HidTransport& transport) {
  const auto parsed = parse_report_descriptor(transport.report_descriptor());
  if (!parsed)
    throw refusal(transport,
                  fmt::format("byte {} of its report descriptor: {}", parsed.error().offset, parsed.error().message));
  auto layout = pid_layout(*parsed);
  if (!layout)
    throw refusal(transport, fmt::format("driver = \"pid\", but its reports lack {}", fmt::join(layout.error(), ", ")));
  auto pid = std::make_unique<PidDriver>(transport, *std::move(layout), spec.options);
  if (pid->is_read_only()) return std::make_unique<ReadOnlyDevice>(std::move(pid));
  return pid;
}

std::unique_ptr<SimulatedEvdev> simulated_evdev(const EvdevSpec& spec, const DeviceSpec& device, const Clock& clock) {
  auto options = simulated_effects<SimulatedEvdevOptions>(spec, device);
  options.effects = spec.effects;
  options.foreign_effects = spec.foreign_effects;
  options.held = spec.held;
  options.meddled_at = spec.meddled_at;
  return under_hand<SimulatedEvdev>(device, clock, options);
}

std::unique_ptr<HapticDevice> driver(const EvdevSpec&, const DeviceSpec&, HidTransport& transport) {
  throw refusal(transport, "driver = \"evdev\" talks to /dev/input/event*, not to a HID transport");
}

std::unique_ptr<SimulatedInverse3> simulated_inverse3(const Inverse3Spec& spec, const DeviceSpec& device,
                                                      const Clock& clock) {
  SimulatedInverse3Options options;
  options.reports = simulated_options(device);
  options.origin_m = spec.options.origin_m;
  options.hold = spec.hold;
  options.in_use = spec.in_use;
  options.uncalibrated_at = spec.uncalibrated_at;
  return under_hand<SimulatedInverse3>(device, clock, options);
}

std::unique_ptr<HapticDevice> driver(const Inverse3Spec&, const DeviceSpec&, HidTransport& transport) {
  throw refusal(transport, "driver = \"inverse3\" talks to a service, ws://127.0.0.1:10001, not to a HID transport");
}

std::unique_ptr<HapticDevice> driver(const ForeignDriverSpec& spec, const DeviceSpec&, HidTransport& transport) {
  throw refusal(transport, fmt::format("the driver '{}' talks to no HID transport", spec.part.name));
}

template <class Spec>
SimulatedParts parts(const Spec& spec, const DeviceSpec& device, const Clock& clock) {
  std::unique_ptr<SimulatedDevice> below = simulated(spec, device, clock);
  std::unique_ptr<HapticDevice> above = driver(spec, device, *below);
  return {std::move(below), std::move(above)};
}

SimulatedParts parts(const EvdevSpec& spec, const DeviceSpec& device, const Clock& clock) {
  std::unique_ptr<SimulatedEvdev> below = simulated_evdev(spec, device, clock);
  std::unique_ptr<HapticDevice> above = make_evdev_driver(spec, device, *below);
  return {std::move(below), std::move(above)};
}

SimulatedParts parts(const Inverse3Spec& spec, const DeviceSpec& device, const Clock& clock) {
  std::unique_ptr<SimulatedInverse3> below = simulated_inverse3(spec, device, clock);
  std::unique_ptr<HapticDevice> above = make_inverse3_driver(spec, *below, "");
  return {std::move(below), std::move(above)};
}

SimulatedParts parts(const ForeignDriverSpec& spec, const DeviceSpec& device, const Clock& clock) {
  std::unique_ptr<SimulatedGrip> grip = make_grip(device, clock);
  std::unique_ptr<HapticDevice> above = make_foreign_device(spec, device, grip.get(), "");
  return {std::move(grip), std::move(above)};
}

}  // namespace

SimulatedParts make_simulated(const DeviceSpec& device, const Clock& clock) {
  return std::visit([&](const auto& spec) { return parts(spec, device, clock); }, device.driver);
}

std::unique_ptr<HapticDevice> make_driver(const DeviceSpec& device, HidTransport& transport) {
  return std::visit([&](const auto& spec) { return driver(spec, device, transport); }, device.driver);
}

std::unique_ptr<HapticDevice> make_evdev_driver(const EvdevSpec& spec, const DeviceSpec& device, EvdevNode& node,
                                                EvdevDriver** itself) {
  EvdevOptions options = spec.options;
  options.unchanged_age = unchanged_age_of(device);
  auto evdev = std::make_unique<EvdevDriver>(node, options);
  if (itself) *itself = evdev.get();
  if (evdev->is_read_only()) return std::make_unique<ReadOnlyDevice>(std::move(evdev));
  return evdev;
}

std::unique_ptr<HapticDevice> make_inverse3_driver(const Inverse3Spec& spec, Inverse3Link& link,
                                                   const std::string& device_id) {
  Inverse3Options options = spec.options;
  options.device_id = device_id;
  return std::make_unique<Inverse3Driver>(link, options);
}

}  // namespace evenstep::internal
