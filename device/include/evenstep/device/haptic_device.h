#pragma once
/// A haptic device as the loop sees it: one read and one write per tick.

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include <glm/vec3.hpp>

#include "evenstep/time/time.h"

namespace evenstep {

struct SampleAges;  // device_clock.h

struct DeviceSample {
  RealTime read_at;  ///< when the driver read it, by the clock
  /// When the position was taken, by the same clock, if the device says so: at most read_at, and never decreasing.
  std::optional<RealTime> taken_at = {};
  glm::dvec3 position_m{0};
  std::uint32_t sequence = 0;  ///< that of the newest report
  bool fresh = false;          ///< false: no new report since the last read, so the position is unchanged
  bool at_range = false;       ///< along an axis the position is at an end of what the report can carry: it may be beyond
  bool drivable = true;        ///< false: the device says that its motors are off (safety switch, actuator power)
  /// The device was unplugged, and is looked for or has just been found: it renders nothing, not even what was sent to it.
  /// Then it is not drivable either.
  bool away = false;

  /// The time that the position belongs to, as far as it is known.
  RealTime time() const { return taken_at.value_or(read_at); }
};

/// Reports received and what went wrong since the start. An expectation can check each counter as a metric.
struct DeviceCounters {
  std::int64_t reports = 0;
  std::int64_t lost = 0;       ///< gaps in the sequence
  std::int64_t malformed = 0;  ///< wrong length, unknown id
  std::int64_t stale = 0;      ///< reads without a fresh report
  std::int64_t write_failures = 0;
};

class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Springs that a device renders by itself, at a rate of its own. There is one along each axis; it pulls towards `center_m`
/// with k (center - x), limited to limit_N, where k = below for x < center and k = above for x > center.
struct DeviceSpring {
  glm::dvec3 center_m{0};
  glm::dvec3 below_N_per_m{0};  ///< >= 0
  glm::dvec3 above_N_per_m{0};  ///< >= 0
  glm::dvec3 limit_N{0};        ///< >= 0
};

class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  /// Prepares the device for its first force. May block, so do not call it in a tick. Throws DeviceError.
  virtual void start() {}
  /// Makes the device render no force from now on, as far as it can still be reached. After this it is only read.
  virtual void stop() noexcept {}
  /// Takes all reports that are waiting and returns the newest. Never blocks. Throws DeviceError when the device is gone.
  virtual DeviceSample read(RealTime now) = 0;
  /// Sends one force, which the caller must have passed through the ForceGuard. Never blocks.
  virtual void write(const glm::dvec3& force_N) = 0;
  /// Springs to be rendered in addition to the force, until the next call. Returns the springs that the device really
  /// renders: they may be softer or rounded, and are 0 along an axis where it cannot render one. The rest is left to the
  /// caller (device_spring.h). Never blocks.
  virtual DeviceSpring write_spring(const DeviceSpring& /*wanted*/) { return {}; }
  /// The largest force along an axis that write() can pass on; a larger one is cut to it.
  virtual double largest_force_N() const { return std::numeric_limits<double>::infinity(); }
  /// All zero if the device counts nothing.
  virtual const DeviceCounters& counters() const {
    static const DeviceCounters none;
    return none;
  }
  /// What the device's time stamps said; nullptr if nobody knows how old its samples are.
  virtual const SampleAges* ages() const { return nullptr; }
  /// Counts that only devices of this kind have, by the metric's name.
  virtual std::map<std::string, std::int64_t> own_counters() const { return {}; }
};

}  // namespace evenstep
