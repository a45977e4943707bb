#include "evenstep/loop/haptic_loop.h"

#include <algorithm>
#include <cmath>

#include "evenstep/loop/segment_pace.h"

namespace evenstep {
namespace {

SaturationCauses causes_of(const DeviceLane& lane, const DeviceSample& sample, const glm::dvec3& written_N) {
  const GuardLimited& guard = lane.guard.limited();
  SaturationCauses causes;
  causes.add(SaturationCause::clamp, guard.clamped);
  causes.add(SaturationCause::slew, guard.slewed);
  causes.add(SaturationCause::cut, guard.cut);
  causes.add(SaturationCause::non_finite, guard.non_finite);
  causes.add(SaturationCause::device_position, sample.at_range);
  if (!lane.device) return causes;
  const double most_N = lane.device->largest_force_N();
  for (int axis = 0; axis < 3; ++axis) causes.add(SaturationCause::device_force, std::abs(written_N[axis]) > most_N);
  return causes;
}

/// Runs the visualization, or waits as long as it would take.
Scheduler::External visualize(Scheduler& scheduler, const Pause& pause, const SegmentTiming& segment,
                              Visualization* visualization, StepRecorder& record) {
  record.visualization_begins(scheduler.now(), visualization == nullptr ? pause.length : kLongestRun);
  if (visualization == nullptr) return scheduler.external(scheduler.now() + pause.length, nullptr, "visualization");
  visualization->begins(pause.length, segment.drawing);
  return scheduler.external(scheduler.now(), visualization, "visualization");
}

/// What has really been drawn is kept, and told to the timing.
void visualized(Scheduler& scheduler, const Visualization* visualization, StepRecorder& record, StepTiming& timing) {
  if (visualization == nullptr) return;
  timing.visualized(record.visualization_ends(scheduler.now(), visualization->finished()), visualization->finished());
}

}  // namespace

Task device_lane(Scheduler& scheduler, DeviceLane& lane, Exchange& exchange, DeviceRecorder& record) {
  for (std::int64_t k = 0, skipped = 0;; k += 1 + skipped) {
    const Arrival arrival = co_await scheduler.until(tick_time(lane.rate, k, lane.first_tick), Lane::device, "tick");
    lane.skipped += skipped;
    const DeviceSample sample = exchange.sense(lane.tool, scheduler);
    Played played = exchange.play(lane.tool, sample);
    SentForce sent;
    sent.force_N = lane.guard.pass(played.at, played.force_N.value, {sample, played.due()});
    if (played.spring) played.spring = exchange.render(lane.tool, lane.guard.share(*played.spring));
    const glm::dvec3 written_N = sent.force_N - played.sprung_N(sample.position_m);
    if (lane.device) lane.device->write(written_N);
    sent.saturated = causes_of(lane, sample, written_N);
    sent.guard = lane.guard.state();
    record.tick(scheduler, arrival, sample, played, sent);
    // Ticks that were missed because this one ran late are skipped and not sent in a burst; the tick that is due now still
    // runs.
    const std::int64_t due = first_tick_at_or_after(lane.rate, played.at + Duration{1}, lane.first_tick) - 1;
    skipped = std::max<std::int64_t>(due - (k + 1), 0);
  }
}

Task simulation_lane(Scheduler& scheduler, StepTiming& timing, SlotMap& map, SolverStep& solver, Exchange& exchange,
                     StepRecorder& record, Visualization* visualization) {
  SegmentTiming segment;
  RemapSteps steps(map);
  Postponement pushed;  // the delay caused by the waits of a gate
  while (timing.next(segment)) {
    co_await scheduler.until(pushed.begin(segment.begin), Lane::launch, "segment");
    const bool own_lane = segment.overlaps();  // the visualization has a thread of its own, so there is no pause here
    // 3 b: the segment, split into slots.
    steps.segment(own_lane ? segment.begin : scheduler.now() - pushed.by());
    record.segment(segment, scheduler.now());
    const Pause pause = pause_of(segment, own_lane);
    if (pause.before_steps) {
      pushed.end(segment.visualization->end);
      co_await visualize(scheduler, pause, segment, visualization, record);  // 3 d: the large delay
      visualized(scheduler, visualization, record, timing);
    }
    for (const Interval& step : segment.steps) {
      // An event of its own, so that it comes after the sample of the same instant.
      co_await scheduler.until(pushed.begin(step.begin), Lane::launch, "launch");
      const RealTime launched = scheduler.now();
      const Slot slot = steps.begin(launched, pushed.by(), segment.simulated_at(step));  // 3 c: the slot's time
      for (int tool = 0; tool < exchange.tool_count(); ++tool) {
        Reading<glm::dvec3> hand = exchange.hand(tool, slot);  // 3 a: the buffered hand
        while (exchange.must_wait(tool, hand)) {
          co_await scheduler.until(exchange.next_sample(tool, slot, scheduler.now()), Lane::launch, "gate");
          hand = exchange.hand(tool, slot);
        }
        solver.give(tool, hand.value, std::min(slot.read, hand.newest));
        record.hand(tool, steps.number(), slot, hand, scheduler.now() - launched);
      }
      const RealTime began = scheduler.now();
      pushed.wait(began - launched);
      solver.begins(began);
      co_await scheduler.external(pushed.end(step.end), &solver, "step");  // 4 b: a constant amount of simulation time
      const Transport way = segment.transport(step);                       // at once, but for a source
      const StepEmission emission = steps.end(scheduler.now() + way.delay, pushed.by(), way.lost);  // 4 d: inverse of 3 c
      for (int tool = 0; tool < exchange.tool_count(); ++tool) {
        exchange.respond(tool, emission, solver.contact(tool));  // 4 e: evenly
      }
      record.step(scheduler, segment, step, slot, began, emission, solver);
    }
    if (pause.after_steps) {
      pushed.end(segment.visualization->end);
      co_await visualize(scheduler, pause, segment, visualization, record);
      visualized(scheduler, visualization, record, timing);
    }
  }
}

}  // namespace evenstep
