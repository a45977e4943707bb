#pragma once
/// The map for a loop that knows its own simulation time, such as a game's fixed time step: nothing is estimated. With dt
/// the step size, n dt rounded down to ns, and t(n) the loop's own time when step n begins (SlotMap::simulated),
///
///   D(n) = t(n) - t(0) - n dt                                 what the loop has dropped before step n
///   M(n) = M(n - 1) + clamp(D(n) - M(n - 1), -most, most)     M(-1) = 0: what the slots have followed of it
///   slot(n) = S(0) + n dt + M(n)                              S(0): when step 0 began
///
/// While the loop keeps up with real time D stays 0, and slots are exactly even: the jump is 0 (1 ns where dt is no whole
/// number of ns). Where it drops time, they follow at once if `most` allows it, and the hand jumps as the simulation does;
/// or by `most` per step, and forces need more latency until then. A constant in the slots cancels between lead and latency,
/// so it does not matter that S(0) is some instant of the first frame. A step whose t is not told follows the one before by
/// dt.
///
/// Outside its domain: a loop that does not keep up and drops nothing (or runs faster than real time) needs a lead and a
/// latency that grow for as long as it runs.

#include "evenstep/remap/slot_map.h"

namespace evenstep {

/// How a clocked map is set up.
struct Clocked {
  Rate step_rate{60, 1};  ///< 1 / dt
  Duration most{
      std::int64_t{1} << 62};  ///< by how much a step may move the slots where time was dropped, > 0; as it is: all
};

class ClockedMap final : public SlotMap {
 public:
  ClockedMap(const Clocked& clock, Duration lead, const AdaptiveLatency& latency) : SlotMap(lead, latency), clock_(clock) {}
  void boundary(std::int64_t, RealTime) override {}
  void simulated(SimTime t) override { told_ = t; }

 protected:
  void began(std::int64_t n, RealTime begin) override {
    if (n == 0) origin_ = begin;
  }
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  Clocked clock_;
  RealTime origin_;
  std::optional<SimTime> told_;    // t of the step that begins
  std::optional<Duration> ahead_;  // t(n) - n dt of the first step whose t was told
  Duration dropped_, moved_;       // D(n), M(n)
};

}  // namespace evenstep
