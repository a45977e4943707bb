#pragma once
/// What an observer can see of a live loop while it runs. Each lane puts what it did into a ring and never checks whether
/// anybody reads it: a push is a copy and a store. A reader that falls behind finds the oldest entries gone, and counts them
/// (`SeenRing::take`). A loop that is not watched has no LoopWatch, and only checks whether there is one.
///
/// Only the device lane's thread pushes into `ticks`, only the simulation lane's into `steps`; one other thread reads both.
/// Nothing in here is an input of the loop, and nothing is hashed.

#include <array>
#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>

#include "evenstep/device/force_guard.h"
#include "evenstep/remap/timed_ring.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/sim/scene.h"

namespace evenstep {

/// One tick of one device, after its force was sent.
struct SeenTick {
  RealTime scheduled;
  Duration lateness;
  DeviceSample sample;
  glm::dvec3 force_N{0};  ///< after the guard
  std::int64_t ran = 0;   ///< ticks of this device so far, this one included
  std::uint32_t tool = 0;
  GuardState guard = GuardState::waiting;
  SaturationCauses saturated;
};

/// One step, after its force was put into the schedule. Margins are times to spare: below 0 it was late.
struct SeenStep {
  std::int64_t number = 0;  ///< n
  RealTime end;             ///< E(n)
  SimTime simulated;        ///< simulation time of the step
  bool mapped = false;      ///< it has a slot, and so margins
  Duration force_margin;    ///< deadline of the force (StepEmission) - E(n), of the tool with the earliest
  std::int64_t late_reads = 0, late_forces = 0;  ///< of all tools, so far
  struct Tool {
    RealTime newest;         ///< when the newest sample that it could see was taken
    Duration sample_margin;  ///< newest - R(n)
    glm::dvec3 hand_m{0};    ///< x_n, what the solver was given
    bool sampled = true;     ///< false: there was no sample yet, so the hand was taken to be at 0
  };
  std::array<Tool, kMaxTools> tools{};
};

/// The newest entries that one thread has put in, for one reader.
template <class Seen>
class SeenRing {
 public:
  explicit SeenRing(std::size_t capacity) : ring_(capacity) {}
  /// Writer only. It never waits.
  void push(const Seen& seen) { ring_.push(RealTime{}, seen); }
  /// Reader only. Hands all new entries to `use`, the oldest first.
  template <class Use>
  void take(const Use& use) {
    for (const std::uint64_t head = ring_.head(); next_ < head; ++next_) {
      typename TimedRing<Seen>::Entry entry;
      if (ring_.get(next_, head, entry))
        use(entry.value);
      else
        ++dropped_;
    }
  }
  /// Reader only: entries so far that were overwritten before the reader took them.
  std::uint64_t dropped() const { return dropped_; }

 private:
  TimedRing<Seen> ring_;
  std::uint64_t next_ = 0, dropped_ = 0;
};

struct LoopWatch {
  /// Two seconds of two devices at 1 kHz, and more than that of steps; a reader comes fifty times a second.
  static constexpr std::size_t kTicks = 4096, kSteps = 2048;
  SeenRing<SeenTick> ticks{kTicks};
  SeenRing<SeenStep> steps{kSteps};
};

}  // namespace evenstep
