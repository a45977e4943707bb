#pragma once
/// The devices of a run on the wall clock: real ones where a path is given, simulated ones elsewhere. Forces reach a real device
/// only when they were asked for.

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/format/scenario.h"

namespace evenstep {

/// --device NAME=PATH
struct DeviceBinding {
  std::string name;  ///< of a [[device]]; empty: the first
  std::string path;  ///< /dev/hidrawN
};
struct LiveDeviceOptions {
  std::vector<DeviceBinding> bindings;
  bool forces = false;
};

/// Why the bindings do not fit the scenario, with the remedy; empty if they do.
std::string binding_objection(const Scenario& scenario, const std::vector<DeviceBinding>& bindings);
/// The scenario as it runs on real devices: guards as kLiveLimits say where the file does not say otherwise.
Scenario with_live_guards(Scenario scenario, const std::vector<DeviceBinding>& bindings);

class LiveDevices {
 public:
  /// Throws DeviceError where a real device cannot be opened or driven. An unplugged one is waited for (kPatience).
  LiveDevices(const Scenario& scenario, const WallClock& clock, const LiveDeviceOptions& options);
  /// Every real device that was driven is told to stop.
  ~LiveDevices();
  LiveDevices(const LiveDevices&) = delete;
  LiveDevices& operator=(const LiveDevices&) = delete;

  std::vector<HapticDevice*> drivers();
  /// Reports that came before anybody listened, which is as long as the queue is: they are no loss.
  void forget_queued();
  /// The simulated ones, when the lanes have ended: stop_simulated.
  void stop_simulated();
  /// Of device `tool`: what its transport counted; of a simulated one what its motors did.
  std::map<std::string, double> counters(std::size_t tool) const;

 private:
  struct Device;
  std::deque<Device> devices_;
};

}  // namespace evenstep
