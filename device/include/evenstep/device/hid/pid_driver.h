#pragma once
/// The driver of force feedback devices of the PID class (USB "Physical Interface Device"), above HidTransport. It reads
/// positions from the axes X, Y, Z of the input report, and renders forces with one constant-force effect per axis and
/// springs as conditions.
///
/// PID has no newtons and no metres. `travel_m` and `full_scale_N` must come from the user, who has measured them or has a
/// data sheet. Without `full_scale_N` the driver is read-only: start() creates nothing and writing a force is an error.
///
///   magnitude = F / full_scale_N * logical maximum, to the nearest, halves away from zero
///
/// `gain` * full_scale_N is the largest force; the default is a quarter, because such devices can break thumbs. The driver
/// itself keeps to it, and sets the device's own gain to its maximum: there is firmware that ignores the device gain
/// (simulated_board.h), and a driver that counts on it would make each force 1 / gain times as large there.
///
/// Reports are those of Linux' hid-pidff: Direction Enable alone, if there is one, addresses X (90 degrees) and Y (0
/// degrees); otherwise the bit of the axis does. As for Linux and DirectInput, a positive magnitude pushes away from where
/// the direction points, so along X towards lower positions. Firmware differs in that (`reversed_force`).
///
/// A device without a direction is sent the same magnitude along X, as by Linux.
///
/// start() may take long: reset, gain, actuators on, then for each effect Create New Effect, Block Load (asked again up to
/// `block_load_tries` times), Set Effect, Set Constant Force (0), Start. A tick writes Set Constant Force for each axis
/// whose count has changed, and nothing otherwise. If the device or the system refuses a report, at once or later
/// (HidTransport::refused_later), the next tick sends all forces, springs and Starts again. Once nothing has been taken for
/// `effect_duration` (half a second if it is empty), read() throws DeviceError.
///
/// Every effect ends by itself `effect_duration` after its last Start; this is the device's own dead man's handle. When half
/// of that (250 ms if it is empty) has passed since the last refresh, the next write sends force and Start again. So a host
/// that hangs leaves no force behind, and a report that was lost on the way is made up for.
///
/// stop(), which the destructor calls too, sends Stop for each effect, stops all effects, switches the actuators off and
/// frees the blocks. Each is tried three times, and failures are ignored. It is not a safety device.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/device/hid/pid_layout.h"

namespace evenstep {

struct PidOptions {
  /// Distance from one end of each axis' logical range to the other; the middle is position 0. An axis with 0 is not used.
  glm::dvec3 travel_m{0};
  std::optional<double> full_scale_N;  ///< the force at the largest magnitude and full gain; > 0
  double gain = 0.25;                  ///< (0, 1]; the share of full_scale_N that may be used
  /// Empty: for ever. Rounded to the device's unit and limited to what its field can hold. A device without such a field,
  /// whose effects never end by themselves, is refused unless it is empty.
  std::optional<Duration> effect_duration = Duration{500'000'000};
  /// Which way a positive magnitude pushes differs between devices; true: opposite to what Linux means.
  std::array<bool, pid::kAxes> reversed_force{};
  bool springs = false;  ///< also create one condition effect for each axis whose spring's sign is known
  /// Whether a positive coefficient pushes away from the center instead of towards it, as it was measured on this device.
  /// Empty: not measured, and no spring is rendered along the axis, because one of the wrong sign throws the hand out, and
  /// there are devices that take springs and render none. A device that cannot render one that is not empty is refused.
  std::array<std::optional<bool>, pid::kAxes> reversed_spring{};
  /// Slope of a condition with the largest coefficient at full gain, per axis. Empty: full_scale_N over half the travel,
  /// which is what most firmware takes a coefficient to mean; measure it.
  std::optional<glm::dvec3> full_slope_N_per_m;
  int block_load_tries = 60;
};
/// The stiffest spring that a device with these options can render by itself on all axes in use, which is that of its
/// weakest axis.
double steepest_spring_N_per_m(const PidOptions& options);

/// What the device last reported about itself; empty: it has not reported it.
struct PidState {
  std::optional<bool> paused, actuators_enabled, safety_switch, override_switch, actuator_power, effect_playing;
};
/// Why the device renders nothing, as far as its driver knows.
enum class PidSilence { none, paused, actuators_off, switch_open, no_power, returned };

struct PidCounters {
  std::int64_t refreshes = 0;  ///< ticks that sent force and Start again
  std::int64_t saturated = 0;  ///< writes of a force beyond gain * full_scale_N along an axis
  std::int64_t state_reports = 0;
  std::int64_t unpowered = 0;  ///< writes while the device reported that it renders nothing
  bool pool_unknown = false;   ///< the device did not say how many effects it plays at once, or said less than 2
  /// How often the device began to say that it renders nothing, by the first of these reasons.
  std::int64_t cuts_paused = 0, cuts_actuators = 0, cuts_switch = 0, cuts_power = 0;
};

/// The device has no room for another effect, refuses it, or does not answer.
class PidBlockLoadError : public DeviceError {
 public:
  enum class Reason { full, error, no_answer };
  PidBlockLoadError(const std::string& what, Reason why) : DeviceError(what), reason(why) {}
  Reason reason;
};

class PidDriver final : public HapticDevice {
 public:
  /// `layout` must be that of the transport's device, and the transport must outlive the driver. Throws DeviceError if the
  /// device lacks an axis that has a travel, or if an option is out of its range.
  PidDriver(HidTransport& transport, PidLayout layout, const PidOptions& options);
  ~PidDriver() override;
  PidDriver(const PidDriver&) = delete;
  PidDriver& operator=(const PidDriver&) = delete;

  /// Do not call it from a tick. Throws DeviceError (the device is gone, or has refused a report) and PidBlockLoadError;
  /// then nothing is left behind on the device.
  void start() override;
  void stop() noexcept override;
  bool is_read_only() const { return !options_.full_scale_N; }

  /// `sequence` counts the position reports received; PID reports are not numbered, so `lost` stays 0. `drivable` is false
  /// while the device reports that it renders nothing: it is paused, or a switch, the power or the actuators are off after
  /// it has reported them on. (Firmware that never sets such a bit does not mean it.) Once the device was unplugged it stays
  /// false for ever, because the effects are lost and cannot be created in a tick.
  DeviceSample read(RealTime now) override;
  /// Counts as written at the time of the last read. Throws DeviceError if the driver is read-only, not started or gone.
  void write(const glm::dvec3& force_N) override;
  /// Renders no spring along an axis whose center lies outside the travel, or for which the device lacks a field; and never
  /// more than the largest slope. The rest is left to the caller.
  DeviceSpring write_spring(const DeviceSpring& wanted) override;
  const DeviceCounters& counters() const override { return counters_; }

  const PidCounters& pid_counters() const { return pid_counters_; }
  std::map<std::string, std::int64_t> own_counters() const override;
  const PidState& state() const { return state_; }
  /// gain * full_scale_N; 0 if the driver is read-only.
  double largest_force_N() const override { return options_.gain * options_.full_scale_N.value_or(0); }
  PidSilence silence() const;
  /// The duration of an effect as it was rounded for the device; empty: for ever.
  std::optional<Duration> effect_duration() const { return effect_duration_; }

 private:
  struct Effect {
    std::size_t axis = 0;
    bool is_spring = false;
    std::uint8_t block = 0;
    std::vector<std::byte> wanted;  ///< the newest Set Constant Force or Set Condition
    bool is_sent = false;           ///< it was taken, and not refused afterwards as far as is known
  };

  bool is_used(std::size_t axis) const { return options_.travel_m[static_cast<int>(axis)] > 0; }
  bool has_springs() const;
  bool has_spring(std::size_t axis) const;
  bool reverses_spring(std::size_t axis) const { return options_.reversed_spring[axis].value_or(false); }
  bool is_by_direction(std::size_t axis) const;
  void check_options() const;
  void start_effects();
  void refuse_what_is_missing() const;
  std::string lacks_for_spring(std::size_t axis) const;
  void abandon() noexcept;
  void set_gain();
  void choose_duration();
  void ask_pool();
  void create(std::size_t axis, bool is_spring);
  std::uint8_t allocate(bool is_spring);
  std::uint8_t loaded_block();
  void set_effect(const Effect& effect);
  void address(std::span<std::byte> report, const Effect& effect) const;
  void set_duration(std::span<std::byte> report) const;
  void command(const std::optional<PidChoice>& what, const char* name);

  void take(std::span<const std::byte> bytes);
  void take_positions(std::uint8_t id, std::span<const std::byte> bytes);
  void take_state(std::span<const std::byte> bytes);
  void require_writable() const;
  bool is_silent() const { return silence() != PidSilence::none; }
  void notice_silence(PidSilence before);
  void notice_refusals(RealTime now);
  static void want(Effect& effect, std::span<const std::byte> report);
  void send_wanted();
  std::span<std::byte> constant_force(const Effect& effect, double force_N);
  struct Condition;  // one axis of a DeviceSpring in the device's counts
  std::span<std::byte> condition(const Effect& effect, const Condition& counts);
  std::optional<Condition> counts_of(const DeviceSpring& wanted, int axis) const;
  void render(const Condition& counts, DeviceSpring& rendered, int axis) const;
  std::span<std::byte> no_spring(const Effect& effect);

  std::span<std::byte> compose(const PidReport& report);
  std::span<std::byte> operation(const Effect& effect, const PidChoice& what);
  bool send_in_tick(std::span<const std::byte> report, const PidValue& block);
  void require_sent(std::span<const std::byte> report, const char* name);
  void try_command(const std::optional<PidChoice>& what) noexcept;
  [[noreturn]] void fail(const std::string& what) const;

  HidTransport& transport_;
  PidLayout layout_;
  PidOptions options_;
  DeviceCounters counters_;
  PidCounters pid_counters_;
  PidState state_;
  DeviceSample last_;
  std::vector<std::byte> input_, output_;
  std::vector<Effect> effects_;
  bool started_ = false;
  bool has_returned_ = false;    // it was unplugged in between, so its effects are lost
  bool numbers_blocks_ = false;  // the driver numbers the blocks, because the device does not
  bool saw_actuators_ = false, saw_switch_ = false, saw_power_ = false;  // reported as on at some time
  std::int64_t refusals_seen_ = 0;                                       // of HidTransport::refused_later
  bool refused_in_tick_ = false;                                         // a report was refused since the last read
  std::optional<RealTime> refused_since_;                                // since when no tick's reports were all taken
  std::optional<Duration> effect_duration_;
  std::optional<RealTime> refreshed_at_;
};

}  // namespace evenstep
