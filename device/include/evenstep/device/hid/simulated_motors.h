#pragma once
/// What the motors of a simulated device do: as somebody at the device would see it, whatever its driver believes.

#include <cstdint>

#include <glm/vec3.hpp>

#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/time/time.h"

namespace evenstep {

struct MotorState {
  glm::dvec3 force_N{0};              ///< now; of a device that is gone none, and nothing below up to the actuators
  int effects_playing = 0;            ///< these three: of a PID device
  int effects_allocated = 0;
  bool actuators_enabled = false;     ///< where it can be told to disable them
  double largest_N = 0;               ///< length of the largest force so far
  Duration unrenewed;                 ///< longest time so far that they rendered a force and no output report came
  std::int64_t effects_ended = 0;     ///< because their duration had passed: the device's own dead man's handle
};

/// A device in software: the bytes of its cable, and its motors.
class SimulatedDevice : public HidTransport {
 public:
  /// At the clock's now. May throw HandDiverged, once.
  virtual MotorState motors() = 0;
};

/// Keeps what the motors did. Instants must not decrease.
class MotorLog {
 public:
  /// The device has taken an output report.
  void heard(RealTime at);
  /// The length of the force from `at` on.
  void render(RealTime at, double force_N);
  /// The force goes on as it was up to `at`.
  void until(RealTime at);
  double largest_N() const { return largest_N_; }
  Duration unrenewed() const { return unrenewed_; }

 private:
  double force_N_ = 0, largest_N_ = 0;
  RealTime since_;  // the last report, or the begin of this force if that came later
  Duration unrenewed_;
};

}  // namespace evenstep
