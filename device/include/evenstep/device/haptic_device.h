#pragma once
/// A haptic device as the loop sees it: one read and one write per tick.

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>

#include <glm/vec3.hpp>

#include "evenstep/time/time.h"

namespace evenstep {

struct DeviceSample {
  RealTime read_at;                    ///< when the driver read it (live clock)
  glm::dvec3 position_m{0};
  std::uint32_t sequence = 0;          ///< of the newest report
  bool fresh = false;                  ///< false: no new report since the last read; the position is the one before
  bool drivable = true;                ///< false: the device says that its motors are off (safety switch, actuator power)
};

/// What went wrong since the start; each is an expectation's metric.
struct DeviceCounters {
  std::int64_t reports = 0;
  std::int64_t lost = 0;               ///< gaps in the sequence
  std::int64_t malformed = 0;          ///< wrong length, unknown id
  std::int64_t stale = 0;              ///< reads without a fresh report
  std::int64_t write_failures = 0;
};

class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Springs that a device renders by itself, at a rate of its own: one along each axis, which pulls to `center_m` with
/// k (center - x), at most limit_N, k = below where x < center and above where x > center.
struct DeviceSpring {
  glm::dvec3 center_m{0};
  glm::dvec3 below_N_per_m{0};         ///< >= 0
  glm::dvec3 above_N_per_m{0};         ///< >= 0
  glm::dvec3 limit_N{0};               ///< >= 0
};

class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  /// What must be said to the device before its first force. May block; not for a tick. Throws DeviceError.
  virtual void start() {}
  /// No force from now on, as far as the device can still be told. After this it is only read.
  virtual void stop() noexcept {}
  /// Drains the reports that are there and returns the newest. Never blocks. Throws DeviceError when the device is gone.
  virtual DeviceSample read(RealTime now) = 0;
  /// Sends one force. Never blocks. The caller has passed it through the ForceGuard.
  virtual void write(const glm::dvec3& force_N) = 0;
  /// Springs besides the force, until the next call. Returns what the device does render: it may be softer, and rounded, and
  /// nothing along an axis where it cannot. The rest is the caller's (device_spring.h). Never blocks.
  virtual DeviceSpring write_spring(const DeviceSpring& /*wanted*/) { return {}; }
  virtual const DeviceCounters& counters() const = 0;
  /// What devices of this kind alone count, by the metric's name.
  virtual std::map<std::string, std::int64_t> own_counters() const { return {}; }
};

}  // namespace evenstep
