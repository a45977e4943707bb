#pragma once
/// When the positions of an event device were taken: at the time, in the clock of the run, at which Linux got the event that
/// completed a position (SYN_REPORT). No clock has to be followed, as in DeviceClock, since Linux and the run count by the
/// same one.
///
/// Linux tells changes only, so if nothing comes, that is news as well. A position that no later event has changed still
/// held at the newest report that must have come by now, `unchanged_age` ago: that is the longest interval between two
/// reports of the device plus the longest way of an event to its reader. It need not hold now: a hand that moves has gone on
/// since the last report, and to say otherwise at every tick between two reports would be the error of velocity times age
/// that event times are there to remove. docs/devices/ages.md has the argument.
///
/// Times of events are not trusted. For an event in the future the time of the read counts; for one more than a second
/// before the read that finds it, the time at which an unchanged position held. A time is never after its read, never more
/// than a second before it, and after the previous time (by 1 ns, where events would have it otherwise). Every time that was
/// moved is counted.

#include <optional>

#include "evenstep/device/device_clock.h"

namespace evenstep {

class EventTimes {
 public:
  explicit EventTimes(Duration unchanged_age) : unchanged_age_(unchanged_age) {}
  /// When the newest position was taken; before the first, longer before `read` than any will be.
  RealTime taken(RealTime read) const;
  /// A position was completed by an event of that time. Reads do not decrease.
  void changed(RealTime event, RealTime read);
  /// No event has come. Returns false if that says nothing new yet.
  bool unchanged(RealTime read);
  /// `ages`: of positions with an event of their own; `ahead`: events from the future, an hour at most.
  const SampleAges& ages() const { return ages_; }

 private:
  Duration unchanged_age_;
  SampleAges ages_;
  std::optional<RealTime> taken_;
};

}  // namespace evenstep
