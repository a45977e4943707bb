#pragma once
/// Records what the lanes did (one call per tick and per step), mixes it into the trace hash, and shows it to an observer
/// (loop_watch.h).

#include <glm/vec3.hpp>

#include "evenstep/loop/exchange.h"
#include "evenstep/loop/loop_watch.h"
#include "evenstep/remap/remap_steps.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

class SolverStep;

inline Vec3 to_vec3(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// The force of a tick after the guard, and what limited it and the sample.
struct SentForce {
  glm::dvec3 force_N{0};
  SaturationCauses saturated;
  GuardState guard;
};

class DeviceRecorder {
 public:
  explicit DeviceRecorder(DeviceRecord& record) : record_(record) {}
  void tick(Scheduler& scheduler, const Arrival& arrival, const DeviceSample& sample, const Played& played,
            const SentForce& sent);
  /// From now on every tick that it records is also put into `to`, as a tick of device `tool`.
  void show(SeenRing<SeenTick>& to, std::uint32_t tool) { watch_ = &to, tool_ = tool; }

 private:
  DeviceRecord& record_;
  std::int64_t ran_ = 0;  // counted here, because a live run takes rows away while it goes on
  SeenRing<SeenTick>* watch_ = nullptr;
  std::uint32_t tool_ = 0;
};

/// The words for late reads and late forces in underruns.csv.
struct UnderrunWords {
  bool predicts = false;         ///< the strategy reads past the newest sample by design, which is no underrun
  const char* interaction = "";  ///< what a step does if its sample is not there yet: "clamp"
  const char* force = "";        ///< what a tick does if its force is not there yet: "hold"
};

inline constexpr Duration kLongestRun{1'000'000'000'000'000};  ///< 1e6 s, as the format allows

/// The segment as it is known at `now`: a visualization that still runs (StepRecorder::visualization_begins) lasts until
/// then.
inline SegmentRow known_at(SegmentRow segment, RealTime now) {
  if (!segment.visualization) return segment;
  auto& [began, ended] = *segment.visualization;
  if (ended - began == kLongestRun) ended = std::max(now, began);
  return segment;
}

class StepRecorder {
 public:
  StepRecorder(StrategyRecord& record, const UnderrunWords& words) : record_(record), words_(words) {}
  /// A segment began at `began`, which on a wall clock is later than programmed.
  void segment(const SegmentTiming& segment, RealTime began);
  /// For a visualization that is not in a lane of its own: on a wall clock it may begin later than programmed. If it is
  /// really run, `length` is kLongestRun until visualization_ends.
  void visualization_begins(RealTime now, Duration length) { record_.segments.back().visualization = {{now, now + length}}; }
  /// Returns how long it took. `finished`: this visualization completed the drawing.
  Duration visualization_ends(RealTime now, bool finished) {
    SegmentRow& row = record_.segments.back();
    row.finishes = finished;
    (*row.visualization)[1] = now;
    return now - (*row.visualization)[0];
  }
  /// Step n has read `hand`, after having waited for it for `waited` (policy `gate`).
  void hand(int tool, std::int64_t n, const Slot& slot, const Reading<glm::dvec3>& hand, Duration waited);
  void step(Scheduler& scheduler, const SegmentTiming& segment, const Interval& programmed, const Slot& slot, RealTime began,
            const StepEmission& emission, const SolverStep& solver);
  /// From now on every step that it records is also put into `to`.
  void show(SeenRing<SeenStep>& to) { watch_ = &to; }
  std::int64_t steps() const { return steps_; }  ///< that have ended

 private:
  StepRead read_of(const Slot& slot, const Reading<glm::dvec3>& hand, Duration waited) const;

  StrategyRecord& record_;
  UnderrunWords words_;
  std::int64_t steps_ = 0;
  std::array<StepRead, kMaxTools> reads_{};
  SeenRing<SeenStep>* watch_ = nullptr;
  SeenStep seen_;  // of the step that runs; its counts are of all steps
};

}  // namespace evenstep
