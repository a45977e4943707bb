#pragma once
/// Force feedback boards of the PID class as their firmware really behaves, in software. Each is a second reading of the
/// standard, beside SimulatedPidDevice: it takes the bytes of reports apart as its own firmware does, without code of the
/// driver's and without a parser of descriptors. The firmwares were read, not run:
///
/// openffboard-1, -2: OpenFFBoard with one and two axes (August 2026). Its state report never has the safety switch set. It
/// pushes away from where an effect's direction points: X = -sin, Y = cos. A spring's blocks are by axis only once a second
/// block was used; until then the first block acts along the direction, with the direction's sign (-cos along Y), and along
/// any axis that it was set for. With one axis, Axes Enable and Direction Enable have the logical range 0..0. Its largest
/// coefficient is 4.06 times full scale over half the travel, unless set otherwise. Stop All Effects also turns the motors
/// off.
///
/// arduino: ArduinoJoystickWithFFBLibrary (January 2024). It takes the first direction for both axes if Direction Enable is
/// set alone (axis byte 4), otherwise one direction for each axis, enabled or not: X = sin, Y = -cos. It has no state
/// report, ignores the device gain, and Disable Actuators turns nothing off. With axis byte 4 a spring's first block
/// acts along the direction while exactly one condition report was counted, modulo 256; otherwise block i acts along axis i.
/// Off center, a spring's negative coefficient acts on both sides.
///
/// silent-pool: a strict reader of the standard whose pool report is never answered.
/// short-replies: a strict reader whose answers to feature requests lack the last byte.
///
///
/// The others are strict readers as well, with what was reported of a kind of device; nobody has read their firmware:
///
/// vrs: one motor; no Direction (universal-pidff#82) and no Parameter Block Offset, Device Control is a bit mask from 0
/// (linux-steering-wheels#4; so is Turtle Beach's VelocityOne Race, linux-steering-wheels#24). A force is as from 90
/// degrees, which is the magnitude that Linux sends. asetek: one motor; Set Condition has type-specific block offsets alone
/// (universal-pidff#127), one coefficient and one saturation for both sides, and no dead band (universal-pidff#115). moza:
/// one motor; a spring from 270 degrees pushes away from its center, and from 0 degrees it does nothing (universal-pidff#1).
/// Only Start begins an effect's time anew (PCSX2#11906), and 0xFFFF ms are no eternity. pxn: one motor; springs are taken
/// and never felt (universal-pidff#54). fixed-direction: one motor; no Axes Enable, and every effect is as from 90 degrees,
/// 0x4000 of Linux (universal-pidff#82). two-commands: Device Control takes two commands at once, counted from 0
/// (linux-steering-wheels#15). late-load: the pool has no count; Block Load answers nothing first, then with the block of
/// the effect before (linux-steering-wheels#24, as it was first understood). no-duration: effects have no duration and never
/// end. load-error-first, load-never, load-always-1: Block Load answers with an error first, never, or with block 1 for all.
///
/// The strict reader pushes away from where the direction points, as Linux and DirectInput mean it; axis bits count only
/// without Direction Enable; one condition block acts along the direction, several by axis.
///
/// Ticks, hand, queue and faults are those of simulated_reports.h; forces follow a report at once, springs and ends of
/// effects at `firmware_rate`. Durations are in whole milliseconds of the firmware's clock: an effect ends up to 1 ms + one
/// firmware tick after its duration.

#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/device/hid/simulated_pid_device.h"
#include "evenstep/device/hid/simulated_reports.h"

namespace evenstep {

namespace internal {
class Firmware;
}

enum class BoardKind {
  openffboard_1,
  openffboard_2,
  arduino,
  silent_pool,
  short_replies,
  vrs,
  asetek,
  moza,
  pxn,
  fixed_direction,
  two_commands,
  late_load,
  no_duration,
  load_error_first,
  load_never,
  load_always_1
};
struct NamedBoard {
  std::string_view name;
  BoardKind kind;
};
/// All of them, in the order above.
const std::vector<NamedBoard>& simulated_boards();
/// 1: along X; 2: along X and Y.
int motors_of(BoardKind kind);

struct SimulatedBoardOptions {
  BoardKind kind = BoardKind::openffboard_1;
  SimulatedDeviceOptions reports;
  glm::dvec3 travel_m{0.4};  ///< positions of +-travel / 2 are the logical range; positions beyond give its ends
  double full_scale_N = 10;  ///< force of the largest magnitude at full gain
  /// Slope of the largest coefficient at full gain; empty: what the firmware has if nobody sets it.
  std::optional<glm::dvec3> full_slope_N_per_m;
  Rate firmware_rate{4000, 1};
  int pool_effects = 40;         ///< at most; a firmware may have room for fewer
  int block_load_error_at = -1;  ///< which Create New Effect ends in an error, counted from 0; -1: none
  /// Also has what Linux 6.1 requires of every device and most strict readers lack, and ignores it: Trigger Button, Trigger
  /// Repeat Interval, Start Delay and Direction Enable in Set Effect, and Set Envelope. A kind's own fault is then what that
  /// kernel stumbles over. Strict readers only.
  bool for_linux_6_1 = false;
  std::vector<PidDeviceEvent> events;
};

class SimulatedBoard final : public SimulatedDevice {
 public:
  SimulatedBoard(const Clock& clock, HeldBy by, SimulatedBoardOptions options);
  ~SimulatedBoard() override;

  HidRead read(std::span<std::byte> buffer) override;
  HidWrite write(std::span<const std::byte> report) override;
  HidFeature get_feature(std::span<std::byte> report) override;
  HidWrite set_feature(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override { return descriptor_; }
  const HidDeviceInfo& info() const override { return info_; }
  std::int64_t refused_later() const override { return reports_.refused_later(); }
  MotorState motors() override;

 private:
  void catch_up();
  void render(RealTime at);
  glm::dvec3 force_N(RealTime at);
  void pass_on_states();

  const Clock& clock_;
  SimulatedReports reports_;
  SimulatedBoardOptions options_;
  std::unique_ptr<internal::Firmware> firmware_;
  std::vector<std::byte> descriptor_;
  HidDeviceInfo info_;
  MotorLog motors_;
  std::size_t next_event_ = 0;
  std::int64_t next_firmware_tick_ = 0;
  bool switch_closed_ = true, has_power_ = true;
  std::int64_t effects_ended_ = 0;
};

}  // namespace evenstep
