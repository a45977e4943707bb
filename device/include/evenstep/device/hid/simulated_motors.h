#pragma once
/// What the motors of a simulated device really do, as a person who holds it would notice, whatever its driver believes.

#include <cstdint>
#include <optional>

#include <glm/vec3.hpp>

#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/time/time.h"

namespace evenstep {

struct MotorState {
  glm::dvec3 force_N{0};    ///< the force now; 0 if the device is gone, as are the next three
  int effects_playing = 0;  ///< this and the next two are for PID devices
  int effects_allocated = 0;
  bool actuators_enabled = false;  ///< for a device that can be told to disable them
  double largest_N = 0;            ///< length of the largest force so far
  glm::dvec3 largest_along_N{0};   ///< size of the largest force along each axis so far
  Duration unrenewed;              ///< longest time so far that a force was rendered without a new output report
  /// If the device was away: the largest force that was asked for meanwhile, in vain.
  std::optional<double> asked_away_N;
  bool by_itself = false;          ///< nobody has told it anything, so that what it does it does by itself
  std::int64_t effects_ended = 0;  ///< how many ended because their duration had passed (the dead man's handle)
};

class SimulatedMotors {
 public:
  virtual ~SimulatedMotors() = default;
  /// The state at the clock's now. May throw HandDiverged, but only once.
  virtual MotorState motors() = 0;
};

/// A HID device in software: the bytes on its cable, and its motors.
class SimulatedDevice : public HidTransport, public SimulatedMotors {};

/// Records what the motors did. Instants must not decrease.
class MotorLog {
 public:
  /// The device has accepted an output report.
  void heard(RealTime at);
  /// From `at` on this is the force.
  void render(RealTime at, const glm::dvec3& force_N);
  /// The device is away from `at` on, and renders nothing.
  void lose(RealTime at);
  /// While it was away, somebody asked for this force.
  void ask_away(const glm::dvec3& force_N);
  /// The force has stayed the same up to `at`.
  void until(RealTime at);
  /// Sets what has been recorded: the largest forces and the longest time without a report.
  void tell(MotorState& state) const;

 private:
  bool drives_ = false;
  double largest_N_ = 0;
  std::optional<double> asked_away_N_;
  glm::dvec3 largest_along_N_{0};
  RealTime since_;  // the last report, or the begin of this force if that came later
  Duration unrenewed_;
};

}  // namespace evenstep
