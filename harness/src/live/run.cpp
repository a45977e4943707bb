#include "evenstep/harness/live_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <new>
#include <numeric>
#include <optional>
#include <string_view>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/recorded_timing.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/harness/visualization.h"
#include "evenstep/loop/haptic_loop.h"
#include "evenstep/loop/recorder.h"
#include "evenstep/scheduler/live_lanes.h"
#include "src/log/live_rows.h"

namespace evenstep {

using internal::LiveRows;

namespace {

/// Long enough for both lanes to be set up and scheduled before t = 0.
constexpr Duration kStartDelay{100'000'000};
/// A device reports all the time; its lane starts to read this long before its first tick.
constexpr Duration kListenBefore{500'000};

/// The most entries that one lane adds while the other one reads: a second of ticks.
constexpr std::size_t kSpare = 1024;

/// Tells the view when the loop begins and, however it ends, when it has ended.
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

/// On a wall clock lanes run late, so rings hold four times what the programmed timing needs, and at least 64 entries; or as
/// many as the scenario says.
std::vector<LinkSpec> live_links(const Scenario& scenario, StrategyPlan plan, std::size_t spare) {
  if (!plan.needed) {
    plan.interaction_capacity = 4 * plan.interaction_capacity + 64;
    plan.force_capacity = 4 * plan.force_capacity + 64;
  }
  plan.needed.reset();  // what is written during a read is real here
  std::vector<LinkSpec> links = links_of(scenario, plan);
  for (LinkSpec& link : links) link.spare = spare;
  return links;
}

bool ended_badly(const RunStatus& status) { return status.end == RunEnd::failed || status.end == RunEnd::limit; }

/// What replay and shadows play: the visualization where nothing else ran, no idle rest, and the unfinished step.
class LiveTiming final : public StepTiming {
 public:
  /// `programmed`: what ran is a part of it; the recording does not say what the loop's own time was.
  LiveTiming(const LiveRecording& recording, RealTime end, std::unique_ptr<StepTiming> programmed)
      : segments_(recording.as_ran()),
        programmed_(std::move(programmed)),
        left_(recording.as_ran().segments.size()),
        unfinished_(recording.unfinished),
        end_(end) {}
  bool next(SegmentTiming& segment) override {
    const SegmentTiming* const ran = segments_.next();
    if (ran == nullptr) return false;
    segment = *ran;
    while (as_programmed_.index < segment.index && programmed_->next(as_programmed_)) {
    }
    // A damaged recording may have more steps than the scenario.
    const bool is_known = as_programmed_.index == segment.index &&
                          as_programmed_.simulated.size() >= segment.steps.size() + (left_ == 1 && unfinished_ ? 1 : 0);
    segment.simulated = is_known ? as_programmed_.simulated : std::vector<SimTime>();
    if (segment.visualization) {
      const Duration length = segment.visualization->end - segment.visualization->begin;
      RealTime begin = segment.begin;
      if (!segment.steps.empty() && segment.steps.front().begin < begin + length)
        begin = segment.steps.back().end;  // steps first
      segment.visualization = Interval{begin, begin + length};
    }
    if (--left_ == 0 && unfinished_) segment.steps.push_back({*unfinished_, std::max(end_, *unfinished_)});
    segment.end = segment.visualization ? segment.visualization->end : segment.begin;
    if (!segment.steps.empty()) segment.end = std::max(segment.end, segment.steps.back().end);
    return true;
  }

 private:
  RecordedSegments segments_;
  std::unique_ptr<StepTiming> programmed_;
  SegmentTiming as_programmed_{.index = -1};
  std::size_t left_;
  std::optional<RealTime> unfinished_;
  RealTime end_;
};

std::unique_ptr<StepTiming> timing_of(const Scenario& scenario, const LiveRecording& recording) {
  return std::make_unique<LiveTiming>(recording, RealTime{scenario.run_duration.ns}, make_timing(scenario.timing));
}

LiveRights::Thread thread_rights(const std::string& name, const RealTimeGrant& grant) {
  return {name, grant.priority, grant.fifo, grant.timer_slack_ns, grant.slice_ns, grant.refusal};
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
  for (const auto& [name, budget] : {std::pair{"latency", scenario.remap.latency}, {"lead", scenario.remap.lead}}) {
    if (!minimal(budget)) continue;
    return fmt::format(
        "[remap] {} is \"minimal\", as it is where nothing is written, and a wall clock does not know the timing before the "
        "run; give durations, for example --set remap.latency=\"25 ms\" --set remap.lead=\"3 ms\", or let the latency "
        "adapt",
        name);
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
  if (scenario.timing.elsewhere || traits_of(scenario.live).continues || scenario.live == StrategyKind::polyphase)
    return "a [source], and a live strategy that continues or filters its forces, run on the virtual clock only";
  if (std::find(scenario.strategies.begin(), scenario.strategies.end(), scenario.live) == scenario.strategies.end())
    return fmt::format(
        "[run] live = \"{0}\" is not one of the run's strategies; add \"{0}\" to 'strategies', or name one "
        "of those",
        name_of(scenario.live));
  if (traits_of(scenario.live).knows_motion) return "[run] live cannot be \"ideal\": it knows the future";
  return {};
}

LiveRecording run_live(const Scenario& scenario, const StrategyPlan& plan, const LiveDeviceOptions& options,
                       const RunControl& control, internal::LiveLog* log) {
  LiveRecording recording;
  const std::string name = name_of(plan.kind);
  // It may compile for a second, so this is done before t = 0 is chosen.
  auto solver = std::make_unique<WatchedSolver>(make_scenario_solver(scenario, plan.kind), scenario.scene.tool_count);
  const std::unique_ptr<RealVisualization> visualization = make_visualization(scenario, *solver);
  LiveRows rows(scenario, control.row_files, log);
  std::vector<DeviceInputs> added;  // by the lanes in the slice that runs
  std::optional<WakeLatency> awake;
  if (!options.cores_may_sleep) awake.emplace();
  const MemoryLock memory;
  const WallEpoch epoch = WallEpoch::in(kStartDelay);
  WallClock device_clock(epoch), simulation_clock(epoch);
  const std::unique_ptr<LiveDevices> devices = open_devices(scenario, device_clock, options);
  DeviceExchange exchange(live_links(scenario, plan, kSpare), devices->drivers(), &added);
  StrategyLanes lanes(scenario, plan, std::move(solver), exchange, make_wall_timing(scenario.timing), devices->drivers(),
                      control.row_files);
  WorkerExecutor worker(simulation_clock, kSolverPriority);
  InlineExecutor no_work;
  Scheduler simulation(simulation_clock, worker, {control.limits, control.permute_ties, true});
  Scheduler device(device_clock, no_work, {control.limits, control.permute_ties, true});
  rows.attach(lanes, added, device, simulation);
  lanes.spawn(device, simulation, visualization.get());

  const RealTime end{scenario.run_duration.ns};
  SlicedRun on_device;
  RunControl quiet = control;
  quiet.progress = nullptr;
  RealTimeGrant device_granted, simulation_granted;
  rows.start();
  std::optional<Viewing> viewing(std::in_place, control.view, lanes, epoch);
  LaneThread device_thread([&] {
    const RealTimeRights rights(kDevicePriority);
    device_granted = rights.grant();
    device_clock.wait_until(RealTime{} - kListenBefore);
    devices->forget_queued();
    on_device = run_in_slices(device, end, name, quiet, [&](RealTime until) { rows.device_slice(device, until); });
    if (ended_badly(on_device.status)) simulation.request_stop();
  });
  const SlicedRun in_simulation = [&] {
    const RealTimeRights rights(kSimulationPriority);
    simulation_granted = rights.grant();
    // The view shows how far the run is. This thread then writes to no terminal, because that may make it wait.
    return run_in_slices(simulation, end, name, control.view ? quiet : control,
                         [&](RealTime until) { rows.simulation_slice(simulation, until); });
  }();
  if (ended_badly(in_simulation.status)) device.request_stop();  // there will be no more forces
  device_thread.join();
  viewing.reset();
  devices->stop_simulated();
  throw_if_failed(on_device.status, name, lanes.steps());
  throw_if_failed(in_simulation.status, name);

  rows.finish(recording);
  recording.record = lanes.finish(in_simulation.reached);
  recording.record.interrupted = on_device.interrupted || in_simulation.interrupted;
  for (std::size_t tool = 0; tool < recording.record.devices.size(); ++tool)
    recording.record.devices[tool].counters.merge(devices->counters(tool));
  if (!recording.record.segments.empty()) recording.record.segments.back() = known_at(recording.record.segments.back(), end);
  if (visualization) {
    recording.visualization = visualization->text();
    recording.drawing_png = visualization->png();
  }
  recording.rights = {{thread_rights("device", device_granted), thread_rights("simulation", simulation_granted),
                       thread_rights("solver", worker.grant())},
                      memory.refusal().empty(),
                      memory.refusal()};
  if (awake) {
    recording.rights.cores_awake = awake->refusal().empty();
    recording.rights.cores_refusal = awake->refusal();
  }
  return recording;
}

namespace {

/// A lane of a replay: how far it may go, and whether its events are those that were recorded.
class ReplayedLane {
 public:
  /// `checks` empty: as far as the scenario lasts.
  ReplayedLane(Scheduler& scheduler, RealTime end, const Rows<LaneCheck>& checks, const char* name)
      : scheduler_(scheduler), end_(end), checks_(checks), name_(name) {
    compare();
  }
  std::optional<Scheduler::Key> next() const {
    if (!checks_.empty() && scheduler_.event_count() >= checks_.back().events) return std::nullopt;
    const auto key = scheduler_.next();
    return key && key->time < end_ ? key : std::nullopt;
  }
  bool run_one() {
    const bool ran = scheduler_.run_one();
    compare();
    return ran;
  }
  /// All events before it were compared.
  RealTime until() const { return until_; }
  const std::string& difference() const { return difference_; }

 private:
  void compare() {
    for (; next_ < checks_.size() && checks_[next_].events <= scheduler_.event_count(); ++next_) {
      if (difference_.empty() && checks_[next_].hash != scheduler_.trace_hash())
        difference_ =
            fmt::format("{} differs between {:.6g} s and {:.6g} s", name_, seconds(until_), seconds(checks_[next_].until));
      if (difference_.empty()) until_ = checks_[next_].until;
    }
  }

  Scheduler& scheduler_;
  RealTime end_, until_;
  const Rows<LaneCheck>& checks_;
  const char* name_;
  std::size_t next_ = 0;
  std::string difference_;
};

struct LanesReplay {
  StrategyRecord record;
  RealTime until;
  std::string difference;
};

/// The events of two schedulers in one order, taken from them again and again.
class TwoLogs {
 public:
  TwoLogs(StrategyLanes& lanes, Scheduler& simulation, Scheduler& device)
      : simulation_(simulation), device_(device), merge_([&lanes](const Event& event) { lanes.keep(event); }) {}
  void take() {
    simulation_.take_events(taken_);
    merge_.add_a(taken_, simulation_.now());
    device_.take_events(taken_);
    merge_.add_b(taken_, device_.now());
  }
  void finish() {
    take();
    merge_.finish();
  }

 private:
  Scheduler &simulation_, &device_;
  std::vector<Event> taken_;
  EventMerge merge_;
};

LanesReplay replay_lanes(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                         const Rows<LaneCheck>& device_checks, const Rows<LaneCheck>& simulation_checks,
                         const RunControl& control) {
  RecordedExchange exchange(live_links(scenario, plan, kSpare), recording.as_read(), true);
  auto [solver, watched] = make_watched_solver(scenario, plan.kind, control);
  StrategyLanes lanes(scenario, plan, std::move(solver), exchange, timing_of(scenario, recording), {}, control.row_files);
  VirtualClock device_clock, simulation_clock;
  InlineExecutor executor;
  Scheduler simulation(simulation_clock, executor, {control.limits, control.permute_ties, true});
  Scheduler device(device_clock, executor, {control.limits, control.permute_ties, true});
  lanes.spawn(device, simulation);

  // Each lane goes only as far as the other one had got during the recording, which the recorded heads tell.
  const RealTime end{scenario.run_duration.ns};
  ReplayedLane ticks(device, end, device_checks, "the device lane");
  ReplayedLane steps(simulation, end, simulation_checks, "the simulation lane");
  TwoLogs events(lanes, simulation, device);
  constexpr int kEventsBetween = 4096;
  for (int since = 0;; ++since) {
    if (since == kEventsBetween) events.take(), since = 0;
    const auto tick = ticks.next();
    const auto event = steps.next();
    const bool tick_ready = tick && exchange.next_tick_ready();
    const bool event_ready = event && (event->lane != Lane::launch || exchange.next_step_ready());
    if (!tick_ready && !event_ready) break;  // both at their end
    // A lane that was late in the live run is overtaken by the other one here, but never by more than the rings hold.
    const bool tick_first =
        tick_ready && (!event_ready || (tick->time <= event->time && !exchange.samples_ahead(kSpare / 2)));
    if (!(tick_first ? ticks : steps).run_one()) break;
  }
  throw_if_failed(device.status(), name_of(plan.kind));
  throw_if_failed(simulation.status(), name_of(plan.kind));
  const RealTime reached = simulation_checks.empty() ? end : simulation.now() + Duration{1};
  events.finish();
  StrategyRecord record = lanes.finish(reached);
  if (watched) record.tissue = picture_of(scenario, *watched);
  return {std::move(record), std::min(ticks.until(), steps.until()),
          ticks.difference().empty() ? steps.difference() : ticks.difference()};
}

bool same_bits(const glm::dvec3& a, const Vec3& b) {
  return std::bit_cast<Vec3>(a) == b && std::signbit(a.x) == std::signbit(b[0]) && std::signbit(a.y) == std::signbit(b[1]) &&
         std::signbit(a.z) == std::signbit(b[2]);
}

/// The first tick whose force differs from the one that was sent; empty if there is none.
std::string force_difference(const StrategyRecord& record, const InputLog& log) {
  for (std::size_t tool = 0; tool < record.devices.size(); ++tool) {
    const Rows<TickRow>& ticks = record.devices[tool].ticks;
    for (std::size_t k = 0; k < std::min(ticks.size(), log.ticks[tool].size()); ++k) {
      const glm::dvec3& sent = log.ticks[tool][k].force_N;
      const Vec3& again = ticks[k].force_N;
      if (same_bits(sent, again)) continue;
      return fmt::format("tick {} of {}, at {:.6f} s: ({}, {}, {}) N was sent, and the replay sends ({}, {}, {}) N", k,
                         record.devices[tool].name, seconds(ticks[k].at), sent.x, sent.y, sent.z, again[0], again[1],
                         again[2]);
    }
  }
  return {};
}

/// Where the replay first differs from the recording.
std::string difference_of(const LanesReplay& replayed, const InputLog& log) {
  if (std::string force = force_difference(replayed.record, log); !force.empty()) return force;
  if (!replayed.difference.empty()) return replayed.difference;
  if (!log.end) return {};
  if (replayed.until < log.until())
    return fmt::format("the replay ends at {:.6g} s, before the recording does", seconds(replayed.until));
  if (replayed.record.trace_hash != log.end->trace_hash)
    return fmt::format("trace {:016x} was recorded, and the replay has {:016x}", log.end->trace_hash,
                       replayed.record.trace_hash);
  return digest_of_forces(replayed.record) == log.end->forces_digest ? "" : "the forces differ";
}

}  // namespace

StrategyRecord replay(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                      const RunControl& control) {
  StrategyRecord record = replay_lanes(scenario, plan, recording, {}, {}, control).record;
  record.shadow = true;
  return record;
}

LogReplay replay(const Scenario& scenario, const StrategyPlan& plan, const InputLog& log, const RunControl& control) {
  LogReplay replayed;
  LiveRecording& recording = replayed.recording;
  recording.read = &log.inputs;
  recording.ran = &log.rows;
  recording.unfinished = log.unfinished;
  if (log.until() == RealTime{0})
    throw RunFailure("recording",
                     log.file + ": it ends before both lanes had a whole slice in it: there is nothing to replay",
                     "record for longer than 20 ms");
  LanesReplay lanes = replay_lanes(scenario, plan, recording, log.device_checks, log.simulation_checks, control);
  replayed.until = lanes.until;
  replayed.difference = difference_of(lanes, log);
  recording.record = std::move(lanes.record);
  recording.record.interrupted = !log.whole();
  // The recorded timing has the steps that began; only the last block says how many never did.
  recording.record.steps_due = log.end ? log.end->steps_due : std::nullopt;
  for (std::size_t tool = 0; tool < recording.record.devices.size(); ++tool) {
    DeviceRecord& device = recording.record.devices[tool];
    const Rows<LiveTick>& live = log.ticks[tool];
    for (std::size_t k = 0; k < std::min(device.ticks.size(), live.size()); ++k) device.ticks[k].lateness = live[k].lateness;
    if (log.end) device.counters = log.end->counters[tool];
  }
  return replayed;
}

StrategyRecord run_shadow(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                          const RunControl& control) {
  VirtualClock clock;
  RecordedExchange exchange(live_links(scenario, plan, kSpare), recording.as_read(), false);
  StrategyRecord record = run_lanes(scenario, plan, {clock, exchange, timing_of(scenario, recording), {}}, control);
  record.shadow = true;
  return record;
}

}  // namespace evenstep
