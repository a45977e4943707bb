#pragma once
/// A force feedback device behind Linux' input core, in software: what the kernel does with events, effects and owners
/// (drivers/input/{input,evdev,ff-core}.c, read), and a device below it that renders the effects. It is a second reading of
/// linux/input.h, independent of the driver's: no code of the driver's is used.
///
/// Events: only values that have changed are told, each report followed by SYN_REPORT; a report that is cut or has an
/// unknown id never gets past the kernel's HID core. Small changes are smoothed by `fuzz`. The program's buffer has 64
/// places: when it is full, SYN_DROPPED and the newest event stay. Events are stamped with the tick of their report, whose
/// `age` is how much later the program can read them. An `unread` tick is one in which the program does not read.
///
/// After the device was unplugged and before it is found again, calls are answered as by a LiveEvdev, which then makes the
/// effects anew. From the plug on until it is told otherwise the device centers by itself.
///
/// Effects: `effects` places for all programs; only its owner may change or erase an effect, which keeps its type; but any
/// program may play and stop it, and set gain and autocenter. An upload that changes nothing is not passed to the device. An
/// effect ends by itself `length_ms` after it was played. An upload under `write_rejected` gives EIO; other writes are then
/// lost without a word, as with the kernel. Springs act along each axis by its own condition.

#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "evenstep/clock/clock.h"
#include "evenstep/device/evdev/evdev_node.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/device/hid/simulated_reports.h"
#include "evenstep/device/motion.h"

namespace evenstep {

struct SimulatedEvdevOptions {
  SimulatedDeviceOptions reports;
  glm::dvec3 travel_m{0.4, 0.4, 0};  ///< positions of +-travel / 2 are the ends of the axes; 0: there is no such axis
  double full_scale_N = 10;          ///< force of the largest level at full gain
  std::optional<glm::dvec3> full_slope_N_per_m;  ///< of the largest coefficient; empty: full scale over half the travel
  Rate firmware_rate{4000, 1};
  std::int32_t minimum = -32767, maximum = 32767;  ///< of every axis
  std::int32_t fuzz = 255;                         ///< what Linux gives a joystick with that range
  int effects = 16;                                ///< places for effects, of all programs together
  int foreign_effects = 0;                         ///< places that another program has taken
  bool held = false;                               ///< another program has the events for itself
  bool springs = true;                             ///< plays FF_SPRING
  int autocenter = 0xFFFF;                         ///< how strongly it centers by itself until it is told otherwise
  /// When another program stops every effect and turns gain and autocenter the wrong way.
  std::optional<RealTime> meddled_at;
};

class SimulatedEvdev final : public EvdevNode, public SimulatedMotors {
 public:
  SimulatedEvdev(const Clock& clock, HeldBy by, SimulatedEvdevOptions options);

  EvdevRead read(std::span<EvdevEvent> events) override;
  int write(const EvdevEvent& event) override;
  int upload(EvdevEffect& effect) override;
  int erase(int id) override;
  int grab() override;
  int effect_count(int& count) override;
  bool has_axis(std::uint16_t code) override;
  bool has_feedback(std::uint16_t code) override;
  int axis(std::uint16_t code, EvdevAxis& axis) override;
  int set_axis(std::uint16_t code, const EvdevAxis& axis) override;
  const EvdevInfo& info() const override { return info_; }
  MotorState motors() override;

  glm::dvec3 force_N();  ///< that the device renders now
  /// Another program tries to erase one of our effects; the answer is that of erase().
  int erase_as_other(int id) { return erase_as(Owner::other, id); }

 private:
  enum class Owner { nobody, we, other };
  struct Slot {
    Owner owner = Owner::nobody;
    EvdevEffect known;   // to the kernel
    EvdevEffect loaded;  // on the device
    bool playing = false;
    std::optional<RealTime> ends_at;
  };

  bool is_gone();
  void catch_up();
  void change_until(RealTime now);
  void begin_anew();
  int without_device() const;
  std::optional<RealTime> next_change(RealTime until) const;
  void change_at(RealTime at);
  void run_until(RealTime until);
  void report_until(RealTime until);
  void publish(const SimulatedReport& report);
  RealTime stamp_of(const SimulatedReport& report) const;
  void queue(const EvdevEvent& event);
  void render(RealTime at);
  bool is_springy() const;
  glm::dvec3 force_at(const glm::dvec3& position_m) const;
  double spring_share(const EvdevCondition& condition, int axis, const glm::dvec3& position_m) const;
  void play(Slot& slot, bool plays);
  int access(Owner who, int id) const;
  int erase_as(Owner who, int id);

  const Clock& clock_;
  SimulatedReports reports_;
  SimulatedEvdevOptions options_;
  EvdevInfo info_;
  MotorLog motors_;
  std::array<EvdevAxis, 3> axes_{};
  std::deque<EvdevEvent> queue_;
  std::size_t complete_ = 0;  // events at the front of the queue that are whole reports
  std::vector<Slot> slots_;
  int gain_ = 0xFFFF, autocenter_ = 0;
  bool is_told_ = false;  // something, by whoever
  bool meddled_ = false;
  bool has_returned_ = false;  // and no read has said so
  std::int64_t next_tick_ = 0, next_firmware_tick_ = 0;
  std::int64_t effects_ended_ = 0;
};

}  // namespace evenstep
