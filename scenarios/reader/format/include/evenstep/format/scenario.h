#pragma once
/// A scenario, resolved: what a file says once `extends`, `--set` and defaults are applied. Field table:
/// scenarios/reader/format/src/reader_fields.cpp.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/catalogue/case_spec.h"
#include "evenstep/device/force_guard.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/motion.h"
#include "evenstep/device/renderer.h"
#include "evenstep/format/driver_spec.h"
#include "evenstep/format/foreign.h"
#include "evenstep/format/registry.h"
#include "evenstep/format/render_spec.h"
#include "evenstep/remap/adaptive_latency.h"
#include "evenstep/remap/chunk_player.h"
#include "evenstep/remap/filters.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/paper_map.h"
#include "evenstep/remap/resampler.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/frame_governor.h"
#include "evenstep/scheduler/source_timing.h"
#include "evenstep/scheduler/step_timing.h"
#include "evenstep/sim/scene.h"
#include "evenstep/sim/solver.h"
#include "evenstep/text/diagnostic.h"
#include "evenstep/text/quantity.h"
#include "evenstep/time/result.h"

namespace evenstep {

enum class StrategyKind {
  ideal,
  direct,
  paper,
  phase_locked,
  predict,
  filtered,
  variable_step,
  foreign,
  jack_dll,
  lsl_dejitter,
  linear,
  absolute_grid,
  holt_winters,
  polyphase,
  chunk_replace,
  chunk_append,
  chunk_blend,
  clocked,
  interpolated
};

/// The properties in which strategies differ, apart from their maps and plans (harness/src/plan/strategies.cpp).
struct StrategyTraits {
  StrategyKind kind;
  const char* name;                ///< as in [run] strategies
  bool remaps = false;             ///< each step reads the hand at its slot, and the least lead and latency are computed
  bool knows_motion = false;       ///< the reference: even steps that read the programmed motion itself, not samples of it
  bool plays_as_it_comes = false;  ///< a force is played from the end of its step on, without a latency
  bool predicts = false;           ///< a step may read past the newest sample by design, which is no underrun
  bool filters = false;            ///< it uses the filter of [remap]
  bool varies_step = false;        ///< a step is as long as the real time since the step before
  bool for_comparison = false;     ///< somebody else's map: `size` shows it only if it is asked for
  bool continues = false;          ///< a tick plays what a line, an average or a chunk makes of the forces so far
};
inline constexpr std::array kAllStrategies{
    StrategyTraits{.kind = StrategyKind::ideal, .name = "ideal", .knows_motion = true},
    StrategyTraits{.kind = StrategyKind::direct, .name = "direct", .plays_as_it_comes = true},
    StrategyTraits{.kind = StrategyKind::paper, .name = "paper", .remaps = true},
    StrategyTraits{.kind = StrategyKind::phase_locked, .name = "phase_locked", .remaps = true},
    StrategyTraits{.kind = StrategyKind::predict, .name = "predict", .predicts = true},
    StrategyTraits{.kind = StrategyKind::filtered, .name = "filtered", .plays_as_it_comes = true, .filters = true},
    StrategyTraits{
        .kind = StrategyKind::variable_step, .name = "variable_step", .plays_as_it_comes = true, .varies_step = true},
    StrategyTraits{.kind = StrategyKind::foreign, .name = "foreign", .remaps = true},
    StrategyTraits{.kind = StrategyKind::jack_dll, .name = "jack_dll", .remaps = true, .for_comparison = true},
    StrategyTraits{.kind = StrategyKind::lsl_dejitter, .name = "lsl_dejitter", .remaps = true, .for_comparison = true},
    StrategyTraits{.kind = StrategyKind::linear, .name = "linear", .remaps = true, .for_comparison = true},
    StrategyTraits{.kind = StrategyKind::absolute_grid, .name = "absolute_grid", .remaps = true, .for_comparison = true},
    StrategyTraits{.kind = StrategyKind::holt_winters, .name = "holt_winters", .plays_as_it_comes = true, .continues = true},
    StrategyTraits{.kind = StrategyKind::polyphase, .name = "polyphase", .remaps = true, .for_comparison = true},
    StrategyTraits{
        .kind = StrategyKind::chunk_replace, .name = "chunk_replace", .plays_as_it_comes = true, .continues = true},
    StrategyTraits{.kind = StrategyKind::chunk_append, .name = "chunk_append", .plays_as_it_comes = true, .continues = true},
    StrategyTraits{.kind = StrategyKind::chunk_blend, .name = "chunk_blend", .plays_as_it_comes = true, .continues = true},
    StrategyTraits{.kind = StrategyKind::clocked, .name = "clocked", .remaps = true},
    StrategyTraits{
        .kind = StrategyKind::interpolated, .name = "interpolated", .plays_as_it_comes = true, .continues = true}};
const StrategyTraits& traits_of(StrategyKind kind);
/// nullptr: there is no such strategy.
const StrategyTraits* strategy_named(std::string_view name);
inline const char* name_of(StrategyKind kind) { return traits_of(kind).name; }
inline bool is_remap(StrategyKind kind) { return traits_of(kind).remaps; }

/// [[device]] force_limit, slew_limit and guard: only the values that are written in the file.
struct GuardSpec {
  std::optional<double> max_N, max_slew_N_per_s;
  std::optional<double> gain;
  std::optional<Duration> ramp_up, ramp_down;
  std::optional<double> max_speed_m_per_s;
  std::optional<Duration> stale_force, stale_hand;
};
/// The limits for a device; values that are not written in the file are taken from `otherwise`.
ForceLimits force_limits(const GuardSpec& spec, const ForceLimits& otherwise);
/// The defaults for a real device: a force that a hand can resist, a gain of a quarter, ramped up within a second and down
/// within 50 ms.
inline constexpr ForceLimits kLiveLimits{
    3, 1000, {0.25, Duration{1'000'000'000}, Duration{50'000'000}, 1.0, Duration{100'000'000}, Duration{50'000'000}}};

/// How old the reports of a device are when they come, and which time a sample has as a result.
struct ReportAge {
  Duration least;              ///< of every report when it comes
  Duration jitter;             ///< a report is older than `least` by up to this, uniformly distributed
  std::int64_t clock_ppm = 0;  ///< the device's clock, and so its ticks, run faster by this
  std::uint64_t seed = 1;
  /// What the scenario says in `sample_time`: whether a sample's time is when it was taken instead of when it was read.
  std::optional<bool> follows_clock;
  /// Whether anything is said about ages.
  bool is_given() const { return least.ns > 0 || jitter.ns > 0 || clock_ppm != 0; }
};

struct DeviceSpec {
  std::string name;
  Rate rate{1000, 1};
  Duration phase;
  QueuePolicy queue = QueuePolicy::hidraw;
  ProgrammedMotion motion;       ///< with a hand: its intended path
  std::optional<HandSpec> hand;  ///< the hand that feels the force; empty: the motion is programmed
  Duration force_delay;          ///< from the writing of a force until the hand feels it
  Emission emission = Emission::linear;
  RenderSpec render;
  bool is_real = false;  ///< run with --device, so its true motion is not known
  DriverSpec driver;
  Place driver_place;               ///< where the driver is named, or could be
  std::optional<Duration> unplug;   ///< when the simulated device is unplugged
  std::optional<Duration> returns;  ///< when it is plugged in again, after that
  std::vector<ReportFault> faults;
  ReportAge age;
  bool expects_saturation = false;  ///< shape metrics of saturated signals are judged all the same
  GuardSpec guard;
  ForceLimits limits;  ///< the limits that follow from `guard`
};

/// Whether a driver's reports can say when they were taken.
bool says_when_taken(const DriverSpec& driver);
/// Whether the time of a device's samples is when they were taken, by the device's own clock; otherwise it is when they were
/// read. If the scenario does not say, this is true for a real device and where ages are given, provided that the driver can
/// tell.
bool follows_clock(const DeviceSpec& device);
/// For a driver that is told of changes only, and whose samples say when they were taken: the age that a position has if it
/// has not changed. Empty for all others.
std::optional<Duration> unchanged_age_of(const DeviceSpec& device);
/// The largest age that a device's samples can have at the tick that reads them, by their own time; 0 if that time is when
/// they were read (a tick that finds no new report then gives the last position again). The least age is included, as far as
/// the driver knows it; the wait for the tick varies only if the clocks differ.
Duration largest_age(const DeviceSpec& device);

/// A latency or lead: the minimum for any phase, the minimum for this phase, or a fixed duration. A latency can also be
/// adaptive.
struct Budget {
  enum class Kind { any_phase, this_phase, fixed, adaptive } kind = Kind::any_phase;
  Duration fixed;
};

/// What a step does if its sample is not there yet, and what a tick does if its force is not.
enum class InteractionUnderrun { clamp, gate, extrapolate };
enum class ForceUnderrun { hold, extrapolate };
const char* name_of(InteractionUnderrun policy);
const char* name_of(ForceUnderrun policy);

/// The map of strategy `foreign`.
struct ForeignMapSpec : Foreign {
  MapFactory make;
};

/// The entries of a device's rings, in the way that a program of one's own has them.
struct RingSizes {
  std::size_t samples = 0, forces = 0;
};
inline constexpr std::size_t kLeastRing = 3, kMostRing = 1 << 20;

struct RemapSpec {
  double estimate_weight = 0.1;
  StepCount estimate_steps = StepCount::average;
  double bandwidth_Hz = 2.0;
  double jump = 0.07;  ///< of `phase_locked`
  Budget latency;
  AdaptiveLatencyOptions adapt;  ///< for an adaptive latency; its emission follows from the devices
  Budget lead;
  std::optional<RingSizes> rings;  ///< of the strategies that map; empty: as large as the timing needs
  InteractionUnderrun interaction_underrun = InteractionUnderrun::clamp;
  ForceUnderrun force_underrun = ForceUnderrun::hold;
  Duration predict_window;  ///< how far back `predict` looks to find the hand's velocity
  FilterSpec filter;        ///< for strategy `filtered`; filter_at adds the samples of an average
  Duration filter_window;   ///< for a moving average
  /// By how much a step of `clocked` may move the slots where the loop dropped time, in step sizes; empty: by all of it.
  std::optional<double> dropped_jump = 0.07;
  bool filter_force = true;  ///< filters the force at the ticks; false: the interaction at the steps
  std::optional<ForeignMapSpec> foreign;
};

/// The filter of `filtered` for a signal that comes at `rate`.
FilterSpec filter_at(const RemapSpec& remap, Rate rate);

/// What is done during a visualization on a wall clock. On the virtual clock a visualization is only a length of time.
enum class VisualizationWork {
  pause,   ///< nothing: the steps wait
  render,  ///< the tissue is drawn, for as long as drawing it takes
  burn     ///< a kernel keeps the compute device busy for about the length
};

struct TimingSpec {
  ProgrammedTiming programmed;
  std::optional<SourceSpec> elsewhere;  ///< [source]: the forces are made elsewhere; same seed as `programmed`
  bool real_steps = false;              ///< step = "real": no programmed floor on a wall clock
  VisualizationWork work = VisualizationWork::pause;
  Place work_place;                         ///< where `work` is written
  std::array<int, 2> picture_px{800, 600};  ///< width and height of what `render` draws
  std::optional<FrameGovernor> governor;    ///< shortens the pauses, of `programmed` as well as of `trace`
  std::vector<SegmentTiming> trace;         ///< if not empty, this is replayed and `programmed` is not used
  std::string trace_file;
  std::string trace_damage;       ///< AssignedRoles::damage() of a profiler's file: to be said by whoever judges with it
  std::optional<Foreign> source;  ///< the program's own timing source, which gave `trace`
};

/// A step of a study: the scene's step divided into `substeps`, or `steps` of the scene's steps at once; one of the two is
/// 1.
struct StudyStep {
  int substeps = 1;
  int steps = 1;
};
/// The range in which a study searches for the largest stable stiffness.
struct StiffnessSearch {
  double from_N_per_m = 0, to_N_per_m = 0;
  int seeds = 1;
  bool scales_mass = false;  ///< scales a tissue's masses too, so that its frequencies stay the same
};
/// The error that a study measures.
enum class StudyError {
  felt_force,  ///< of the force that the hand feels, over the judged time: evenstep/campaigns/felt_study.h
  state        ///< of positions, forces and energy of a tissue on an even schedule: evenstep/campaigns/study.h
};
struct StudySpec {
  StudyError error = StudyError::felt_force;
  /// Simulated time. For the felt force: from the end of the warm-up on, at most the whole time that the run judges. For the
  /// state: from the beginning of the first motion on.
  Duration duration;
  std::vector<Method> methods;
  std::vector<SolverKind> solvers;
  std::vector<StudyStep> steps;  ///< coarsest first; empty: the study chooses for each method
  std::vector<int> iterations;   ///< for methods that iterate; empty: each method's default
  int repeats = 5;
  std::optional<StiffnessSearch> stiffness_limit;  ///< if given, the study is this search and ignores the members above
};

struct Expectation {
  Place place;
  struct {
    Place signal, metric, min, max;
  } written;  ///< where its parts are written; `equals` sets both min and max
  std::string signal, metric, because;
  std::optional<Limit> min, max;
  std::optional<std::array<double, 2>> at;  ///< for a case: judge only the cells whose values lie between these
  bool expect_fail = false;
  std::string clock;  ///< judged only on this clock, "virtual" or "wall"; empty: on both
  /// For an underrun_rate: the limit must hold for the true rate with this confidence. To find out, the maps alone are run
  /// over `seeds` seeds; 0: as many as are enough if no segment has an underrun.
  std::optional<double> confidence;
  std::int64_t seeds = 0;
};

/// [[sometimes]]: a state that at least one point of a sweep must reach. In the condition, `because` and all other members
/// that only an expectation has are empty.
struct Sometimes {
  std::string name;
  Expectation condition;
};

/// A key of a sweep's grid and the values it is set to.
struct SweepAxis {
  std::string path;                 ///< as --set takes it: "timing.visualization"
  std::vector<std::string> values;  ///< as TOML: "\"5 ms\"", "15"; all different
  Place place;
};
/// Searches for the least (greatest) value of an axis from which on everything passes.
struct SweepFind {
  std::size_t axis = 0;  ///< position in the grid; its values rise strictly
  bool smallest = true;
  std::string gate;  ///< at_most or at_least as written; empty: any value is accepted
  /// How many values of the axis satisfy `gate`: these are the first ones if `smallest`, otherwise the last ones.
  std::size_t allowed = 0;
};
/// [sweep]: the runs of a scenario that `evenstep sweep` makes.
struct SweepSpec {
  std::vector<std::uint64_t> seeds;  ///< at least one, all different
  std::vector<SweepAxis> grid;       ///< the first varies slowest
  std::optional<std::int64_t> stop_after;
  int keep_worst = 5;
  std::optional<SweepFind> find;
  bool swarm = false;  ///< each seed switches off a random part of the faults
  Place swarm_place;
};
inline constexpr std::int64_t kMostSweepPoints = 10'000'000;  // some 5 GB of lines

/// [source]: how forces that come from elsewhere are played by the strategies that know more than one force at a time.
struct PlayingSpec {
  ResamplerSpec resampler;
  ChunkSpec chunk;
};

struct Scenario {
  std::string file;
  std::string name, because;
  std::vector<std::string> tags;

  Duration run_duration;  ///< with a trace, its length is the default
  Duration warmup;
  std::optional<Duration> interrupt;  ///< when the run is interrupted as by a signal; before run_duration
  std::uint64_t seed = 1;
  std::vector<StrategyKind> strategies;
  StrategyKind live = StrategyKind::phase_locked;
  bool keep_rows = true;         ///< false: the run folder has bins and metrics only
  bool needs_undelayed = false;  ///< an expectation needs the force that the scene would give without delay

  std::optional<CaseSpec> case_spec;  ///< if given, there is no timing, scene, device or remap
  TimingSpec timing;
  SolverKind solver = SolverKind::opencl;
  Place solver_place;  ///< where it is named, or could be
  Scene scene;
  Place scene_place;  ///< where its kind is named, or could be; of a foreign scene its name
  SolverOptions solver_options;
  std::vector<DeviceSpec> devices;
  RemapSpec remap;
  PlayingSpec playing;
  StudySpec study;
  std::optional<SweepSpec> sweep;
  std::vector<Expectation> expectations;
  std::vector<Sometimes> sometimes;
  std::vector<ProgrammedFault> faults;   ///< those that [run] faults_off leaves on
  bool has_faults_off = false;           ///< [run] faults_off names some
  Duration recovery_latency{1'000'000};  ///< what counts as recovered: evenstep/reports/recovery.h
  double recovery_jump = 0.1;
  struct ExpectStop {
    std::string reason, message;  ///< message: a part of the run's error message
    std::optional<std::int64_t> at_least_step, at_most_step;
    Place place;
  };
  std::optional<ExpectStop> expect_stop;

  NominalUnits nominal;
  std::string resolved_toml;      ///< the merged table, for resolved.toml
  std::vector<Diagnostic> notes;  ///< of what is allowed, but may not be meant: lists that another file replaced
};

/// The expectations and the conditions of [[sometimes]]: everything that asks for a figure of the run.
std::vector<const Expectation*> conditions_of(const Scenario& scenario);

/// Whether a device is held by a hand that feels the force, so that the force decides where it moves.
bool has_hand(const Scenario& scenario);

struct ReadOptions {
  std::vector<std::string> set;
  std::optional<std::uint64_t> seed;
  Registry registry = {};  ///< the parts that the program brings along; a scenario that names any other is an error
  bool real_time = false;  ///< it will run on a wall clock, so how long a drawing takes need not be known
};
/// The scenario, or all its errors, by position.
using ReadResult = Result<Scenario, std::vector<Diagnostic>>;
ReadResult read_scenario(const std::string& path, const ReadOptions& options = {});
/// JSON Schema (draft-04) generated from the field table, with the names of the registered parts.
std::string scenario_schema(const Registry& registry = {});

}  // namespace evenstep
