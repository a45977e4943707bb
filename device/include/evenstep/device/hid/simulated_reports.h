#pragma once
/// What all simulated devices have in common, whatever their reports look like: one report per tick with the position of a
/// programmed motion, or of a hand that feels forces, queued as by real drivers; and faults on the way, at given ticks.
///
/// A device that is unplugged and returns is lost at its tick, and is back when a program that looks for it finds it
/// (looked_for.h); the hand that holds it feels nothing meanwhile.
///
/// Tick k falls on tick_time(rate, k, first_tick). Nothing runs by itself: `advance(now)` carries out all ticks up to now.

#include <cstdint>
#include <deque>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "evenstep/device/hand.h"
#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/device/hid/report_queue.h"
#include "evenstep/device/motion.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// Several may fall on one tick.
struct ReportFault {
  enum class Kind {
    lost,            ///< the tick's report never comes
    duplicated,      ///< it comes `amount` more times
    late,            ///< it comes `amount` ticks later, after the report of that tick
    cut,             ///< only its first `amount` bytes come
    longer,          ///< `amount` more bytes follow it
    unknown_id,      ///< its id is 0xFF
    interrupted,     ///< from the tick on, `amount` reads are interrupted (EINTR)
    unread,          ///< nothing is read before the next tick, as if the host hung: what is queued stays queued
    write_lost,      ///< from the tick on, `amount` output reports are accepted but lost
    write_rejected,  ///< from the tick on, `amount` output reports are rejected
    write_refused,   ///< from the tick on, `amount` output reports are taken and refused afterwards
  } kind = Kind::lost;
  std::int64_t tick = 0;    ///< >= 0
  std::int64_t amount = 1;  ///< >= 0; late: >= 1
};

/// What moves a simulated device: a programmed motion, or a hand, which feels its forces. With a hand any call of the device
/// may throw HandDiverged.
using HeldBy = std::variant<ProgrammedMotion, Hand>;

struct SimulatedDeviceOptions {
  Rate rate{1000, 1};
  RealTime first_tick;  ///< time of tick 0 (the phase)
  QueuePolicy queue = QueuePolicy::hidraw;
  std::int64_t unplug_at_tick = -1;  ///< from this tick on the device is gone
  /// After the device was unplugged, it is plugged in again from this tick on. It is there once the program has found it
  /// (looked_for.h). -1: never. Not for devices that play PID effects, which their driver cannot make anew.
  std::int64_t return_at_tick = -1;
  Duration force_delay;  ///< from the writing of a force until the hand feels it; unused without a hand
  /// How old the report of a tick is when it comes, >= 0; a report never overtakes the one before it. Empty: it comes at its
  /// tick.
  std::function<Duration(std::int64_t tick)> age = nullptr;
  Rate clock_rate{0, 1};           ///< the rate by the device's own clock, for its time stamps; 0: `rate`
  std::string name = "simulated";  ///< HidDeviceInfo::path, which names the device in errors
  std::vector<ReportFault> faults;
};

/// A report in the queue; its bytes are made when it is read.
struct SimulatedReport {
  std::int64_t tick = 0;
  glm::dvec3 position_m{0};
  std::uint64_t other = 0;  ///< not 0: no position, but a report of another kind with this content
  enum class Shape { whole, cut, longer, unknown_id } shape = Shape::whole;
  std::int64_t bytes = 0;  ///< for `cut` and `longer`
};
/// Writes the report's bytes in that shape, as many as the buffer can hold.
HidRead deliver(const SimulatedReport& report, std::span<const std::byte> whole, std::span<std::byte> buffer);

class SimulatedReports {
 public:
  SimulatedReports(HeldBy by, SimulatedDeviceOptions options);

  const SimulatedDeviceOptions& options() const { return options_; }
  /// `now` must not decrease. The call that finds a device again carries out no tick. Throws HandDiverged, but only once:
  /// from then on the device stays where it was, as if released.
  void advance(RealTime now);
  /// The device is not there: for ever, or only `away`.
  bool is_gone() const { return presence_ != Presence::here; }
  /// It was unplugged, and is looked for.
  bool is_away() const { return presence_ == Presence::away; }
  /// Once after it was away: what was queued and on its way is lost, and its next tick is next_tick(). What the device was
  /// told before is its own affair.
  bool take_returned() { return std::exchange(returned_, false); }
  RealTime lost_at() const { return lost_at_; }           ///< if it ever was
  RealTime plugged_in_at() const { return plugged_at_; }  ///< if it has returned
  std::int64_t next_tick() const { return next_tick_; }
  /// With a hand, `at` must not be before any instant asked for or advanced to so far.
  glm::dvec3 position_m(RealTime at);
  /// Lets the hand, if there is one, feel the force from `now` + force_delay on.
  void feel(RealTime now, const glm::dvec3& force_N);

  /// Whether this read is interrupted.
  bool take_interruption() { return interruptions_ > 0 && interruptions_-- > 0; }
  /// The oldest report; none in a tick that is `unread`.
  std::optional<SimulatedReport> take() { return is_unread() ? std::nullopt : queue_.pop(); }
  /// Whether nobody reads in this tick (`unread`).
  bool is_unread() const { return unread_tick_ == next_tick_ - 1; }
  /// The oldest report, in an `unread` tick as well: for a kernel that reads all the time.
  std::optional<SimulatedReport> pop() { return queue_.pop(); }
  /// Queues a report of another kind, made now.
  void push(std::uint64_t other) { queue_.push({next_tick_ - 1, {}, other}); }
  /// What becomes of an output report: ok, rejected, or ok with `lost` set.
  HidWrite write_fault(bool& lost);
  std::int64_t dropped() const { return queue_.dropped(); }
  std::int64_t refused_later() const { return refused_later_; }

 private:
  struct Late {
    std::int64_t due;
    SimulatedReport report;
  };
  struct UnderWay {
    RealTime due;
    SimulatedReport report;
  };
  enum class Presence { here, away, gone };
  void lose();
  void look_for_device(RealTime now);
  void make_aged_tick(std::int64_t tick);
  /// The report leaves the device at this tick.
  void send(const SimulatedReport& report, std::int64_t tick);
  void deliver_until(RealTime now);
  std::int64_t next_event() const;
  void make_ticks(std::int64_t last);
  void make_faulty_tick(std::int64_t tick);
  glm::dvec3 position_at(std::int64_t tick);

  SimulatedDeviceOptions options_;  // faults in order of their ticks
  ProgrammedMotion motion_;
  std::optional<Hand> hand_;  // used instead of motion_ if there is one
  glm::dvec3 hand_m_{0};      // its last position
  bool has_let_go_ = false;   // the hand has diverged
  ReportQueue<SimulatedReport> queue_;
  std::vector<Late> late_;          // in order of due
  std::deque<UnderWay> under_way_;  // with ages: in order of due
  std::size_t next_fault_ = 0;
  std::int64_t next_tick_ = 0;
  std::int64_t unread_tick_ = -2;  // the last `unread` tick; -2: none
  std::int64_t interruptions_ = 0, writes_to_lose_ = 0, writes_to_reject_ = 0, writes_to_refuse_ = 0;
  std::int64_t refused_later_ = 0;
  Presence presence_ = Presence::here;
  bool was_lost_ = false, returned_ = false;
  RealTime lost_at_, plugged_at_;
  std::optional<RealTime> found_at_;
};

}  // namespace evenstep
