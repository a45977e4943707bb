#pragma once
/// What the simulation lane holds of the remap: it numbers the steps and leads each of them through the map, from its begin
/// to the emission of its force (paper, Figures 3 and 4). The haptic loop and `Remapper` are both built from it.
///
///   segment(B)                a segment begins at B
///   slot = begin(S)           step n begins at S: it reads the hand at R(n)     SampleBuffer::hand(slot, head)
///   emission = end(E)         it has ended at E: its force is due at F(n)       ForceSchedule::push(emission.at, force)
///
/// One map serves all tools: the slot of a step is the same for each of them. begin() and end() alternate; any other order
/// fails an assertion. `postponed`: see SlotMap::read.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/slot_map.h"

namespace evenstep {

namespace internal {
/// Where the line of linear emission that leads to each force begins.
class LineStarts {
 public:
  /// F(n) of the last step before whose force was not lost; that of this step itself if there is none.
  RealTime next(RealTime at, bool lost) {
    const RealTime from = before_.value_or(at);
    if (!lost) before_ = at;
    return from;
  }

 private:
  std::optional<RealTime> before_;
};
}  // namespace internal

struct StepEmission {
  RealTime at;         ///< F(n)
  RealTime line_from;  ///< where the line to F(n) begins: F of the last step with a slot whose force was not lost. F(n) for
                       ///< the first step with a slot: no line leads there
  Slot slot = {};
  RealTime arrives = {};  ///< E(n), or the time at which the force is at the device if that is later
  bool lost = false;      ///< it never comes to the device
  /// t(n), if the loop knows it.
  std::optional<SimTime> simulated = {};

  /// When the force must be there, so that no tick misses it: with linear emission ticks need it on the whole line to F(n).
  /// What looks ahead in time while it plays forces needs it that much earlier.
  RealTime deadline(Emission emission, Duration ahead = {}) const {
    return (emission == Emission::linear ? line_from : at) - ahead;
  }
  /// How long after its deadline the force came, else 0. A lost force, or that of a step without a slot, is never late.
  Duration late(Emission emission, Duration ahead = {}) const {
    if (slot.kind != SlotKind::mapped || lost) return {};
    return std::max(arrives - deadline(emission, ahead), Duration{});
  }
};

class RemapSteps {
 public:
  /// The map must live as long as this, and be told of its steps by nobody else.
  explicit RemapSteps(SlotMap& map) : map_(map) {}

  void segment(RealTime begin) { map_.boundary(number_, begin); }
  /// `simulated`: t(n), if the loop knows it.
  Slot begin(RealTime began, Duration postponed = {}, std::optional<SimTime> simulated = {}) {
    simulated_ = simulated;
    if (simulated) map_.simulated(*simulated);
    return slot_ = map_.read(number_, began, postponed);
  }
  /// `ended`: with a source, when the force is at the device.
  StepEmission end(RealTime ended, Duration postponed = {}, bool lost = false) {
    const RealTime at = map_.emission(number_++, ended, postponed);
    return {at, lines_[slot_.kind == SlotKind::mapped].next(at, lost), slot_, ended, lost, simulated_};
  }
  /// n of the step that runs or, between two steps, of the next one. Counts from 0.
  std::int64_t number() const { return number_; }

 private:
  SlotMap& map_;
  std::int64_t number_ = 0;
  Slot slot_;
  std::optional<SimTime> simulated_;
  std::array<internal::LineStarts, 2> lines_;  // between steps without a slot, and between those with one
};

}  // namespace evenstep
