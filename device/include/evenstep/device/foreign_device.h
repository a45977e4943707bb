#pragma once
/// A device of your own: anything that is read and written once per tick (haptic_device.h). Under a simulated run it gets a
/// SimulatedGrip, through which it feels the scenario's hand and drives its motors, so that everything that lies between is
/// yours: resolution, delays, faults. On real hardware it gets a path instead, and drives what is there.
///
///   class MyArm final : public evenstep::HapticDevice {
///    public:
///     explicit MyArm(evenstep::SimulatedGrip& grip) : grip_(grip) {}
///     evenstep::DeviceSample read(evenstep::RealTime) override { return {.position_m = grip_.hand_m(), .fresh = true}; }
///     void write(const glm::dvec3& force_N) override { grip_.drive(force_N); }
///     void stop() noexcept override { grip_.drive({}); }
///    private:
///     evenstep::SimulatedGrip& grip_;
///   };
///   registry.add_device("my-arm", [](const evenstep::DeviceRequest& request) {
///     return std::make_unique<MyArm>(*request.grip);
///   });
///
/// The guard (force_guard.h) clamps, slews and cuts every force before write(), as for any device; with a real device and
/// without --forces, write() is not called at all. However a simulated run ends, stop() is called, and if the grip's motors
/// still render a force then, the run fails.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/device/motion.h"

namespace evenstep {

/// The hand on a simulated device, and the device's motors, at the clock's now.
class SimulatedGrip final : public SimulatedMotors {
 public:
  SimulatedGrip(const Clock& clock, ProgrammedMotion motion) : clock_(clock), motion_(std::move(motion)) {}
  /// The hand feels each force `force_delay` after it was driven.
  SimulatedGrip(const Clock& clock, Hand hand, Duration force_delay)
      : clock_(clock), hand_(std::move(hand)), force_delay_(force_delay) {}
  /// Where the hand is, m. May throw HandDiverged, but only once: from then on it stays where it was.
  glm::dvec3 hand_m();
  /// From now on the motors render this, N.
  void drive(const glm::dvec3& force_N);
  MotorState motors() override;

 private:
  const Clock& clock_;
  ProgrammedMotion motion_;
  std::optional<Hand> hand_;  // used instead of motion_ if there is one
  Duration force_delay_;
  glm::dvec3 last_m_{0}, force_N_{0};
  bool has_let_go_ = false;  // the hand has diverged
  MotorLog log_;
};

/// What a device is made for. Either `grip` or `path` is given.
struct DeviceRequest {
  std::string name;            ///< the name it is registered under
  std::string device;          ///< name of the [[device]]
  std::string options = "{}";  ///< of `foreign`, as a JSON object, keys in alphabetical order; unread by evenstep
  Rate rate{1000, 1};          ///< ticks per second
  RealTime first_tick;
  SimulatedGrip* grip = nullptr;  ///< of a simulated device; outlives it
  std::string path;               ///< of a real one, as given with --device NAME=PATH
  std::uint64_t seed = 1;         ///< [run] seed: all that may be drawn at random follows from it
};

/// Makes a device; called by any thread, once per strategy. It need not set DeviceSample::read_at. If it knows when a
/// position was taken, it sets taken_at: not later than `now`, not before the last one. Any of its functions but stop() may
/// throw std::exception: the run then stops with its message and the device's name.
using DeviceFactory = std::function<std::unique_ptr<HapticDevice>(const DeviceRequest& request)>;

}  // namespace evenstep
