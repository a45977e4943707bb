#include "evenstep/harness/recorder.h"

#include <algorithm>

#include "evenstep/harness/solver_step.h"

namespace evenstep {
namespace {

void note(Scheduler& scheduler, const glm::dvec3& v) {
  scheduler.note(v.x);
  scheduler.note(v.y);
  scheduler.note(v.z);
}

StepRead step_read(ReadStatus status) {
  switch (status) {
    case ReadStatus::inside:
      return StepRead::inside;
    case ReadStatus::overrun:
      return StepRead::overrun;
    case ReadStatus::underrun:
    case ReadStatus::empty:
      return StepRead::underrun;
  }
  return StepRead::underrun;
}

}  // namespace

void DeviceRecorder::tick(Scheduler& scheduler, const Arrival& arrival, const DeviceSample& sample, const Played& played,
                          const glm::dvec3& force_N) {
  scheduler.note(static_cast<std::uint64_t>(sample.read_at.ns));
  scheduler.note(static_cast<std::uint64_t>(played.at.ns));
  note(scheduler, sample.position_m);
  note(scheduler, force_N);
  record_.ticks.push_back({arrival.scheduled, arrival.lateness(), to_vec3(sample.position_m), to_vec3(force_N),
                           played.force_N.status != ReadStatus::empty});
}

void StepRecorder::segment(const SegmentTiming& segment, RealTime began) {
  SegmentRow row{segment.index, segment.overlaps() ? segment.begin : began, {}, std::nullopt};
  row.end = row.begin + (segment.end - segment.begin);
  if (segment.visualization) row.visualization = {{segment.visualization->begin, segment.visualization->end}};
  record_.segments.push_back(row);
}

void StepRecorder::hand(int tool, const Reading<glm::dvec3>& hand) {
  const std::size_t device = static_cast<std::size_t>(tool);
  reads_[device] = step_read(hand.status);
}

void StepRecorder::step(Scheduler& scheduler, const SegmentTiming& segment, const Slot& slot, RealTime began,
                        RealTime emission, const SolverStep& solver) {
  scheduler.note(static_cast<std::uint64_t>(slot.read.ns));
  scheduler.note(static_cast<std::uint64_t>(emission.ns));
  scheduler.note(solver.state_digest);
  record_.steps.push_back({segment.index, began, scheduler.now(), slot.read, emission, slot.kind == SlotKind::mapped,
                           slot.kind == SlotKind::acquiring});
  for (std::size_t device = 0; device < record_.devices.size(); ++device) {
    note(scheduler, solver.positions_m[device]);
    note(scheduler, solver.response.force_N[device]);
    StepRead read = reads_[device];
    if (slot.kind == SlotKind::newest) read = StepRead::newest;
    if (slot.kind == SlotKind::acquiring) read = StepRead::acquiring;
    record_.devices[device].steps.push_back(
        {to_vec3(solver.positions_m[device]), to_vec3(solver.response.force_N[device]), read});
  }
}

}  // namespace evenstep
