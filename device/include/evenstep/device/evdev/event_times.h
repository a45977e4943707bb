#pragma once
/// When the positions of an event device were taken: by the time at which Linux got the event that completed one
/// (SYN_REPORT), in the clock of the run. Nothing has to be followed, as DeviceClock does, since both clocks are one.
///
/// Linux tells changes only, so that nothing comes is news as well. A position without an event since then holds until the
/// device's newest report that must have come by now: the one of `unchanged_age` ago, which is the longest interval between
/// two of its reports and the longest way of an event to its reader. It does not hold until now: a hand that moves has gone
/// on since the last report, and to say otherwise at every tick between two reports would be the error of velocity times age
/// that event times are there to remove. docs/ages.md has the argument.
///
/// Times of events are not trusted. One that is in the future, or more than a second before the read that finds it, counts
/// as not known: the time is that of the read, or the one from which an unchanged position would hold. A time is at most its
/// read, at most a second before it, and after the time before it (by 1 ns, where events would have it otherwise). All that
/// was moved is counted.

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
  /// No event has come. False: that says nothing new yet.
  bool unchanged(RealTime read);
  /// `ages`: of positions with an event of their own; `ahead`: events from the future, an hour at most.
  const SampleAges& ages() const { return ages_; }

 private:
  Duration unchanged_age_;
  SampleAges ages_;
  std::optional<RealTime> taken_;
};

}  // namespace evenstep
