#pragma once
/// A force feedback device through Linux' own driver for it: positions from EV_ABS, forces by FF_CONSTANT and springs by
/// FF_SPRING. So it works with every wheel and stick that has a driver in the kernel, PID or not. docs/devices/evdev.md says
/// what is sent when.
///
/// Like PID, evdev has neither metres nor newtons: they are given as options, as for PidDriver (hid/pid_driver.h). X and Y
/// have forces; Z is only read. Directions are those of Linux: with a positive level, an effect of direction left pushes
/// towards lower X, and one of direction down towards the user, that is towards higher Y.
///
/// The kernel tells changes only. So for `still` after the last event a hand without events counts as holding still (the
/// sample is fresh), and after that as not reported. When events were lost (SYN_DROPPED), the driver asks for the positions.
///
/// A tick uploads what has changed, the effects taking turns, but no more than `update_rate` uploads and plays a second:
/// what the device cannot take in time waits in a queue of the kernel's, up to 256 reports, where no newer force can
/// overtake it. Every effect ends by itself `effect_duration` after it was played (the device or the kernel sees to it).
/// After half of that it is played again, and gain and autocenter are set again, because any other program may change those
/// and stop our effects. If the process dies the kernel erases its effects.
///
/// With `unchanged_age` a sample says when it was taken: at the time of the event that completed it or, where nothing has
/// changed, as event_times.h says. It is fresh only if that is later than for the sample before. An event that comes between
/// the tick's time and its read is left for the next tick. If the node does not tell times, samples have none.
///
/// While a device is away (unplugged, and looked for) its samples are not drivable, and nothing is sent. When it is back,
/// its effects are played anew, and the first sample is not drivable either.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/device/evdev/evdev_node.h"
#include "evenstep/device/evdev/event_times.h"
#include "evenstep/device/haptic_device.h"

namespace evenstep {

struct EvdevOptions {
  /// Distance from one end of each axis' range to the other; the middle is position 0. An axis with 0 is not used.
  glm::dvec3 travel_m{0};
  std::optional<double> full_scale_N;     ///< the force at the largest level and full gain; > 0; empty: read-only
  double gain = 0.25;                     ///< (0, 1]; the share of full_scale_N that may be used
  Duration effect_duration{500'000'000};  ///< 2 ms to 32.767 s, in whole milliseconds
  Rate update_rate{1000, 1};              ///< reports that the device can take per second
  Duration still{1'000'000'000};
  /// A position that no event has changed counts as taken this long before its read, > 0 (event_times.h). Empty: samples
  /// have the time of their read.
  std::optional<Duration> unchanged_age = {};
  std::array<bool, 2> reversed_force{};  ///< the device pushes opposite to what Linux means
  bool springs = false;                  ///< also upload one spring for each axis whose spring's sign is known
  /// Whether a positive coefficient pushes away from the center, as it was measured. Empty: not measured, and no spring is
  /// rendered along the axis.
  std::array<std::optional<bool>, 2> reversed_spring{};
  /// Slope of the largest coefficient at full gain. Empty: full_scale_N over half the travel.
  std::optional<glm::dvec3> full_slope_N_per_m;
};

struct EvdevCounters {
  std::int64_t refreshes = 0;  ///< how often everything was played again before it ended
  std::int64_t saturated = 0;  ///< writes of a force beyond gain * full_scale_N along an axis
  std::int64_t dropped = 0;    ///< how often events were lost because nobody had read them
  std::int64_t waited = 0;     ///< ticks in which a changed force or spring had to wait for update_rate
  bool untimed = false;        ///< times of events were asked for, and the node tells none
};

class EvdevDriver final : public HapticDevice {
 public:
  /// Takes the node for itself and stops the kernel from smoothing its axes. The node must outlive the driver. Throws
  /// DeviceError if another program has the node for itself, if it lacks an axis that has a travel or the effects that are
  /// asked for, or if an option is out of its range.
  EvdevDriver(EvdevNode& node, const EvdevOptions& options);
  /// Stops, and sets the smoothing of the axes as it was.
  ~EvdevDriver() override;
  EvdevDriver(const EvdevDriver&) = delete;
  EvdevDriver& operator=(const EvdevDriver&) = delete;

  /// Do not call it from a tick. Throws DeviceError (no room, refused, gone); then nothing is left behind.
  void start() override;
  /// Stops and erases the effects; each is tried three times.
  void stop() noexcept override;
  bool is_read_only() const { return !options_.full_scale_N; }
  /// Takes the events from before the run, when nobody read them and the kernel's buffer of 64 events may have dropped some.
  /// They are counted nowhere, and nothing that they said is lost: the driver then asks for the kernel's own table of the
  /// axes, which has the values of all events, taken or dropped. Throws DeviceError when the device is gone.
  void forget_queued();
  DeviceSample read(RealTime now) override;
  /// Throws DeviceError if the driver is read-only, not started, or the device is gone. read() throws, too, once the device
  /// has refused an effect for `effect_duration`.
  void write(const glm::dvec3& force_N) override;
  /// Renders no spring along Z, nor where its sign is not known or its center lies outside the travel.
  DeviceSpring write_spring(const DeviceSpring& wanted) override;
  /// gain * full_scale_N; 0 if the driver is read-only.
  double largest_force_N() const override { return options_.gain * options_.full_scale_N.value_or(0); }
  const DeviceCounters& counters() const override { return counters_; }
  const SampleAges* ages() const override { return times_ ? &times_->ages() : nullptr; }
  const EvdevCounters& evdev_counters() const { return evdev_counters_; }
  std::map<std::string, std::int64_t> own_counters() const override;

 private:
  struct Effect {
    int axis = 0;
    EvdevEffect wanted;
    bool is_sent = false;                   // the newest version is taken, or waits to be
    bool is_played = false;                 // since the last refresh was due
    std::optional<RealTime> refused_since;  // its uploads
  };

  bool is_used(int axis) const { return options_.travel_m[axis] > 0; }
  bool has_spring(int axis) const;
  void check_options() const;
  void adopt_axes();
  void restore_axes() noexcept;
  bool ask_positions();
  void come_back();
  void take(const EvdevEvent& event);
  bool take_until(RealTime now, std::span<const EvdevEvent> events);
  void date(RealTime now);
  void note_report();
  void place(int axis, std::int32_t value);
  bool is_position_known() const;
  void create(int axis, bool is_spring);
  void set_device();
  void require_writable() const;
  EvdevCondition condition_of(const DeviceSpring& wanted, int axis, DeviceSpring& rendered) const;
  void want(Effect& effect, EvdevEffect newest);
  void send_wanted();
  bool send_one();
  bool is_taken(int error);
  void notice_uploads();
  void notice_refusals(RealTime now) const;
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail_gone() const;

  EvdevNode& node_;
  EvdevOptions options_;
  DeviceCounters counters_;
  EvdevCounters evdev_counters_;
  DeviceSample last_;
  std::optional<EventTimes> times_;
  std::optional<RealTime> newest_event_;  // of this read, that completed a position
  std::vector<EvdevEvent> later_;         // events that came after the tick's time
  std::array<EvdevAxis, 3> axes_{};       // as they were found
  std::array<std::int32_t, 3> raw_{};
  std::vector<Effect> effects_;
  std::size_t next_effect_ = 0;  // whose turn it is
  bool started_ = false;
  bool has_gain_ = false, has_autocenter_ = false;
  bool is_away_ = false;
  bool is_asking_ = false;  // the positions, since events were lost
  bool is_lost_ = false;    // events were dropped, and no SYN_REPORT has followed yet
  bool positions_changed_ = false;
  std::optional<RealTime> last_event_, refreshed_at_;
  RealTime next_send_;
};

/// The stiffest spring that a device with these options can render by itself on all axes in use.
double steepest_spring_N_per_m(const EvdevOptions& options);

}  // namespace evenstep
