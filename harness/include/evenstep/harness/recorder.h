#pragma once
/// Writes down what the lanes did (one call per tick and per step) and mixes it into the trace hash.

#include <glm/vec3.hpp>

#include "evenstep/harness/exchange.h"
#include "evenstep/harness/scenario.h"
#include "evenstep/remap/slot_map.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

class SolverStep;

inline Vec3 to_vec3(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

class DeviceRecorder {
 public:
  explicit DeviceRecorder(DeviceRecord& record) : record_(record) {}
  void tick(Scheduler& scheduler, const Arrival& arrival, const DeviceSample& sample, const Played& played,
            const glm::dvec3& force_N);

 private:
  DeviceRecord& record_;
};

class StepRecorder {
 public:
  StepRecorder(StrategyRecord& record, StrategyKind kind, const RemapSpec& remap)
      : record_(record), kind_(kind), remap_(remap) {}
  /// A segment began at `began` (later than programmed on a wall clock).
  void segment(const SegmentTiming& segment, RealTime began);
  /// What step n reads, after having waited for it (policy `gate`).
  void hand(int tool, std::int64_t n, const Slot& slot, const Reading<glm::dvec3>& hand, Duration waited);
  void step(Scheduler& scheduler, const SegmentTiming& segment, const Slot& slot, RealTime began, RealTime emission,
            const SolverStep& solver);

 private:
  StepRead read_of(const Slot& slot, const Reading<glm::dvec3>& hand, Duration waited) const;

  StrategyRecord& record_;
  StrategyKind kind_;
  const RemapSpec& remap_;
  std::array<StepRead, kMaxTools> reads_{};
};

}  // namespace evenstep
