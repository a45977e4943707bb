#pragma once
/// Two slot maps that people use where samples come from elsewhere: for comparison with `phase_locked`, not for use.

#include "evenstep/remap/slot_map.h"

namespace evenstep {

/// "Linear with a delay": each result keeps the time at which its step began, and is played a constant L later, on the line
/// to the next one. slot(n) = S(n). With least latency nothing is ever late, and at constant velocity the played line is
/// exact; but a step that began late is spaced as it came, so x(n) is as uneven in simulation time as with `direct`.
class StampMap final : public SlotMap {
 public:
  using SlotMap::SlotMap;
  void boundary(std::int64_t, RealTime) override {}

 protected:
  void began(std::int64_t, RealTime begin) override { begin_ = begin; }
  std::optional<RealTime> slot(std::int64_t) override { return begin_; }

 private:
  RealTime begin_;
};

/// "Absolute grid": the first result sets the origin, and result n counts as n nominal periods later, whatever happens:
/// slot(n) = S(0) + floor(n / rate). It is as even as can be, and knows nothing of the pace. If the source's clock is faster
/// by p, the latency needed grows by p per second; if it is slower by p, results are late once the buffer L is used up,
/// after L / p.
class AbsoluteGridMap final : public SlotMap {
 public:
  AbsoluteGridMap(Rate step_rate, Duration lead, const AdaptiveLatency& latency)
      : SlotMap(lead, latency), step_rate_(step_rate) {}
  void boundary(std::int64_t, RealTime) override {}

 protected:
  void began(std::int64_t n, RealTime begin) override {
    if (n == 0) origin_ = begin;
  }
  std::optional<RealTime> slot(std::int64_t n) override { return tick_time(step_rate_, n, origin_); }

 private:
  Rate step_rate_;
  RealTime origin_;
};

}  // namespace evenstep
