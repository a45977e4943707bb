#pragma once
/// A force feedback device of the PID class in software: what its firmware does with the reports it gets, on a clock that is
/// passed in. Like a driver, it knows nothing but its own descriptor (pid_descriptors.h). For reports, queue and faults see
/// simulated_reports.h.
///
/// - Effects are kept in a pool. Create New Effect takes the lowest free block; Block Load then tells which one, or "full",
///   or an error; it gives no answer to the first `block_load_delay` requests. On a device without these reports, Set Effect
///   takes the block that it names.
/// - An effect plays from Start on for its duration (0xFFFF: for ever); another Start begins anew. Playing effects add up:
///     constant force    magnitude / largest * effect gain, along the enabled axes, or away from where the direction points:
///                       X = -sin, Y = cos
///     spring            coefficient / largest * (center - position) in half travels (or full_slope), saturated, along the
///                       same axes; block i of its parameters is for axis i, the first for all if it is the only one
///   times device gain and full_scale_N; nothing while paused, without power, safety switch or enabled actuators.
/// - The actuators are off until they are enabled (on a device without Device Control they are always on). Device Reset
///   enables them, frees all blocks and sets the gain to its maximum.
/// - Changes of constant forces take effect at once, on the motors and on a hand; springs are updated at `firmware_rate`.
/// - A state report is sent whenever its content changes.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hid/pid_descriptors.h"
#include "evenstep/device/hid/pid_layout.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/device/hid/simulated_reports.h"

namespace evenstep {

/// Something that a person at the device does; events must be in order of time.
struct PidDeviceEvent {
  enum class Kind { safety_switch, actuator_power } kind = Kind::safety_switch;
  RealTime at;
  bool on = false;
};

struct SimulatedPidOptions {
  PidDescriptorOptions descriptor;
  SimulatedDeviceOptions reports;
  glm::dvec3 travel_m{0.4};  ///< positions of +-travel / 2 are the logical range; positions beyond give its ends
  double full_scale_N = 10;  ///< force of the largest magnitude at full gain
  /// Slope of the largest coefficient at full gain; empty: full_scale_N over half the travel.
  std::optional<glm::dvec3> full_slope_N_per_m;
  Rate firmware_rate{4000, 1};
  int pool_effects = 40;          ///< at most 40
  int simultaneous = 40;          ///< number of simultaneous effects in the pool report
  int pool_unready = 0;           ///< how many pool requests, counted from the first, are answered with 0 instead
  bool device_managed = true;     ///< as in the pool report; false: Create New Effect is answered with an error
  int block_load_delay = 0;       ///< how many Block Load requests after a Create New Effect get no answer
  int block_load_error_at = -1;   ///< which Create New Effect ends in an error, counted from 0; -1: none
  int feature_interruptions = 0;  ///< how many feature requests, counted from the first, are interrupted
  std::vector<PidDeviceEvent> events;
};

class SimulatedPidDevice final : public SimulatedDevice {
 public:
  SimulatedPidDevice(const Clock& clock, HeldBy by, SimulatedPidOptions options);

  HidRead read(std::span<std::byte> buffer) override;
  /// `rejected`: it is no output report of this device, or too short.
  HidWrite write(std::span<const std::byte> report) override;
  HidFeature get_feature(std::span<std::byte> report) override;
  HidWrite set_feature(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override { return descriptor_; }
  const HidDeviceInfo& info() const override { return info_; }
  std::int64_t refused_later() const override { return reports_.refused_later(); }
  MotorState motors() override;

  /// What the motors do now. A device that is gone does nothing.
  glm::dvec3 force_N();
  int playing() const;
  int allocated() const;
  bool actuators_enabled() const { return enabled_; }
  double gain() const { return gain_; }
  const PidLayout& layout() const { return layout_; }
  std::int64_t dropped() const { return reports_.dropped(); }

 private:
  struct Condition {
    double center = 0, above = 0, below = 0, saturation_above = 1, saturation_below = 1, dead_band = 0;
  };
  struct Effect {
    bool allocated = false, is_spring = false, playing = false;
    std::optional<Duration> duration;  // empty: for ever
    std::optional<RealTime> ends_at;
    std::array<double, pid::kAxes> along{};
    double gain = 1, magnitude = 0;
    std::array<Condition, pid::kAxes> conditions;  // by parameter block
    bool by_axis = false;                          // a block after the first was set
  };

  void catch_up();
  std::optional<RealTime> next_change(RealTime until) const;
  void change_at(RealTime at);
  void run_until(RealTime until);
  glm::dvec3 force_at(const glm::dvec3& position_m) const;
  double spring_force(const Effect& effect, std::size_t axis, const glm::dvec3& position_m) const;
  bool any_spring() const;
  void render(RealTime at);
  void say_state(std::size_t block);

  void take(std::span<const std::byte> report);
  void take_effect(std::span<const std::byte> report);
  void take_constant(std::span<const std::byte> report);
  void take_condition(std::span<const std::byte> report);
  void take_operation(std::span<const std::byte> report);
  void take_control(std::span<const std::byte> report);
  void reset();
  void free(std::size_t block);
  std::array<double, pid::kAxes> axes_of(std::span<const std::byte> report, bool is_spring) const;
  Effect* effect_of(std::span<const std::byte> report, const PidValue& block);
  std::size_t lowest_free() const;
  std::vector<std::byte> position_report(const SimulatedReport& report) const;
  std::vector<std::byte> state_report(std::uint64_t state) const;

  const Clock& clock_;
  SimulatedReports reports_;
  SimulatedPidOptions options_;
  std::vector<std::byte> descriptor_;
  ReportDescriptor parsed_;
  PidLayout layout_;
  HidDeviceInfo info_;
  std::vector<Effect> effects_;  // by block; there is no block 0
  bool enabled_ = false, paused_ = false, safety_ = true, power_ = true;
  double gain_ = 1;
  std::size_t next_event_ = 0;
  std::int64_t next_firmware_tick_ = 0;
  struct Load {
    std::size_t block = 0;
    std::optional<PidChoice> status;
    int unanswered = 0;
  } load_;
  int created_ = 0;
  MotorLog motors_;
  std::int64_t effects_ended_ = 0;
};

}  // namespace evenstep
