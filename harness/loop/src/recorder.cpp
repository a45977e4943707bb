#include "evenstep/loop/recorder.h"

#include <algorithm>

#include "evenstep/loop/solver_step.h"

namespace evenstep {
namespace {

void note(Scheduler& scheduler, const glm::dvec3& v) {
  scheduler.note(v.x);
  scheduler.note(v.y);
  scheduler.note(v.z);
}

SpringRow to_row(const DeviceSpring& spring) {
  return {.center_m = to_vec3(spring.center_m),
          .below_N_per_m = to_vec3(spring.below_N_per_m),
          .above_N_per_m = to_vec3(spring.above_N_per_m),
          .limit_N = to_vec3(spring.limit_N)};
}

}  // namespace

void DeviceRecorder::tick(Scheduler& scheduler, const Arrival& arrival, const DeviceSample& sample, const Played& played,
                          const SentForce& sent) {
  scheduler.note(static_cast<std::uint64_t>(sample.read_at.ns));
  if (sample.taken_at) scheduler.note(static_cast<std::uint64_t>(sample.taken_at->ns));
  scheduler.note(static_cast<std::uint64_t>(played.at.ns));
  note(scheduler, sample.position_m);
  note(scheduler, sent.force_N);
  record_.ticks.push_back({.at = arrival.scheduled,
                           .lateness = arrival.lateness(),
                           .position_m = to_vec3(sample.position_m),
                           .force_N = to_vec3(sent.force_N),
                           .started = played.force_N.status != ReadStatus::empty,
                           .saturated = sent.saturated});
  ++ran_;
  if (watch_)
    watch_->push({.scheduled = arrival.scheduled,
                  .lateness = arrival.lateness(),
                  .sample = sample,
                  .force_N = sent.force_N,
                  .ran = ran_,
                  .tool = tool_,
                  .guard = sent.guard,
                  .saturated = sent.saturated});
  if (!played.spring) return;
  const DeviceSpring& spring = *played.spring;
  for (const glm::dvec3& part : {spring.center_m, spring.below_N_per_m, spring.above_N_per_m, spring.limit_N})
    note(scheduler, part);
  record_.springs.resize(record_.ticks.size());  // the ticks so far had no springs
  record_.springs.back() = to_row(spring);
}

void StepRecorder::segment(const SegmentTiming& segment, RealTime began) {
  SegmentRow row{segment.index, segment.overlaps() ? segment.begin : began, {}, std::nullopt};
  row.end = row.begin + (segment.end - segment.begin);
  row.finishes = segment.drawing.finishes;
  row.left_out = segment.drawing.left_out;
  if (segment.visualization) row.visualization = {{segment.visualization->begin, segment.visualization->end}};
  record_.segments.push_back(row);
}

StepRead StepRecorder::read_of(const Slot& slot, const Reading<glm::dvec3>& hand, Duration waited) const {
  if (hand.status == ReadStatus::empty) return StepRead::underrun;  // nor is there anything to predict from
  if (hand.status == ReadStatus::overrun) return StepRead::overrun;
  if (hand.status == ReadStatus::inside && waited.ns > 0) return StepRead::gated;
  if (slot.kind == SlotKind::newest) return StepRead::newest;
  if (slot.kind == SlotKind::acquiring) return StepRead::acquiring;
  if (hand.status == ReadStatus::inside) return StepRead::inside;
  return words_.predicts ? StepRead::predicted : StepRead::underrun;
}

void StepRecorder::hand(int tool, std::int64_t n, const Slot& slot, const Reading<glm::dvec3>& hand, Duration waited) {
  const StepRead read = read_of(slot, hand, waited);
  reads_[static_cast<std::size_t>(tool)] = read;
  if (watch_) {
    seen_.tools[static_cast<std::size_t>(tool)] = {hand.newest, hand.newest - slot.read, hand.value,
                                                   hand.status != ReadStatus::empty};
    seen_.late_reads += read == StepRead::underrun;
  }
  if (read != StepRead::underrun && read != StepRead::gated) return;
  const Duration lateness = read == StepRead::gated ? waited : slot.read - hand.newest;
  record_.underruns.push_back(
      {n, static_cast<std::uint32_t>(tool), UnderrunRow::Side::interaction, lateness, words_.interaction});
}

void StepRecorder::step(Scheduler& scheduler, const SegmentTiming& segment, const Interval& programmed, const Slot& slot,
                        RealTime began, const StepEmission& emission, const SolverStep& solver) {
  scheduler.note(static_cast<std::uint64_t>(slot.read.ns));
  scheduler.note(static_cast<std::uint64_t>(emission.at.ns));
  scheduler.note(solver.state_digest);
  const std::int64_t n = steps_++;
  record_.steps.push_back({.segment = segment.index,
                           .begin = began,
                           .end = scheduler.now(),
                           .read = slot.read,
                           .emission = emission.at,
                           .line_from = emission.line_from,
                           .mapped = slot.kind == SlotKind::mapped,
                           .acquiring = slot.kind == SlotKind::acquiring,
                           .lost = emission.lost,
                           .transport = emission.arrives - scheduler.now(),
                           .simulated = solver.simulated(),
                           .clock = segment.simulated_at(programmed)});
  for (std::uint32_t device = 0; device < record_.devices.size(); ++device) {
    note(scheduler, solver.positions_m[device]);
    note(scheduler, solver.response.force_N[device]);
    record_.devices[device].steps.push_back(
        {to_vec3(solver.positions_m[device]), to_vec3(solver.response.force_N[device]), reads_[device]});
    const DeviceRecord& kept = record_.devices[device];
    const Duration late = emission.late(kept.interpolates ? Emission::linear : Emission::hold, kept.ahead);
    if (late.ns == 0) continue;
    record_.underruns.push_back({n, device, UnderrunRow::Side::force, late, words_.force});
    seen_.late_forces += watch_ != nullptr;
  }
  if (!watch_) return;
  seen_.number = n;
  seen_.end = scheduler.now();
  seen_.simulated = solver.simulated();
  seen_.mapped = slot.kind == SlotKind::mapped;
  seen_.force_margin = emission.at - seen_.end;
  for (const DeviceRecord& kept : record_.devices) {
    const RealTime deadline = emission.deadline(kept.interpolates ? Emission::linear : Emission::hold, kept.ahead);
    seen_.force_margin = std::min(seen_.force_margin, deadline - seen_.end);
  }
  watch_->push(seen_);
}

}  // namespace evenstep
