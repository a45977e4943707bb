#pragma once
/// What every simulated device does, whatever its reports look like: one report per tick with the position of the programmed
/// motion, or of a hand that feels forces, queued as real drivers do; and what can go wrong on the way, at the ticks told.
///
/// Tick k falls on tick_time(rate, k, first_tick). Nothing runs by itself: `advance(now)` makes all ticks up to now.

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
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
    late,            ///< it comes `amount` ticks later, after that tick's own
    cut,             ///< only its first `amount` bytes come
    longer,          ///< `amount` bytes follow it
    unknown_id,      ///< its id is 0xFF
    interrupted,     ///< from the tick on, `amount` reads are interrupted (EINTR)
    unread,          ///< nobody reads before the next tick, as if the host hung: what is queued stays queued
    write_lost,      ///< from the tick on, `amount` output reports are taken and lost
    write_rejected,  ///< from the tick on, `amount` output reports are rejected
  } kind = Kind::lost;
  std::int64_t tick = 0;    ///< >= 0
  std::int64_t amount = 1;  ///< >= 0; late: >= 1
};

struct SimulatedDeviceOptions {
  Rate rate{1000, 1};
  RealTime first_tick;  ///< time of tick 0 (the phase)
  QueuePolicy queue = QueuePolicy::hidraw;
  std::int64_t unplug_at_tick = -1;  ///< from this tick on the device is gone
  Duration force_delay;              ///< from writing a force to when the hand feels it; a programmed motion feels none
  std::string name = "simulated";    ///< HidDeviceInfo::path: whose errors these are
  std::vector<ReportFault> faults;
};

/// What waits in the queue; its bytes are made when it is read.
struct SimulatedReport {
  std::int64_t tick = 0;
  glm::dvec3 position_m{0};
  std::uint64_t other = 0;  ///< not a position: whatever its device pushed
  enum class Shape { whole, cut, longer, unknown_id } shape = Shape::whole;
  std::int64_t bytes = 0;  ///< of cut and longer
};
/// The report's bytes in that shape, as far as the buffer takes them.
HidRead deliver(const SimulatedReport& report, std::span<const std::byte> whole, std::span<std::byte> buffer);

class SimulatedReports {
 public:
  SimulatedReports(ProgrammedMotion motion, SimulatedDeviceOptions options);
  SimulatedReports(Hand hand, SimulatedDeviceOptions options);

  const SimulatedDeviceOptions& options() const { return options_; }
  /// `now` must not decrease. Throws HandDiverged, once: from then on the device stays where it was, and nobody holds it.
  void advance(RealTime now);
  bool is_gone() const { return gone_; }
  /// With a hand, not before any instant asked for or advanced to.
  glm::dvec3 position_m(RealTime at);
  /// A hand feels the force from `now` + force_delay on.
  void feel(RealTime now, const glm::dvec3& force_N);

  /// The oldest report; a read that is interrupted takes none, nor does one of a tick that is `unread`.
  bool take_interruption() { return interruptions_ > 0 && interruptions_-- > 0; }
  std::optional<SimulatedReport> take() { return unread_tick_ == next_tick_ - 1 ? std::nullopt : queue_.pop(); }
  /// A report of another kind, made now.
  void push(std::uint64_t other) { queue_.push({next_tick_ - 1, {}, other}); }
  /// What becomes of an output report: ok, rejected, or `lost` set and ok.
  HidWrite write_fault(bool& lost);
  std::int64_t dropped() const { return queue_.dropped(); }

 private:
  struct Late {
    std::int64_t due;
    SimulatedReport report;
  };
  std::int64_t next_event() const;
  void make_ticks(std::int64_t last);
  void make_faulty_tick(std::int64_t tick);
  glm::dvec3 position_at(std::int64_t tick);

  SimulatedDeviceOptions options_;  // faults in order of their ticks
  ProgrammedMotion motion_;
  std::optional<Hand> hand_;  // instead of motion_
  glm::dvec3 hand_m_{0};      // where it was last
  bool has_let_go_ = false;   // the hand has diverged
  ReportQueue<SimulatedReport> queue_;
  std::vector<Late> late_;  // in order of due
  std::size_t next_fault_ = 0;
  std::int64_t next_tick_ = 0;
  std::int64_t unread_tick_ = -2;  // the last one of its kind; -2: none
  std::int64_t interruptions_ = 0, writes_to_lose_ = 0, writes_to_reject_ = 0;
  bool gone_ = false;
};

}  // namespace evenstep
