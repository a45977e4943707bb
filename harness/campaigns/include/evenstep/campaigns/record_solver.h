#pragma once
/// Records how long the steps of a scene's real solver take on this machine: `evenstep record`.
///
/// The schedule is that of a run on a wall clock with step = "real". A segment begins when [timing] says, or when the one
/// before it is done, whichever is later. Its visualization is a pause of the given length, in which nothing is drawn and
/// nothing runs, unless RecordControl has one that is really run. Its steps follow each other as fast as the solver can, or,
/// with the governor's steps = "spread", wait for their slots.
/// There is no hand and no device: the tools move as their [device] motions say, and no map runs. What only evenstep's own
/// checks need of a solver (state digest, energy) is left out.
///
/// On a wall clock the thread asks for the rights of a live run's solver (SCHED_FIFO, memory that stays, cores that do not
/// sleep), and gives them back: otherwise a recording has waits that the live run sized by it does not have.
///
/// A step's host time is from the call of the solver until its forces are known, on the clock that is passed in. Recorded
/// beside it are the times that the device itself reports for its commands, on a clock of its own.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/format/scenario.h"
#include "evenstep/loop/haptic_loop.h"
#include "evenstep/scheduler/step_timing.h"
#include "evenstep/sim/solver.h"

namespace evenstep {

inline constexpr std::size_t kMostRecordedSteps = 5'000'000;     ///< then the recording ends: about 200 MB of timing.csv
inline constexpr std::size_t kMostRecordedCommands = 4'000'000;  ///< further ones are only counted

/// Belongs to what asked for it: a step, or a visualization that reads the solver.
struct RecordedCommand {
  std::size_t segment = 0;          ///< of SolverRecording::segments
  std::optional<std::size_t> step;  ///< of its steps; none: its visualization
  DeviceCommand command;
};

struct SolverRecording {
  std::vector<SegmentTiming> segments;  ///< whole ones, unless there is only one
  std::vector<RecordedCommand> commands;
  std::int64_t commands_over_limit = 0;  ///< not in `commands`
  std::int64_t late_segments = 0;        ///< began more than 1 ms late, because steps before them took so long
  std::int64_t overslept_segments = 0;   ///< began more than 1 ms late, although there was time to wait for their begin
  Duration latest;                       ///< how late the latest one was
  bool interrupted = false;              ///< before its end
  bool full = false;                     ///< ended at kMostRecordedSteps
  std::optional<RealTimeGrant> rights;   ///< of the thread; empty: it asked for none
};

struct RecordControl {
  Duration length{20'000'000'000};  ///< what begins before this is over is recorded
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(double fraction)> progress = {};
  Visualization* visualization = nullptr;  ///< runs instead of the pauses; its real length is recorded
  bool ordinary = false;                   ///< asks for no real-time rights
};

/// Why a scenario's timing cannot be recorded, with the remedy; empty if it can.
std::string record_objection(const Scenario& scenario);
/// The solver as it is recorded, built and warmed up: no kernel is compiled later. Throws RunFailure.
std::unique_ptr<Solver> make_recorded_solver(const Scenario& scenario, bool log_commands);
/// `clock` begins at or before 0, where the first segment begins. Throws RunFailure if a step fails; then nothing is
/// recorded.
SolverRecording record_solver(const Scenario& scenario, Solver& solver, Clock& clock, const RecordControl& control);

/// Median, 99th percentile and largest of some lengths, ns.
struct Spread {
  std::int64_t p50 = 0, p99 = 0, max = 0;  ///< nearest rank; 0 if there are none
};
struct CommandSummary {
  std::string name;
  std::int64_t count = 0;
  std::int64_t waits_queued_ns = 0, waits_submitted_ns = 0, runs_ns = 0;  ///< medians of the times between its four instants
};
struct RecordSummary {
  std::int64_t segments = 0, visualizations = 0, steps = 0;
  Duration length;
  Spread host;           ///< per step
  Spread visualization;  ///< per visualization
  // Of the steps that gave commands to a device. Lengths alone are compared, so it does not matter where its clock begins.
  std::int64_t steps_on_device = 0;
  /// Of them, those whose span is longer than the host's step, and by how much at most. It lies in the step, so these are
  /// commands of something else, or clocks that do not agree.
  std::int64_t steps_beyond_host = 0, beyond_host_max_ns = 0;
  Spread span;     ///< from the first command queued to the last one ended
  Spread busy;     ///< time in which a command ran; where commands overlap it counts once
  Spread waiting;  ///< time of the span in which none ran
  Spread beyond;   ///< host time - span: before the first command and after the last one; below 0 where the clocks disagree
  std::vector<CommandSummary> commands;  ///< of the steps, in the order in which they first came
  Spread drawing_span, drawing_busy;     ///< the same of the visualizations that gave commands to the device
  std::vector<CommandSummary> drawing_commands;
  std::int64_t commands_without_times = 0;  ///< whose four times are missing or not in order: left out of all of the above
  /// By how much the device's clock is faster than the host's, in parts per million, from the first step to the last; 0 if
  /// that is less than a second.
  double faster_ppm = 0;
};
RecordSummary summarize(const SolverRecording& recording);

/// The machine on which something was recorded, for the head of the files. Empty or 0: not known.
struct RecordedMachine {
  std::string processor, system, host_clock;
  std::int64_t processors = 0;
  OpenClDescription device;  ///< empty for a solver without one
  double load_before = 0, load_after = 0;
  double warm_up_s = 0;
};
/// This machine's processor, system and clock, and its load now as load_before.
RecordedMachine machine_here();
double load_now();  ///< runnable processes, mean of the last minute

struct RecordHead {
  std::string command;  ///< what was typed
  std::string date;     ///< UTC, "2026-11-23T11:20:00Z"
  RecordedMachine machine;
  std::string visualization = {};  ///< what was really done in a visualization's time; empty: nothing
};
/// The lines before the header of timing.csv, each beginning with "# ".
std::string head_text(const RecordHead& head, const Scenario& scenario, const SolverInfo& info,
                      const SolverRecording& recording);
/// The commands, a row each: segment,kind,index,name,queued_ns,submitted_ns,started_ns,ended_ns. The first three name the
/// row of timing.csv that asked for it. Times count from when the first of the commands was queued.
std::string commands_csv(const SolverRecording& recording);
/// The table for the person who recorded.
std::string record_table(const RecordSummary& summary, const SolverRecording& recording);

}  // namespace evenstep
