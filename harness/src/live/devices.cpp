#include "evenstep/harness/live_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <tuple>
#include <utility>

#include "evenstep/device/evdev/evdev_file.h"
#include "evenstep/device/evdev/live_evdev.h"
#include "evenstep/device/inverse3/inverse3_socket.h"
#include "evenstep/device/looked_for.h"
#include "evenstep/harness/simulated_devices.h"
#include "read_only_device.h"
#include "src/parts/make_driver.h"
#include "src/parts/registered_device.h"

namespace evenstep {
namespace {

const DeviceBinding* binding_of(const std::vector<DeviceBinding>& bindings, const Scenario& scenario, std::size_t tool) {
  for (const DeviceBinding& binding : bindings) {
    if (binding.name.empty() ? tool == 0 : binding.name == scenario.devices[tool].name) return &binding;
  }
  return nullptr;
}

/// The device node that a link made by udev leads to. (std::filesystem::equivalent does not work for devices.)
std::filesystem::path node_of(const std::string& path) {
  std::error_code endless;
  const std::filesystem::path node = std::filesystem::weakly_canonical(path, endless);
  return endless ? std::filesystem::path(path) : node;
}

std::map<std::string, double> write_time_counters(const DurationHistogram& taken) {
  if (taken.count() == 0) return {};
  return {{"write_time_p50", seconds(taken.quantile(500))},
          {"write_time_p99", seconds(taken.quantile(990))},
          {"write_time_max", seconds(taken.largest())}};
}

/// The counters of a HidapiTransport or a LiveEvdev, which send with a thread of their own.
template <class Sender>
std::map<std::string, double> sending_counters(const Sender& sender) {
  const WriteTimes times = sender.write_times();
  std::map<std::string, double> counters{{"writes", static_cast<double>(times.taken.count())},
                                         {"writes_overtaken", static_cast<double>(times.overtaken)},
                                         {"writes_rejected", static_cast<double>(times.rejected)},
                                         {"unplugged", static_cast<double>(sender.times_unplugged())}};
  counters.merge(write_time_counters(times.taken));
  return counters;
}

/// Throws DeviceError if `path` is no address, or no service is there.
std::pair<std::unique_ptr<Inverse3Socket>, std::unique_ptr<HapticDevice>> open_inverse3(const Inverse3Spec& spec,
                                                                                        const std::string& path,
                                                                                        const WallClock& clock) {
  const auto address = read_inverse3_address(path);
  if (!address) throw DeviceError("--device " + path + ": " + address.error());
  auto socket = std::make_unique<Inverse3Socket>(
      *address, clock,
      Inverse3SocketOptions{
          .update_rate = spec.update_rate, .hold = spec.hold, .returns = kPatience, .remote = spec.remote});
  auto driver = internal::make_inverse3_driver(spec, *socket, address->device_id);
  return {std::move(socket), std::move(driver)};
}

/// A write is a message, and lasts until its answer has come.
std::map<std::string, double> sending_counters(const Inverse3Times& times) {
  std::map<std::string, double> counters{{"writes", static_cast<double>(times.answered.count() + times.unanswered)},
                                         {"writes_overtaken", static_cast<double>(times.overtaken)},
                                         {"writes_rejected", static_cast<double>(times.unanswered)},
                                         {"unplugged", static_cast<double>(times.lost)}};
  counters.merge(write_time_counters(times.answered));
  return counters;
}

}  // namespace

std::string binding_objection(const Scenario& scenario, const std::vector<DeviceBinding>& bindings) {
  const auto tool_of = [&](const DeviceBinding& binding) {
    return binding.name.empty() ? scenario.devices.front().name : binding.name;
  };
  for (std::size_t i = 0; i < bindings.size(); ++i) {
    const std::string name = tool_of(bindings[i]);
    const auto is_it = [&](const DeviceSpec& device) { return device.name == name; };
    if (std::none_of(scenario.devices.begin(), scenario.devices.end(), is_it)) {
      std::string names;
      for (const DeviceSpec& device : scenario.devices) names += (names.empty() ? "" : ", ") + device.name;
      return fmt::format("--device {}={}: the scenario has no device \"{}\", but {}", name, bindings[i].path, name, names);
    }
    for (std::size_t j = 0; j < i; ++j) {
      const std::string other = tool_of(bindings[j]);
      if (name == other) return fmt::format("--device is given twice for \"{}\"", name);
      if (node_of(bindings[i].path) == node_of(bindings[j].path))
        return fmt::format("--device {}={} is the device of {} ({}): each needs one of its own", name, bindings[i].path,
                           other, bindings[j].path);
    }
  }
  return {};
}

Scenario with_live_guards(Scenario scenario, const std::vector<DeviceBinding>& bindings) {
  for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool) {
    DeviceSpec& device = scenario.devices[tool];
    if (!binding_of(bindings, scenario, tool)) continue;
    device.is_real = true;
    device.limits = force_limits(device.guard, kLiveLimits);
  }
  return scenario;
}

struct LiveDevices::Device {
  std::string name;
  std::unique_ptr<HidapiTransport> transport;  // for a real HID device
  std::unique_ptr<LiveEvdev> node;             // for one of Linux' input core
  std::unique_ptr<Inverse3Socket> service;     // for one of an Inverse Service
  std::unique_ptr<SimulatedMotors> simulated;  // for a simulated one
  std::unique_ptr<HapticDevice> driver;
  EvdevDriver* evdev = nullptr;  // below the driver, for one of Linux' input core
};

LiveDevices::LiveDevices(const Scenario& scenario, const WallClock& clock, const LiveDeviceOptions& options) {
  for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool) {
    const DeviceBinding* const binding = binding_of(options.bindings, scenario, tool);
    Device& device = devices_.emplace_back();
    device.name = scenario.devices[tool].name;
    if (!binding) {
      internal::SimulatedParts parts = internal::make_simulated(scenario.devices[tool], clock);
      device.simulated = std::move(parts.device);
      device.driver = std::move(parts.driver);
      continue;
    }
    if (const auto* foreign = std::get_if<ForeignDriverSpec>(&scenario.devices[tool].driver)) {
      device.driver = internal::make_foreign_device(*foreign, scenario.devices[tool], nullptr, binding->path);
    } else if (const auto* evdev = std::get_if<EvdevSpec>(&scenario.devices[tool].driver)) {
      auto file = std::make_unique<EvdevFile>(binding->path);
      const EvdevInfo info = file->info();
      device.node = std::make_unique<LiveEvdev>(
          std::move(file), [info] { return open_again(info); }, clock, kPatience);
      device.driver = internal::make_evdev_driver(*evdev, scenario.devices[tool], *device.node, &device.evdev);
    } else if (const auto* inverse3 = std::get_if<Inverse3Spec>(&scenario.devices[tool].driver)) {
      std::tie(device.service, device.driver) = open_inverse3(*inverse3, binding->path, clock);
    } else {
      device.transport = std::make_unique<HidapiTransport>(binding->path, clock, kPatience);
      device.driver = internal::make_driver(scenario.devices[tool], *device.transport);
    }
    if (!options.forces) device.driver = std::make_unique<internal::ReadOnlyDevice>(std::move(device.driver));
  }
  // Started only after all of them were opened.
  for (Device& device : devices_) device.driver->start();
}

LiveDevices::~LiveDevices() {
  for (Device& device : devices_) device.driver->stop();
}

void LiveDevices::stop_simulated() {
  for (Device& device : devices_) {
    if (device.simulated) evenstep::stop_simulated(device.name, device.driver.get(), *device.simulated);
  }
}

std::vector<HapticDevice*> LiveDevices::drivers() {
  std::vector<HapticDevice*> drivers;
  for (Device& device : devices_) drivers.push_back(device.driver.get());
  return drivers;
}

void LiveDevices::forget_queued() {
  constexpr int kDeepestQueue = 64;
  std::array<std::byte, 64> ignored;
  for (Device& device : devices_) {
    if (device.evdev) device.evdev->forget_queued();
    for (int i = 0; device.transport && i < kDeepestQueue; ++i) {
      if (device.transport->read(ignored).status != HidRead::Status::report) break;
    }
  }
}

std::map<std::string, double> LiveDevices::counters(std::size_t tool) const {
  const Device& device = devices_[tool];
  if (device.simulated) return motor_counters(*device.simulated);
  if (device.transport) return sending_counters(*device.transport);
  if (device.service) return sending_counters(device.service->times());
  return device.node ? sending_counters(*device.node) : std::map<std::string, double>{};
}

}  // namespace evenstep
