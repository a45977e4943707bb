#pragma once
/// The data of a finished run in plain columns: the harness fills them in, measures and writers read them. Vectors are
/// std::array<double, 3> (x, y, z).

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/reports/rows.h"
#include "evenstep/time/time.h"

namespace evenstep {

using Vec3 = std::array<double, 3>;

/// gated: the step waited for its sample and then read it inside. predicted: the read lies beyond the newest sample by
/// design. Neither counts as an underrun.
enum class StepRead : std::uint8_t { inside, underrun, overrun, newest, acquiring, gated, predicted };

/// One step of one strategy.
struct StepRow {
  std::int64_t segment = 0;
  RealTime begin;       ///< S_n
  RealTime end;         ///< E_n
  RealTime read;        ///< R(n)
  RealTime emission;    ///< F(n)
  RealTime line_from;   ///< with linear emission the line to this force begins here: StepEmission::line_from
  bool mapped = false;  ///< false: it read the newest sample (`direct`) or the map was acquiring
  bool acquiring = false;
  bool lost = false;                  ///< with a source: its force never came to the device
  Duration transport;                 ///< with a source: how long after E_n its force was at the device
  SimTime simulated;                  ///< simulation time of the step; used only if StrategyRecord::variable_step
  std::optional<SimTime> clock = {};  ///< t(n) of a loop that keeps its own time: SegmentTiming::simulated
};

/// One device's part of a step (same index as StepRow).
struct StepSample {
  Vec3 position_m{};  ///< x_n, passed to the solver
  Vec3 force_N{};     ///< f_n
  StepRead read = StepRead::inside;
  std::optional<Vec3> true_position_m;  ///< the programmed motion at R(n), if the motion is known
};

/// What made a sample differ from what the hand and the scene made: reports/saturation.h.
enum class SaturationCause : std::uint8_t { clamp, slew, cut, non_finite, device_force, device_position };
inline constexpr std::array kAllSaturationCauses{SaturationCause::clamp,        SaturationCause::slew,
                                                 SaturationCause::cut,          SaturationCause::non_finite,
                                                 SaturationCause::device_force, SaturationCause::device_position};
/// A set of them.
struct SaturationCauses {
  std::uint8_t bits = 0;
  void add(SaturationCause cause, bool met = true) {
    bits = static_cast<std::uint8_t>(bits | (met ? 1U << static_cast<unsigned>(cause) : 0U));
  }
  bool has(SaturationCause cause) const { return (bits >> static_cast<unsigned>(cause) & 1U) != 0; }
  bool none() const { return bits == 0; }
};

/// One device tick.
struct TickRow {
  RealTime at;           ///< scheduled
  Duration lateness;     ///< 0 in virtual time
  Vec3 position_m{};     ///< the sample that was read
  Vec3 force_N{};        ///< the whole force after the guard: what was sent, plus what the device renders by itself
  bool started = false;  ///< false before the first emission time: no force yet
  std::optional<Vec3> undelayed_N = {};  ///< the scene's force for these positions without any delay, if it was computed
  /// Of the force, and whether the position is at an end of the device's range.
  SaturationCauses saturated = {};
};

/// Springs that the device rendered by itself from a tick on, in addition to the force that was sent: along each axis
/// k (center - x), at most limit_N, where k = below for x < center and k = above for x > center.
struct SpringRow {
  Vec3 center_m{}, below_N_per_m{}, above_N_per_m{}, limit_N{};
};

/// The loop over a device in the terms of the stability laws (docs/forces/stiffness.md). Values that have no meaning for
/// this loop are empty.
struct LoopRecord {
  double delay_s = 0;                            ///< L_e + d of the scheduled force
  std::optional<double> stiffness_N_per_m = {};  ///< what the hand feels at rest, if the scene has a value for it
  /// b_eq / K of every spring, without the part of springs that the device renders by itself; that part adds
  /// min(alpha K, own_N_per_m) * own_gain_s to b_eq.
  std::optional<double> damping_per_stiffness_s = {};
  double own_N_per_m = 0, own_gain_s = 0;
  std::optional<double> stiffness_limit_N_per_m = {};  ///< K_max, for a hand that feels the force
  std::optional<double> alpha = {}, alpha_star = {};   ///< for a local model
  std::optional<double> cap_N_per_m = {};              ///< for a local model; infinite: no cap
  /// For a strategy without a latency, which plays forces as they come: the mean age, over the programmed timing, of the
  /// sample that the played force answers. Empty where that is no sample's age: behind a filter or a prediction.
  std::optional<double> played_age_s = {};
};

/// What became of a device's ticks, samples and forces over the whole run, counted where it happened. balance.h says which
/// of these numbers must add up, and to what.
struct DeviceFlow {
  std::int64_t ticks_skipped = 0;     ///< by the lane, before a tick that ran, because the tick before that was late
  std::int64_t ticks_unforced = 0;    ///< ticks before the first force was due
  std::int64_t ticks_underrun = 0;    ///< linear emission: past the newest force that was there
  std::int64_t ticks_overrun = 0;     ///< the force of this tick had left the ring
  std::int64_t ticks_on_time = 0;     ///< all others
  std::int64_t samples = 0;           ///< put in the ring of samples
  std::int64_t samples_repeated = 0;  ///< not put there: not a new position, and of a time that is in the ring already
  std::int64_t forces = 0;            ///< put in the ring of forces; each is in one of the next four counts
  std::int64_t forces_sent = 0;       ///< at some tick the newest that was due
  std::int64_t forces_overtaken = 0;  ///< at the first tick at which it was due, a newer one was due as well
  std::int64_t forces_dropped = 0;    ///< left the ring before a tick at which it was due
  std::int64_t forces_pending = 0;    ///< due after the last tick
};

struct DeviceRecord {
  std::string name;
  bool interpolates = false;  ///< ticks play the line between two forces; otherwise the latest force that is due
  Duration ahead;             ///< a force is needed this much earlier, because what plays it looks ahead (`polyphase`)
  LoopRecord loop;
  std::optional<DeviceFlow> flow = {};                                          ///< empty in a record that no lane has made
  std::int64_t predicted_interaction_underruns = 0, predicted_late_forces = 0;  ///< by the sizing pass
  std::optional<double> stored_J;  ///< energy stored in the scene when judging begins, if the scene knows it
  Rows<StepSample> steps;
  Rows<TickRow> ticks;
  Rows<SpringRow> springs;                 ///< one per tick if the device renders springs by itself; otherwise empty
  std::map<std::string, double> counters;  ///< those of driver and guard: "lost", "clamped", ...
};

struct LatencyRecord {
  Duration lead;
  Duration latency;  ///< for an adaptive latency the most that it may become
  /// The least leads, and the least latencies for the lead of this run, its map and its emission (hold or linear).
  Duration least_any_phase_lead, least_any_phase;
  Duration least_this_phase_lead, least_this_phase;
  std::int64_t lead_culprit = -1, latency_culprit = -1;
  std::int64_t interaction_capacity = 0, force_capacity = 0;
  std::int64_t least_entries = 0;  ///< per chunk, so that none runs dry; 0: it plays no chunks
  bool adapts = false;
  std::string trusted;  ///< the latency for an hour, or why it cannot be known; empty if nobody asked (TrustedLatency)
};

struct SegmentRow {
  std::int64_t index = 0;
  RealTime begin, end;
  std::optional<std::array<RealTime, 2>> visualization;
  bool finishes = true;   ///< the drawing is complete when the visualization ends: false for a part before the last
  bool left_out = false;  ///< a drawing should have begun here, and a frame governor made none

  friend bool operator==(const SegmentRow&, const SegmentRow&) = default;
};

/// A read beyond the newest sample, a wait for a sample, or a late force; one row per step and device.
struct UnderrunRow {
  enum class Side : std::uint8_t { interaction, force };
  std::int64_t step = 0;
  std::uint32_t device = 0;  ///< index into StrategyRecord::devices
  Side side = Side::interaction;
  /// Interaction: R(n) - newest visible sample (t = 0 if there was none), or with a gate the time waited.
  /// Force: by how much it missed its deadline, F(n), or with linear emission the begin of the line to it.
  Duration lateness;
  std::string_view policy;  ///< "clamp", "gate", "extrapolate" or "hold"
};

struct EventRow {
  RealTime time;
  std::uint8_t lane = 0;   ///< 0 completion, 1 device, 2 launch
  std::uint16_t name = 0;  ///< index into StrategyRecord::event_names
  std::uint64_t chained_hash = 0;
};

/// When the force of a step is at the device.
inline RealTime arrival(const StepRow& step) { return step.end + step.transport; }
/// When the force of a step must be there, so that no tick of the device misses it.
inline RealTime deadline(const StepRow& step, const DeviceRecord& device) {
  return (device.interpolates ? step.line_from : step.emission) - device.ahead;
}
inline bool is_late(const StepRow& step, const DeviceRecord& device) {
  return step.mapped && !step.lost && arrival(step) > deadline(step, device);
}

struct SolverRecord {
  std::string name;
  std::string device;
  std::int64_t particles = 0;
  int substeps = 1;
  std::string method = "none";  ///< "symplectic-euler"; "none" for the spring, which has no motion to integrate
  int iterations = 0;           ///< per substep, for methods that iterate
  double step_limit_s = 0, rest_state_step_limit_s = 0;  ///< of a substep; 0: none
  double stiffness_limit_N_per_m = 0;  ///< largest stable [scene] stiffness for this step, others in proportion; 0: none
  std::int64_t limit_particle = -1;    ///< lattice site that sets the limits; -1: none
  bool non_finite = false;
  std::int64_t first_bad_step = -1;
  double energy_growth = 0;
  bool has_energy = false;
  std::vector<std::string> left_out;  ///< features that the scene does not need and the solver leaves out
  std::vector<std::string> lacks;     ///< capabilities that a solver of the program does not have: "energy"
  double solver_seconds = 0;          ///< launch + wait; reported, never hashed
  bool memoryless = true;             ///< its forces depend on the tool alone, so the step size changes none
  bool variable_step = false;         ///< the strategy chose the length of the steps; only then the next two are used
  std::int64_t steps_over_limit = 0;  ///< steps longer than substeps * step limit
  double step_over_limit_max = 0;     ///< largest (step / substeps) / step limit
};

/// How a strategy's line is drawn in every figure that shows several strategies.
struct LineLook {
  std::string colour;  ///< "#d55e00"; empty: one that no other line has
  double width = 2;
  std::string dash;  ///< of SVG: "14 6"; empty: a solid line
};

/// What a tissue looked like at one instant of a run; both empty: it is not known.
struct TissuePicture {
  std::string svg, caption;
};

struct StrategyRecord {
  std::string name;  ///< "phase_locked"
  LineLook look;
  bool reference = false;  ///< it knows the motion: what the others are compared with, drawn below them
  Rows<StepRow> steps;
  Rows<SegmentRow> segments;
  std::vector<DeviceRecord> devices;
  LatencyRecord latency;
  SolverRecord solver;
  /// Steps whose programmed begin lies in the run; empty: its recording does not say.
  std::optional<std::int64_t> steps_due = 0;
  std::int64_t steps_begun = 0;  ///< fewer than were due where the simulation fell behind
  std::int64_t emission_repairs = 0;
  std::int64_t latency_growths = 0;  ///< for an adaptive latency; over the whole run
  std::vector<std::string> event_names;
  Rows<EventRow> events;                             ///< empty if RunRecord::keep_rows is false
  Rows<UnderrunRow> underruns;                       ///< by step, over the whole run
  std::map<std::string, std::int64_t> event_counts;  ///< "<lane>.<name>" -> count
  std::uint64_t trace_hash = 0;
  /// Force of the ideal twin with this lead, per step and device (step-major); may be empty.
  Rows<Vec3> twin_force_N;
  /// How long before a read the hand's positions still matter, and how long before a tick the forces of the schedule: the
  /// window of an extrapolation or the settling of a filter.
  Duration interaction_memory, force_memory;
  bool continues = false;      ///< a tick plays what a line, an average or a chunk makes of the forces: no step's
  bool variable_step = false;  ///< simulation time is StepRow::simulated instead of n * slot
  bool interrupted = false;    ///< ended before its end, by a signal
  TissuePicture tissue;        ///< of one strategy of a run
  bool shadow = false;         ///< replayed from a live run: its forces never reached the hand
};

/// Records without rows; rows to come will be in `files`, or in memory if that is null.
StrategyRecord empty_record(const std::shared_ptr<RowFiles>& files);
DeviceRecord empty_device_record(const std::shared_ptr<RowFiles>& files);

/// A fault that a scenario programs: what is wrong, from when, and when it is over.
struct ProgrammedFault {
  enum class Over : std::uint8_t {
    at_time,        ///< at `to`
    with_segment,   ///< when the first segment at or after `to` begins
    after_segment,  ///< when that segment ends
    never           ///< it lasts until the end of the run
  };
  std::string name;  ///< where it is written: "timing.changes", "device.left.faults.2"
  RealTime from, to;
  Over over = Over::at_time;
};

/// Nominal figures of the scenario, for units and windows.
struct Nominal {
  Duration segment, visualization, step_run_time;
  double slot_s = 0;     ///< step_size: simulated seconds per step
  RealTime judged_from;  ///< end of warm-up
  RealTime end;          ///< duration
  /// x = A (1 - cos(2 pi f (t - begin))) / 2 from `begin` on, plus the position where it starts. A is its peak-to-peak
  /// travel.
  struct Sine {
    Vec3 amplitude_m{};       ///< A
    double frequency_Hz = 0;  ///< f
    double begin_s = 0;
  };
  /// A motion that is straight at its nominal speed in [first + j (straight + turn), + straight] for j = 0, 1, ..., and
  /// turns in between. Straightness is judged on the straight pieces alone.
  struct Turns {
    RealTime first;
    Duration straight, turn;
  };
  struct Device {
    std::string name;
    std::optional<double> speed_m_per_s;
    std::optional<double> stiffness_N_per_m;  ///< only a spring has one
    Rate rate;
    RealTime first_tick;
    std::optional<RealTime> stop_at;
    std::optional<Sine> sine = std::nullopt;    ///< only a sine motion has one
    std::optional<Turns> turns = std::nullopt;  ///< only a motion back and forth has them
    bool feels_force = false;                   ///< it is held by a hand whose motion is not known beforehand
    Duration force_delay = {};                  ///< from the tick that sends a force to when it is felt
  };
  std::vector<Device> devices;
  std::vector<ProgrammedFault> faults;  ///< those that begin before `end`
  /// What still counts as recovered (recovery.h): how much more latency than before, and by what share of the mean change
  /// from one sample to the next a jump may be larger.
  Duration recovery_latency{1'000'000};
  double recovery_jump = 0.1;
};

/// When a run was made, and from which state of the user's repository. The run itself knows neither: whoever starts it says.
struct RunOrigin {
  std::string date;    ///< "2026-11-23T11:05:13Z"; empty: not said
  std::string commit;  ///< 40 or 64 hex digits; empty: not known
};

/// What the operating system granted the threads of a live run, and the process.
struct LiveRights {
  struct Thread {
    std::string name;  ///< "device", "simulation", "solver"
    int priority = 0;  ///< the SCHED_FIFO priority asked for
    bool fifo = false;
    std::int64_t timer_slack_ns = 0;
    std::int64_t slice_ns = 0;  ///< the time slice granted instead of SCHED_FIFO; 0: the system's own
    std::string refusal;        ///< empty: nothing was refused
  };
  std::vector<Thread> threads;
  bool memory_locked = false;
  std::string memory_refusal;
  /// Whether cores were kept from sleeping deeply (/dev/cpu_dma_latency); empty: nobody asked for it.
  std::optional<bool> cores_awake = {};
  std::string cores_refusal = {};  ///< why not

  /// Every thread has SCHED_FIFO.
  bool fifo() const {
    for (const Thread& thread : threads)
      if (!thread.fifo) return false;
    return true;
  }
};

struct RunRecord {
  std::string scenario;  ///< its name
  std::string file;
  std::optional<std::uint64_t> digest = {};  ///< of everything in the scenario that the run depends on; empty: not read
  RunOrigin origin = {};
  std::uint64_t seed = 1;
  std::string clock;                      ///< "virtual" | "wall"
  std::string live;                       ///< the strategy that ran on the wall clock; empty if none did
  bool real_time_granted = true;          ///< every thread of a live run had SCHED_FIFO, or none was needed
  std::optional<LiveRights> rights = {};  ///< of a live run
  std::string recording_lacks = {};       ///< what the recording of --record lacks, and why; empty: nothing, or no recording
  Nominal nominal;
  std::vector<StrategyRecord> strategies;
  std::uint64_t trace_hash = 0;  ///< hash over the pairs (strategy name, chained hash)
  std::vector<std::string> left_out;
  std::string visualization = {};  ///< what was really done in the time of visualizations; empty: nothing
  std::string drawing_png = {};    ///< what was drawn last on a wall clock; empty: nothing was
  bool keep_rows = true;           ///< false (long runs): no events, and series.csv holds the bins only
};

}  // namespace evenstep
