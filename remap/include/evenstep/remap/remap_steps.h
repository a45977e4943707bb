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
#include <cstdint>

#include "evenstep/remap/slot_map.h"

namespace evenstep {

struct StepEmission {
  RealTime at;    ///< F(n)
  Duration late;  ///< E(n) - F(n) if the step ended after its force was due, else 0; 0 for a step without a slot
  Slot slot = {};
  RealTime arrives = {};  ///< E(n), or the time at which the force is at the device if that is later
  bool lost = false;      ///< it never comes to the device
};

class RemapSteps {
 public:
  /// The map must live as long as this, and be told of its steps by nobody else.
  explicit RemapSteps(SlotMap& map) : map_(map) {}

  void segment(RealTime begin) { map_.boundary(number_, begin); }
  Slot begin(RealTime began, Duration postponed = {}) { return slot_ = map_.read(number_, began, postponed); }
  /// `ended`: with a source, when the force is at the device. A lost force is never late.
  StepEmission end(RealTime ended, Duration postponed = {}, bool lost = false) {
    const RealTime at = map_.emission(number_++, ended, postponed);
    const bool due = slot_.kind == SlotKind::mapped && !lost;
    return {at, due ? std::max(ended - at, Duration{}) : Duration{}, slot_, ended, lost};
  }
  /// n of the step that runs or, between two steps, of the next one. Counts from 0.
  std::int64_t number() const { return number_; }

 private:
  SlotMap& map_;
  std::int64_t number_ = 0;
  Slot slot_;
};

}  // namespace evenstep
