#include "evenstep/harness/live_run.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/recorded_timing.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/loop/haptic_loop.h"
#include "evenstep/loop/recorder.h"
#include "evenstep/scheduler/live_lanes.h"

namespace evenstep {
namespace {

/// Long enough for both lanes to be set up and scheduled before t = 0.
constexpr Duration kStartDelay{100'000'000};
/// A device reports all the time; its lane starts to read this long before its first tick.
constexpr Duration kListenBefore{500'000};
/// Priorities: below the kernel's own threaded interrupts (50), and the device above the simulation.
constexpr int kDevicePriority = 45;
constexpr int kSimulationPriority = 40;

/// The most entries that one lane adds while the other one reads: a second of ticks.
constexpr std::size_t kSpare = 1024;
/// In a replay a lane may run ahead by as much as it was late in the live run; at most by all entries that there are.
std::size_t all_entries(const LiveRecording& recording) {
  std::size_t entries = recording.record.steps.size() + 1;  // one more for the unfinished step
  for (const DeviceInputs& inputs : recording.inputs) entries = std::max(entries, inputs.ticks.size());
  return entries;
}

/// Whoever watches is told when the loop begins and, whatever way that comes, when it has ended.
class Viewing {
 public:
  Viewing(LiveView* view, StrategyLanes& lanes, WallEpoch epoch) : view_(view) {
    if (!view_) return;
    watch_ = std::make_unique<LoopWatch>();
    lanes.show(*watch_);
    view_->begin(*watch_, epoch);
  }
  ~Viewing() {
    if (view_) view_->end();
  }
  Viewing(const Viewing&) = delete;
  Viewing& operator=(const Viewing&) = delete;

 private:
  LiveView* view_;
  std::unique_ptr<LoopWatch> watch_;
};

/// On a wall clock lanes run late, so rings hold four times what the programmed timing needs, and at least 64 entries.
std::vector<LinkSpec> live_links(const Scenario& scenario, StrategyPlan plan, std::size_t spare) {
  plan.interaction_capacity = 4 * plan.interaction_capacity + 64;
  plan.force_capacity = 4 * plan.force_capacity + 64;
  std::vector<LinkSpec> links = links_of(scenario, plan);
  for (LinkSpec& link : links) link.spare = spare;
  return links;
}

/// step = "real": the steps of a segment run one after the other as fast as the solver can, without a programmed minimum.
class RealSteps final : public StepTiming {
 public:
  explicit RealSteps(std::unique_ptr<StepTiming> programmed) : programmed_(std::move(programmed)) {}
  bool next(SegmentTiming& segment) override {
    if (!programmed_->next(segment)) return false;
    if (segment.steps.empty()) return true;
    const RealTime start = segment.steps.front().begin;
    for (Interval& step : segment.steps) step = {start, start};
    return true;
  }

 private:
  std::unique_ptr<StepTiming> programmed_;
};

std::unique_ptr<StepTiming> make_live_timing(const Scenario& scenario) {
  std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  if (scenario.timing.real_steps) timing = std::make_unique<RealSteps>(std::move(timing));
  return timing;
}

bool ended_badly(const RunStatus& status) { return status.end == RunEnd::failed || status.end == RunEnd::limit; }

/// Adds the step that was running when the run ended: it was launched but did not complete. A replay must launch it too.
void add_unfinished_step(const std::vector<Event>& events, RealTime end, std::size_t finished,
                         std::vector<SegmentTiming>& segments) {
  std::size_t launched = 0;
  RealTime last_launch;
  for (const Event& event : events) {
    if (std::string_view(event.name.text) != "launch") continue;
    ++launched;
    last_launch = event.time;
  }
  if (launched > finished && !segments.empty()) segments.back().steps.push_back({last_launch, std::max(end, last_launch)});
}

/// What replay and shadows play: the visualization where nothing else ran, no idle rest, and the unfinished step.
std::vector<SegmentTiming> timing_of(const StrategyRecord& record, const std::vector<Event>& events, RealTime end) {
  std::vector<SegmentTiming> segments = recorded_timing(record);
  for (SegmentTiming& segment : segments) {
    if (!segment.visualization) continue;
    const Duration length = segment.visualization->end - segment.visualization->begin;
    RealTime begin = segment.begin;
    if (!segment.steps.empty() && segment.steps.front().begin < begin + length)
      begin = segment.steps.back().end;  // steps first
    segment.visualization = Interval{begin, begin + length};
  }
  add_unfinished_step(events, end, record.steps.size(), segments);
  for (SegmentTiming& segment : segments) {
    segment.end = segment.visualization ? segment.visualization->end : segment.begin;
    if (!segment.steps.empty()) segment.end = std::max(segment.end, segment.steps.back().end);
  }
  return segments;
}

/// A device that is not there, or may not be opened, makes the run fail, just like one that is unplugged later.
std::unique_ptr<LiveDevices> open_devices(const Scenario& scenario, const WallClock& clock,
                                          const LiveDeviceOptions& options) {
  try {
    return std::make_unique<LiveDevices>(scenario, clock, options);
  } catch (const DeviceError& error) {
    throw RunFailure("device", error.what(), "`evenstep devices` lists the devices and what each of them needs");
  }
}

}  // namespace

std::string wall_clock_objection(const Scenario& scenario) {
  if (scenario.case_spec)
    return "a [case] drives the solver itself, as fast as it can: there is no clock; leave --clock out";
  const auto minimal = [](const Budget& budget) {
    return budget.kind == Budget::Kind::any_phase || budget.kind == Budget::Kind::this_phase;
  };
  if (minimal(scenario.remap.latency) || minimal(scenario.remap.lead)) {
    return "[remap] latency and lead cannot be \"minimal\" on a wall clock, where the timing is not known before the run; "
           "give durations, for example --set remap.latency=\"25 ms\" --set remap.lead=\"3 ms\", or let the latency adapt";
  }
  const auto& trace = scenario.timing.trace;
  if (std::any_of(trace.begin(), trace.end(), [](const SegmentTiming& segment) { return segment.overlaps(); })) {
    return "a trace whose visualization overlaps its steps runs on the virtual clock only";
  }
  if (scenario.remap.interaction_underrun == InteractionUnderrun::gate) {
    return "[remap] underrun: the gate changes the programmed schedule, which a wall clock does not let it do; write "
           "interaction = \"clamp\" or \"extrapolate\"";
  }
  if (scenario.interrupt) return "[run] interrupt is a signal in virtual time; leave it out and press Ctrl-C";
  if (!scenario.keep_rows) return "[run] keep = \"summary\" leaves out the events that a live run is replayed from";
  if (scenario.timing.programmed.order == SegmentOrder::concurrent)
    return "[timing] order = \"concurrent\" runs on the virtual clock only";
  if (traits_of(scenario.live).knows_motion) return "[run] live cannot be \"ideal\": it knows the future";
  return {};
}

LiveRecording run_live(const Scenario& scenario, const StrategyPlan& plan, const LiveDeviceOptions& options,
                       const RunControl& control) {
  LiveRecording recording;
  const std::string name = name_of(plan.kind);
  // It may compile for a second, so this is done before t = 0 is chosen.
  std::unique_ptr<Solver> solver = make_scenario_solver(scenario, plan.kind);
  const WallEpoch epoch = WallEpoch::in(kStartDelay);
  WallClock device_clock(epoch), simulation_clock(epoch);
  const std::unique_ptr<LiveDevices> devices = open_devices(scenario, device_clock, options);
  DeviceExchange exchange(live_links(scenario, plan, kSpare), devices->drivers(), &recording.inputs);
  StrategyLanes lanes(scenario, plan, std::move(solver), exchange, make_live_timing(scenario), devices->drivers());
  WorkerExecutor worker(simulation_clock);
  InlineExecutor no_work;
  Scheduler simulation(simulation_clock, worker, {control.limits, control.permute_ties, true});
  Scheduler device(device_clock, no_work, {control.limits, control.permute_ties, true});
  lanes.spawn(device, simulation);

  const RealTime end{scenario.run_duration.ns};
  SlicedRun on_device;
  RunControl quiet = control;
  quiet.progress = nullptr;
  std::optional<Viewing> viewing(std::in_place, control.view, lanes, epoch);
  LaneThread device_thread([&] {
    recording.device_grant = request_real_time(kDevicePriority);
    device_clock.wait_until(RealTime{} - kListenBefore);
    devices->forget_queued();
    on_device = run_in_slices(device, end, name, quiet);
    if (ended_badly(on_device.status)) simulation.request_stop();
  });
  recording.simulation_grant = request_real_time(kSimulationPriority);
  // Whoever watches shows how far it is; this thread then writes to no terminal, which may make it wait.
  const SlicedRun in_simulation = run_in_slices(simulation, end, name, control.view ? quiet : control);
  if (ended_badly(in_simulation.status)) device.request_stop();  // there will be no more forces
  device_thread.join();
  viewing.reset();
  devices->stop_simulated();
  throw_if_failed(on_device.status, name, static_cast<std::int64_t>(lanes.record().steps.size()));
  throw_if_failed(in_simulation.status, name);

  recording.record = lanes.finish(merge(simulation.events(), device.events()));
  recording.record.interrupted = on_device.interrupted || in_simulation.interrupted;
  for (std::size_t tool = 0; tool < recording.record.devices.size(); ++tool)
    recording.record.devices[tool].counters.merge(devices->counters(tool));
  recording.timing = timing_of(recording.record, simulation.events(), end);
  return recording;
}

StrategyRecord replay(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                      const RunControl& control) {
  RecordedExchange exchange(live_links(scenario, plan, all_entries(recording)), recording.inputs, true);
  StrategyLanes lanes(scenario, plan, make_scenario_solver(scenario, plan.kind), exchange,
                      make_replayed_timing(recording.timing), {});
  VirtualClock device_clock, simulation_clock;
  InlineExecutor executor;
  Scheduler simulation(simulation_clock, executor, {control.limits, control.permute_ties, true});
  Scheduler device(device_clock, executor, {control.limits, control.permute_ties, true});
  lanes.spawn(device, simulation);

  // Each lane goes only as far as the other one had got during the recording, which the recorded heads tell.
  const RealTime end{scenario.run_duration.ns};
  const auto next_before_end = [&](Scheduler& scheduler) {
    const auto key = scheduler.next();
    return key && key->time < end ? key : std::nullopt;
  };
  for (;;) {
    const auto tick = next_before_end(device);
    const auto event = next_before_end(simulation);
    const bool tick_ready = tick && exchange.next_tick_ready();
    const bool event_ready = event && (event->lane != Lane::launch || exchange.next_step_ready());
    if (!tick_ready && !event_ready) break;  // both at their end
    const bool tick_first = tick_ready && (!event_ready || tick->time <= event->time);
    if (!(tick_first ? device : simulation).run_one()) break;
  }
  throw_if_failed(device.status(), name_of(plan.kind));
  throw_if_failed(simulation.status(), name_of(plan.kind));
  StrategyRecord record = lanes.finish(merge(simulation.events(), device.events()));
  record.shadow = true;
  return record;
}

StrategyRecord run_shadow(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                          const RunControl& control) {
  VirtualClock clock;
  RecordedExchange exchange(live_links(scenario, plan, kSpare), recording.inputs, false);
  StrategyRecord record = run_lanes(scenario, plan, {clock, exchange, make_replayed_timing(recording.timing), {}}, control);
  record.shadow = true;
  return record;
}

}  // namespace evenstep
