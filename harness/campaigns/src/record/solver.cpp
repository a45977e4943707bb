#include "evenstep/campaigns/record_solver.h"

#include <algorithm>
#include <array>

#include "evenstep/harness/live_run.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/loop/segment_pace.h"
#include "evenstep/loop/solver_step.h"

namespace evenstep {
namespace {

constexpr Duration kSlice{20'000'000};  // of a wait: short enough that an interrupt seems immediate
constexpr Duration kLate{1'000'000};
constexpr std::size_t kMostPending = 10'000;  // commands whose events are kept until there is time to ask for their times

Scene recorded_scene(const Scenario& scenario) {
  Scene scene = scenario.scene;
  scene.needs_state_digest = scene.needs_energy = false;
  return scene;
}

class Recorder {
 public:
  Recorder(const Scenario& scenario, Solver& solver, Clock& clock, const RecordControl& control)
      : scenario_(scenario),
        control_(control),
        clock_(clock),
        log_(solver.command_log()),
        step_(solver, recorded_scene(scenario)) {}

  SolverRecording run() {
    if (log_) log_->take();  // the warm-up
    TimingSpec real = scenario_.timing;
    real.real_steps = true;
    const std::unique_ptr<StepTiming> timing = make_wall_timing(real);
    bool whole = true;
    for (SegmentTiming segment; whole && timing->next(segment);) {
      const RealTime turn = std::max(segment.begin, last_begin_ + Duration{1});
      waits_ = clock_.now() < turn;
      if (!wait_until(turn) || ended()) break;
      if (control_.progress) control_.progress(std::min(1.0, seconds(clock_.now()) / seconds(end())));
      whole = record(segment, *timing);
      take_commands();
    }
    if (!whole && recording_.segments.size() > 1) drop_last();
    recording_.interrupted = is_interrupted();
    return std::move(recording_);
  }

 private:
  RealTime end() const { return RealTime{control_.length.ns}; }
  bool ended() const { return clock_.now() >= end(); }
  bool is_interrupted() const { return control_.interrupted && control_.interrupted->load(); }

  /// False if it was interrupted.
  bool wait_until(RealTime at) {
    while (!is_interrupted()) {
      const RealTime now = clock_.now();
      if (now >= at) return true;
      clock_.wait_until(std::min(at, now + kSlice));
    }
    return false;
  }

  /// Whether it was recorded to its end.
  bool record(const SegmentTiming& programmed, StepTiming& timing) {
    SegmentTiming made;
    made.begin = last_begin_ = clock_.now();
    note_lateness(made.begin - programmed.begin);
    const Pause pause = pause_of(programmed, false);
    bool whole = !pause.before_steps || rest(pause.length, programmed, made, timing);
    for (std::size_t i = 0; whole && i < programmed.steps.size(); ++i) whole = turn(programmed.steps[i]) && run_step(made);
    if (whole && pause.after_steps) whole = rest(pause.length, programmed, made, timing);
    made.end = clock_.now();
    if (made.steps.empty() && !made.visualization) return whole;  // nothing to keep
    made.index = static_cast<std::int64_t>(recording_.segments.size());
    if (!recording_.segments.empty()) recording_.segments.back().end = made.begin;
    recording_.segments.push_back(std::move(made));
    return whole;
  }

  void note_lateness(Duration late) {
    if (late > kLate) ++(waits_ ? recording_.overslept_segments : recording_.late_segments);
    recording_.latest = std::max(recording_.latest, late);
  }

  bool rest(Duration length, const SegmentTiming& programmed, SegmentTiming& made, StepTiming& timing) {
    const RealTime began = clock_.now();
    if (control_.visualization) {
      control_.visualization->begins(length, programmed.drawing);
      control_.visualization->run();
      mark_commands(std::nullopt);
      timing.visualized(clock_.now() - began, control_.visualization->finished());
    } else if (!wait_until(began + length)) {
      return false;
    }
    made.visualization = Interval{began, clock_.now()};
    return true;
  }

  /// A step that is spread waits for its slot. False if it was interrupted.
  bool turn(const Interval& programmed) {
    const auto& governor = scenario_.timing.governor;
    return !governor || !governor->spread || wait_until(programmed.begin);
  }

  /// False if it was not run, because the recording ends here.
  bool run_step(SegmentTiming& made) {
    recording_.full = steps_ >= kMostRecordedSteps;
    if (recording_.full || is_interrupted() || ended()) return false;
    if (log_ && log_->size() > kMostPending) take_commands();
    const RealTime began = clock_.now();
    for (std::size_t tool = 0; tool < scenario_.devices.size(); ++tool)
      step_.give(static_cast<int>(tool), position_m(scenario_.devices[tool].motion, began), began);
    step_.begins(began);
    const RealTime called = clock_.now();
    step_.run();
    made.steps.push_back({called, clock_.now()});
    ++steps_;
    mark_commands(made.steps.size() - 1);
    return true;
  }

  /// All commands since the last mark belong to this step, or to the visualization.
  void mark_commands(std::optional<std::size_t> step) {
    if (log_) marks_.push_back({log_->size(), recording_.segments.size(), step});
  }

  /// Asks for the times of the commands since the last call, outside of steps, because that takes time itself.
  void take_commands() {
    if (!log_) return;
    const std::vector<DeviceCommand> taken = log_->take();
    std::size_t next = 0;
    for (const auto& [until, segment, step] : marks_) {
      for (; next < until; ++next) {
        if (recording_.commands.size() < kMostRecordedCommands)
          recording_.commands.push_back({segment, step, taken[next]});
        else
          ++recording_.commands_over_limit;
      }
    }
    marks_.clear();
  }

  void drop_last() {
    recording_.segments.pop_back();
    std::vector<RecordedCommand>& commands = recording_.commands;
    while (!commands.empty() && commands.back().segment >= recording_.segments.size()) commands.pop_back();
  }

  struct Mark {
    std::size_t commands;  // of the log
    std::size_t segment;
    std::optional<std::size_t> step;
  };

  const Scenario& scenario_;
  const RecordControl& control_;
  Clock& clock_;
  CommandLog* log_;
  SolverStep step_;
  SolverRecording recording_;
  std::vector<Mark> marks_;
  std::size_t steps_ = 0;
  RealTime last_begin_{-1};
  bool waits_ = false;  // for the begin of the segment
};

}  // namespace

std::string record_objection(const Scenario& scenario) {
  if (scenario.case_spec) return "a [case] has no steps in real time to record; give a scenario with [timing] and [scene]";
  const auto& trace = scenario.timing.trace;
  const auto beside = [](const SegmentTiming& segment) { return segment.overlaps(); };
  if (scenario.timing.programmed.order != SegmentOrder::concurrent && std::none_of(trace.begin(), trace.end(), beside))
    return {};
  return "its visualizations run beside the steps, and nothing that is done between them can stand for that; give one "
         "whose steps wait for them (order = \"visualization-first\" or \"steps-first\")";
}

std::unique_ptr<Solver> make_recorded_solver(const Scenario& scenario, bool log_commands) {
  SolverOptions options = scenario.solver_options;
  options.log_commands = log_commands;
  try {
    return make_solver(scenario.solver, recorded_scene(scenario), options);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

SolverRecording record_solver(const Scenario& scenario, Solver& solver, Clock& clock, const RecordControl& control) {
  Recorder recorder(scenario, solver, clock, control);
  if (clock.is_virtual() || control.ordinary) return recorder.run();
  const WakeLatency awake;
  const MemoryLock memory;
  const RealTimeRights rights(kSolverPriority);
  SolverRecording recording = recorder.run();
  recording.rights = rights.grant();
  return recording;
}

}  // namespace evenstep
