#pragma once
/// The devices of a run on the wall clock: real if a path was given, otherwise simulated. Forces are sent to a real device
/// only if that was asked for.

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
  std::string name;  ///< name of a [[device]]; empty: the first one
  std::string path;  ///< /dev/hidrawN
};
struct LiveDeviceOptions {
  std::vector<DeviceBinding> bindings;
  bool forces = false;
  bool cores_may_sleep = false;  ///< even deeply, in a live run: /dev/cpu_dma_latency is left alone
};

/// Why the bindings do not fit the scenario, with the remedy; empty if they do.
std::string binding_objection(const Scenario& scenario, const std::vector<DeviceBinding>& bindings);
/// The scenario as it runs on real devices: their guards have the limits kLiveLimits, except for those that the file sets.
Scenario with_live_guards(Scenario scenario, const std::vector<DeviceBinding>& bindings);

class LiveDevices {
 public:
  /// Throws DeviceError if a real device cannot be opened or driven. A device that is unplugged is waited for (kPatience).
  LiveDevices(const Scenario& scenario, const WallClock& clock, const LiveDeviceOptions& options);
  /// Tells every real device that was driven to stop.
  ~LiveDevices();
  LiveDevices(const LiveDevices&) = delete;
  LiveDevices& operator=(const LiveDevices&) = delete;

  std::vector<HapticDevice*> drivers();
  /// Discards the reports that came before the run began to read (as many as the queue holds), so that those dropped from
  /// the queue until then do not count as lost.
  void forget_queued();
  /// Calls stop_simulated for the simulated devices, after the lanes have ended.
  void stop_simulated();
  /// The counters of device `tool`: those of its transport, or, for a simulated one, what its motors did.
  std::map<std::string, double> counters(std::size_t tool) const;

 private:
  struct Device;
  std::deque<Device> devices_;
};

}  // namespace evenstep
