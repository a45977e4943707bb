#pragma once
/// A scenario, resolved: what a file says after `extends`, `--set` and defaults. Field table: scenarios/format/src/reader_fields.cpp.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/catalogue/case_spec.h"
#include "evenstep/device/force_guard.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/hid/pid_driver.h"
#include "evenstep/device/hid/simulated_pid_device.h"
#include "evenstep/device/motion.h"
#include "evenstep/device/renderer.h"
#include "evenstep/remap/adaptive_latency.h"
#include "evenstep/remap/filters.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/scheduler/step_timing.h"
#include "evenstep/sim/scene.h"
#include "evenstep/text/diagnostic.h"
#include "evenstep/text/quantity.h"

namespace evenstep {

enum class StrategyKind { ideal, direct, paper, phase_locked, predict, filtered, variable_step };

/// What tells strategies apart outside the map and the plan that each has of its own (harness/src/strategies.cpp).
struct StrategyTraits {
  StrategyKind kind;
  const char* name;                 ///< as in [run] strategies
  bool remaps = false;              ///< each step reads the hand at its slot, and the least lead and latency are computed
  bool knows_motion = false;        ///< the reference: even steps that read the programmed motion itself, not samples of it
  bool plays_as_it_comes = false;   ///< a force is played from the end of its step on, without a latency
  bool predicts = false;            ///< a step may read past the newest sample: that is its aim, and no underrun
  bool filters = false;             ///< it has the filter of [remap]
  bool varies_step = false;         ///< a step is as long as the real time since the step before
};
inline constexpr std::array kAllStrategies{
    StrategyTraits{.kind = StrategyKind::ideal, .name = "ideal", .knows_motion = true},
    StrategyTraits{.kind = StrategyKind::direct, .name = "direct", .plays_as_it_comes = true},
    StrategyTraits{.kind = StrategyKind::paper, .name = "paper", .remaps = true},
    StrategyTraits{.kind = StrategyKind::phase_locked, .name = "phase_locked", .remaps = true},
    StrategyTraits{.kind = StrategyKind::predict, .name = "predict", .predicts = true},
    StrategyTraits{.kind = StrategyKind::filtered, .name = "filtered", .plays_as_it_comes = true, .filters = true},
    StrategyTraits{.kind = StrategyKind::variable_step, .name = "variable_step", .plays_as_it_comes = true, .varies_step = true}};
const StrategyTraits& traits_of(StrategyKind kind);
inline const char* name_of(StrategyKind kind) { return traits_of(kind).name; }
inline bool is_remap(StrategyKind kind) { return traits_of(kind).remaps; }

/// A tissue with one mode, as the tool feels it: a mass between two equal springs.
struct TissueMode {
  std::optional<double> frequency_Hz;           ///< of the mass, the tool held still
  std::optional<double> damping_ratio;
  std::optional<double> static_N_per_m;         ///< at rest; each spring has twice that
};

/// [[device]] render: how a tick's force is made of its scheduled record (device/renderer.h). What its kind has no use for
/// keeps the value here.
struct RenderSpec {
  /// device_spring: local, as springs of the device, as far as it can.
  enum class Kind { force, local, device_spring, smith } kind = Kind::force;
  bool is_local() const { return kind == Kind::local || kind == Kind::device_spring; }
  // Of these two:
  std::optional<double> alpha = 1.0;            ///< none: automatic
  LocalModel stiffness = LocalModel::none;      ///< which one the solver gives
  bool knows_gap = true;                        ///< false is a control
  /// No contact is played stiffer than that. by_law: what the law allows the hand (stiffness_laws.h).
  struct Cap { enum class Kind { none, by_law, fixed } kind = Kind::none; double fixed_N_per_m = 0; } cap;
  TissueMode mode;                              ///< smith; what is not given is the scene's
  double factor = 1.1;                          ///< smith: both springs of the model are so many times as stiff
};

/// The model of a device that renders `smith`; none where neither the device nor the scene gives one of its numbers.
std::optional<SpringMode> smith_mode(const Scene& scene, const RenderSpec& render);

/// [[device]] force_limit, slew_limit and guard: what is written there.
struct GuardSpec {
  std::optional<double> max_N, max_slew_N_per_s;
  std::optional<double> gain;
  std::optional<Duration> ramp_up, ramp_down;
  std::optional<double> max_speed_m_per_s;
  std::optional<Duration> stale_force, stale_hand;
};
/// What is not written is taken from `otherwise`.
ForceLimits force_limits(const GuardSpec& spec, const ForceLimits& otherwise);
/// `otherwise` with a real device: what a hand can hold against, a quarter of each force, risen over a second, cut off in 50 ms.
inline constexpr ForceLimits kLiveLimits{
    3, 1000,
    {0.25, Duration{1'000'000'000}, Duration{50'000'000}, 1.0, Duration{100'000'000}, Duration{50'000'000}}};

/// [[device]] driver = "pid", and its simulated device.
struct PidSpec {
  PidOptions options;
  PidFlavour flavour = PidFlavour::mask;
  int pool_effects = 40;
  int block_load_error_at = -1;                 ///< counted from 0
  Rate firmware_rate{4000, 1};                  ///< of springs that it renders by itself
  std::vector<PidDeviceEvent> events;
};

struct DeviceSpec {
  std::string name;
  Rate rate{1000, 1};
  Duration phase;
  QueuePolicy queue = QueuePolicy::hidraw;
  ProgrammedMotion motion;                      ///< of a hand: its intended path
  std::optional<HandSpec> hand;                 ///< feels the force; none: the motion is programmed
  Duration force_delay;                         ///< from writing a force to when the hand feels it
  Emission emission = Emission::linear;
  RenderSpec render;
  bool is_real = false;                         ///< run with --device: nobody knows where it was
  std::optional<PidSpec> pid;                   ///< none: the reference device
  std::optional<Duration> unplug;               ///< of the simulated device
  std::vector<ReportFault> faults;
  GuardSpec guard;
  ForceLimits limits;                           ///< of `guard`
};

/// A latency or lead: minimal for any phase, minimal for this phase, or a duration. A latency may adapt instead.
struct Budget { enum class Kind { any_phase, this_phase, fixed, adaptive } kind = Kind::any_phase; Duration fixed; };

/// What a step does whose sample is not there yet, and a tick whose force is not.
enum class InteractionUnderrun { clamp, gate, extrapolate };
enum class ForceUnderrun { hold, extrapolate };
const char* name_of(InteractionUnderrun policy);
const char* name_of(ForceUnderrun policy);

struct RemapSpec {
  double estimate_weight = 0.1;
  double bandwidth_Hz = 2.0;
  Budget latency;
  AdaptiveLatencyOptions adapt;                 ///< of a latency that adapts; the devices say its emission
  Budget lead;
  InteractionUnderrun interaction_underrun = InteractionUnderrun::clamp;
  ForceUnderrun force_underrun = ForceUnderrun::hold;
  Duration predict_window;                      ///< `predict` takes the hand's velocity from so much of the past
  FilterSpec filter;                            ///< of strategy `filtered`; filter_at has the samples of an average
  Duration filter_window;                       ///< of a moving average
  bool filter_force = true;                     ///< on the force at the ticks; false: on the interaction at the steps
};

/// The filter of `filtered` for a signal that comes at `rate`.
FilterSpec filter_at(const RemapSpec& remap, Rate rate);

struct TimingSpec {
  ProgrammedTiming programmed;
  bool real_steps = false;                      ///< step = "real": no programmed floor on a wall clock
  std::vector<SegmentTiming> trace;             ///< non-empty: replay this and nothing else
  std::string trace_file;
};

/// A step of a study: the scene's step cut into `substeps`, or `steps` of them at once; one of the two is 1.
struct StudyStep { int substeps = 1; int steps = 1; };
/// Stiffnesses between which a study looks for the largest stable one.
struct StiffnessSearch {
  double from_N_per_m = 0, to_N_per_m = 0;
  int seeds = 1;
  bool scales_mass = false;                     ///< of a tissue: its masses in proportion, so that its frequencies stay
};
struct StudySpec {
  Duration duration;                            ///< simulated, from the begin of the first motion
  std::vector<Method> methods;
  std::vector<SolverKind> solvers;
  std::vector<StudyStep> steps;                 ///< coarsest first; empty: halvings around each method's limit
  std::vector<int> iterations;                  ///< of methods that iterate; empty: each method's own
  int repeats = 5;
  std::optional<StiffnessSearch> stiffness_limit;   ///< then the study is this search, and nothing of the above counts
};

struct Expectation {
  Place place;
  std::string signal, metric, because;
  std::optional<Limit> min, max;
  std::optional<std::array<double, 2>> at;      ///< of a case: only the cells whose values lie between these
  bool expect_fail = false;
  /// Of an underrun_rate: the limit must hold for the true rate with this confidence, and the maps alone are run over so many
  /// seeds to know; 0: as many as suffice if all are clean.
  std::optional<double> confidence;
  std::int64_t seeds = 0;
};

/// A key of a sweep's grid and what it is set to.
struct SweepAxis {
  std::string path;                             ///< as --set takes it: "timing.visualization"
  std::vector<std::string> values;              ///< as TOML: "\"5 ms\"", "15"; all different
  Place place;
};
/// The least (greatest) value of an axis from which on everything passes.
struct SweepFind {
  std::size_t axis = 0;                         ///< of the grid; its values rise strictly
  bool smallest = true;
  std::string gate;                             ///< at_most or at_least as written; empty: any value will do
  std::size_t allowed = 0;                      ///< so many of its values meet it: the first ones of `smallest`, else the last
};
/// [sweep]: the runs that `evenstep sweep` makes of a scenario.
struct SweepSpec {
  std::vector<std::uint64_t> seeds;             ///< at least one, all different
  std::vector<SweepAxis> grid;                  ///< the first varies slowest
  std::optional<std::int64_t> stop_after;
  int keep_worst = 5;
  std::optional<SweepFind> find;
};
inline constexpr std::int64_t kMostSweepPoints = 10'000'000;  // some 5 GB of lines

struct Scenario {
  std::string file;
  std::string name, because;
  std::vector<std::string> tags;

  Duration run_duration;                        ///< default with a trace: its length
  Duration warmup;
  std::optional<Duration> interrupt;            ///< a signal comes then: before run_duration
  std::uint64_t seed = 1;
  std::vector<StrategyKind> strategies;
  StrategyKind live = StrategyKind::phase_locked;
  bool keep_rows = true;                        ///< false: the run folder has bins and metrics only
  bool needs_undelayed = false;                 ///< an expectation asks what the scene would have answered without delay

  std::optional<CaseSpec> case_spec;            ///< then there is no timing, scene, device or remap
  TimingSpec timing;
  SolverKind solver = SolverKind::opencl;
  Scene scene;
  int work_group_size = 64;
  std::vector<DeviceSpec> devices;
  RemapSpec remap;
  StudySpec study;
  std::optional<SweepSpec> sweep;
  std::vector<Expectation> expectations;
  struct ExpectStop {
    std::string reason, message;                ///< message: a part of what the run says
    std::optional<std::int64_t> at_least_step, at_most_step;
    Place place;
  };
  std::optional<ExpectStop> expect_stop;

  NominalUnits nominal;
  std::string resolved_toml;                    ///< the merged table, for resolved.toml
};

/// A device is a hand that feels the force: what was felt decides where it goes.
bool has_hand(const Scenario& scenario);

struct ReadOptions { std::vector<std::string> set; std::optional<std::uint64_t> seed; };
struct ReadResult {
  std::optional<Scenario> scenario;             ///< none if there are errors
  std::vector<Diagnostic> errors;               ///< all of them, by position
};
ReadResult read_scenario(const std::string& path, const ReadOptions& options = {});
/// JSON Schema (draft-04) generated from the field table.
std::string scenario_schema();

}  // namespace evenstep
