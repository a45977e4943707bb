// The field table. One row per key; a key that means different things for different kinds has a row for each.
#include "fields.h"

#include "evenstep/sim/scene.h"

namespace evenstep::internal {
namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr Range at_least(double least) { return {least, kAny, false}; }
constexpr Range above(double least, double most = kAny) { return {least, most, true}; }
constexpr Range between(double least, double most) { return {least, most, false}; }

// Limits, with what they come from:
constexpr double kLongestRun_s = 1e6;             // what int64 ns and every sum of a few of them hold with room to spare
constexpr double kMostSteps = 1e6;                // per segment: 30 million steps per second, far beyond any device
constexpr double kMostParticles = 1e8;            // 18 springs each: 1.8e9, the last that fits int32 indices

constexpr double kMostIterations = kMaxIterations, kMostSubsteps = kMaxSubsteps;  // what a solver takes
constexpr double kLongestSpike_s = 9;             // the longest segment

using D = Dimension;
constexpr std::string_view kStrategies = "ideal|direct|paper|phase_locked|predict|filtered|variable_step";
constexpr std::string_view kMethods =
    "symplectic-euler|velocity-verlet|rk4|implicit-euler|implicit-midpoint|vertex-block-descent";
constexpr std::string_view kMotions = "still|constant-velocity|sine|ramp-stop|stick-slip|recorded|minimum-jerk|hand";
constexpr std::string_view kPaths = "still|constant-velocity|sine|ramp-stop|stick-slip|recorded|minimum-jerk";
constexpr std::string_view kAnyOrder = "visualization-first|steps-first|concurrent";
constexpr std::string_view kInTurn = "visualization-first|steps-first";

// clang-format off: a row reads as a row
const std::vector<Field> kTop{
    {.table = "", .key = "format", .forms = kInteger, .meaning = "Version of this format: 1. Obligatory in every file.",
     .required = true,
     .range = between(1, 1), .example = "1"},
    {.table = "", .key = "name", .forms = kText, .default_toml = "\"\"", .meaning = "What the scenario is, in one line."},
    {.table = "", .key = "because", .forms = kText, .default_toml = "\"\"", .meaning = "Why it exists."},
    {.table = "", .key = "tags", .forms = kText, .shape = Shape::list, .default_toml = "[]",
     .meaning = "For picking scenarios.",
     .example = "[\"paper\", \"ci\"]"},
    {.table = "", .key = "extends", .forms = kFile, .shape = Shape::list, .default_toml = "[]",
     .meaning = "Files to start from; later ones win, this file over all. Tables merge, lists replace. At most 16 deep.",
     .example = "[\"base.toml\"]"},
    {.table = "", .key = "case", .forms = kTable,
     .meaning = "An entry of the catalogue of stiff and extreme cases, which drives the solver itself. It goes with `[[expect]]` "
                "and, in `[run]`, with `seed`; with nothing of what follows."},
    {.table = "", .key = "run", .forms = kTable, .meaning = "How long, how often, with which strategies."},
    {.table = "", .key = "timing", .forms = kTable, .meaning = "What the GPU costs.", .kinds = "loop", .required = true},
    {.table = "", .key = "scene", .forms = kTable,
     .meaning = "What is simulated. Only what is named here exists in the run.", .kinds = "loop", .required = true},
    {.table = "", .key = "device", .forms = kTable, .shape = Shape::list, .meaning = "The hands: one or two.",
     .kinds = "loop", .required = true},
    {.table = "", .key = "remap", .forms = kTable, .meaning = "The map between real time and simulation time.",
     .kinds = "loop"},
    {.table = "", .key = "study", .forms = kTable,
     .meaning = "What `evenstep study` compares or looks for. A run leaves it aside.", .kinds = "loop"},
    {.table = "", .key = "sweep", .forms = kTable,
     .meaning = "What `evenstep sweep` runs: seeds times a grid of values (docs/sweep.md). A run leaves it aside.",
     .kinds = "loop"},
    {.table = "", .key = "expect", .forms = kTable, .shape = Shape::list,
     .meaning = "What must hold; each entry is judged on its own."},
    {.table = "", .key = "expect_append", .forms = kTable, .shape = Shape::list,
     .meaning = "Expectations added to those of the files named in `extends`."},
    {.table = "", .key = "expect_stop", .forms = kTable,
     .meaning = "The run must stop early, for this reason; anything else fails.", .kinds = "loop"},
};

const std::vector<Field> kCase{
    {.table = "case", .key = "kind", .forms = kWord,
     .meaning = "Which case: what is set up, what the values are and what the exact answer is (docs/stability.md).",
     .words = "oscillator|stiffness|chain-order|edge|damping|moving-target|mass-ratio|stiff-in-soft|wall|free-fall|"
              "hanging-chain|standing-block|wave|energy|press|degenerate|crushed|numbering", .required = true, .example = "\"oscillator\""},
    {.table = "case", .key = "methods", .forms = kWord, .shape = Shape::list,
     .default_toml = "[\"symplectic-euler\", \"velocity-verlet\", \"rk4\", \"implicit-euler\", \"implicit-midpoint\", "
                     "\"vertex-block-descent\"]",
     .meaning = "One row of cells for each, with each solver.", .words = kMethods},
    {.table = "case", .key = "solvers", .forms = kWord, .shape = Shape::list, .default_toml = "[\"cpu-double\", \"cpu\"]",
     .meaning = "What computes it.", .words = "opencl|cpu|cpu-double"},
    {.table = "case", .key = "values", .forms = kNumber | kTable, .shape = Shape::one_or_list,
     .meaning = "One cell for each, strictly rising. A table is `count` of them, evenly spaced in their logarithms.",
     .required = true, .range = above(0), .example = "[1, 10, 100]"},
    {.table = "case", .key = "periods", .forms = kNumber, .default_toml = "1000", .meaning = "To run, of the oscillator.",
     .kinds = "oscillator", .range = above(0, 1e9)},
    {.table = "case", .key = "most_steps", .forms = kInteger, .default_toml = "20000", .meaning = "Steps to run; of an oscillator only "
     "if its periods take more.", .kinds = "oscillator|edge|wall|wave|energy|crushed", .range = between(1, 1e12)},
    {.table = "case", .key = "duration", .forms = kDuration, .default_toml = "\"10 s\"", .meaning = "Simulation time to run.",
     .kinds = "stiffness|chain-order|damping", .range = above(0, 1e4)},
    {.table = "case", .key = "step_size", .forms = kDuration, .default_toml = "\"1 ms\"", .meaning = "Simulation time per step.",
     .kinds = "free-fall", .range = above(0, 1)},
    {.table = "case", .key = "particles", .forms = kInteger, .default_toml = "64",
     .meaning = "Of a chain, those that move; of a block, along each edge.", .kinds = "chain-order|edge|hanging-chain|standing-block|wave",
     .range = between(2, 1000)},
    {.table = "case", .key = "iterations", .forms = kInteger,
     .meaning = "Of the methods that iterate. Default: the method's own.", .range = between(1, kMaxIterations), .example = "10"},
    {.table = "case", .key = "allow_unstable", .forms = kBoolean, .default_toml = "false",
     .meaning = "Lets an unstable step size start.", .kinds = "oscillator|wall"},
    {.table = "case.values", .key = "from", .forms = kNumber, .meaning = "The first one.", .required = true, .range = above(0),
     .example = "1e-4"},
    {.table = "case.values", .key = "to", .forms = kNumber, .meaning = "The last one.", .required = true, .range = above(0),
     .example = "1"},
    {.table = "case.values", .key = "count", .forms = kInteger, .meaning = "How many.", .required = true,
     .range = between(2, 1000), .example = "5"},
};

const std::vector<Field> kRun{
    {.table = "run", .key = "duration", .forms = kSpan,
     .meaning = "Real time to run. Obligatory, except with a trace: then all of it.",
     .range = above(0, kLongestRun_s), .example = "\"4 s\""},
    {.table = "run", .key = "warmup", .forms = kSpan, .default_toml = "\"0 s\"",
     .meaning = "Real time at the start that is not judged.",
     .range = between(0, kLongestRun_s), .example = "\"8 segments\""},
    {.table = "run", .key = "seed", .forms = kInteger, .default_toml = "1", .meaning = "Of everything drawn at random.",
     .range = at_least(0)},
    {.table = "run", .key = "strategies", .forms = kWord, .shape = Shape::list,
     .default_toml = "[\"ideal\", \"direct\", \"paper\", \"phase_locked\"]",
     .meaning = "Run side by side over the same timing, each with a solver of its own.", .words = kStrategies},
    {.table = "run", .key = "live", .forms = kWord, .default_toml = "\"phase_locked\"",
     .meaning = "The one that has the device on a wall clock. (`ideal` knows the motion beforehand; no hand grants that.)",
     .words = "direct|paper|phase_locked"},
    {.table = "run", .key = "keep", .forms = kWord, .default_toml = "\"all\"",
     .meaning = "`summary`: series.csv has the 1 s bins only and there is no events.bin: for runs of many minutes.",
     .words = "all|summary"},
};

const std::vector<Field> kTiming{
    {.table = "timing", .key = "segment", .forms = kRate | kDuration,
     .meaning = "Rate or length T of the time segment (one visualization and its steps). Obligatory unless `step` is a "
                "duration: then segments follow each other without a gap. 10 us to 9 s.",
     .kinds = kAnyOrder, .range = above(0), .example = "\"30 Hz\""},
    {.table = "timing", .key = "visualization", .forms = kDuration,
     .meaning = "Run time V of the visualization, the mean where it varies.",
     .kinds = kAnyOrder, .required = true, .range = between(0, kLongestRun_s), .example = "\"11.1 ms\""},
    {.table = "timing", .key = "steps", .forms = kInteger, .shape = Shape::one_or_list,
     .meaning = "Steps N per segment; of several values one is drawn per segment.", .kinds = kInTurn,
     .required = true, .range = between(1, kMostSteps), .example = "15"},
    {.table = "timing", .key = "steps", .forms = kInteger,
     .meaning = "Mean steps per segment, which gives the `step`. Write one of the two.", .kinds = "concurrent",
     .range = between(1, kMostSteps), .example = "15"},
    {.table = "timing", .key = "step", .forms = kWord | kDuration, .default_toml = "\"fill\"",
     .meaning = "Run time s of a step, the mean where it varies. `fill`: (T - V) / N. `real`: on a wall clock what the "
                "solver really takes; `fill` under the virtual clock.",
     .words = "fill|real", .kinds = kInTurn, .range = above(0, kLongestRun_s)},
    {.table = "timing", .key = "step", .forms = kWord | kDuration, .default_toml = "\"fill\"",
     .meaning = "Run time s of a step, the mean where it varies. `fill`: as `steps` asks for.",
     .words = "fill", .kinds = "concurrent", .range = above(0, kLongestRun_s)},
    {.table = "timing", .key = "order", .forms = kWord, .default_toml = "\"visualization-first\"",
     .meaning = "What opens a segment. `steps-first` needs a lead of V. `concurrent`: the visualization has a lane of its own "
                "and stops no step; a segment lasts from one visualization's begin to the next's.",
     .words = kAnyOrder, .kinds = kAnyOrder},
    {.table = "timing", .key = "paced", .forms = kBoolean, .default_toml = "false",
     .meaning = "Where anything varies: segments still wait for the grid of `segment`, and idle until then. (`concurrent`: "
                "visualizations do.)",
     .kinds = kAnyOrder},
    {.table = "timing", .key = "jitter", .forms = kTable,
     .meaning = "Random run times. Without `paced` segments then follow each other without a gap; so with all that follows.",
     .kinds = kAnyOrder},
    {.table = "timing", .key = "first_step", .forms = kQuantity, .default_toml = "\"0 %\"",
     .meaning = "The first step after a visualization takes so much longer.", .kinds = kInTurn, .dimension = D::ratio,
     .range = between(0, 100), .example = "\"+20 %\""},
    {.table = "timing", .key = "slowdown", .forms = kNumber, .default_toml = "1",
     .meaning = "A step that begins beside a visualization takes so many times as long.", .kinds = "concurrent",
     .range = between(1, 100), .example = "1.5"},
    {.table = "timing", .key = "spikes", .forms = kTable,
     .meaning = "Steps are hit now and then, for the same time each (a scheduler's tick).", .kinds = kAnyOrder},
    {.table = "timing", .key = "preemption", .forms = kTable,
     .meaning = "Steps and visualizations are interrupted now and then, for times with a long tail.", .kinds = kAnyOrder},
    {.table = "timing", .key = "regimes", .forms = kTable,
     .meaning = "The visualization jumps between two lengths, each of which lasts a while. The mean stays V.",
     .kinds = kAnyOrder},
    {.table = "timing", .key = "drift", .forms = kQuantity, .default_toml = "\"0 %/s\"",
     .meaning = "V and s of a segment are those of t = 0 times 1 + drift * its begin.", .kinds = kAnyOrder,
     .dimension = D::drift, .range = between(-10, 10), .example = "\"10 %/s\""},
    {.table = "timing", .key = "dropped_visualization", .forms = kQuantity, .default_toml = "\"0 %\"",
     .meaning = "Share of the segments without one: their steps follow at once.", .kinds = kAnyOrder,
     .dimension = D::ratio, .range = between(0, 1), .example = "\"2 %\""},
    {.table = "timing", .key = "merged_visualization", .forms = kQuantity, .default_toml = "\"0 %\"",
     .meaning = "Share of the segments with two in a row, 2 V.", .kinds = kAnyOrder,
     .dimension = D::ratio, .range = between(0, 1), .example = "\"2 %\""},
    {.table = "timing", .key = "changes", .forms = kTable, .shape = Shape::list,
     .meaning = "New values, each from the first segment on that begins at its time or later. `fill` keeps its step.",
     .kinds = kAnyOrder, .example = "[{ at = \"2 s\", visualization = \"22.2 ms\" }]"},
    {.table = "timing", .key = "trace", .forms = kFile,
     .meaning = "A recording to replay (segment,kind,index,begin_ns,end_ns); then [timing] holds nothing else.",
     .example = "\"recorded/x.csv\""},
    {.table = "timing.jitter", .key = "visualization", .forms = kLognormal,
     .meaning = "Log-normal with this coefficient of variation; the mean stays V.", .range = between(0, 1),
     .example = "\"lognormal 10 %\""},
    {.table = "timing.jitter", .key = "step", .forms = kLognormal, .meaning = "The same for each step; the mean stays s.",
     .range = between(0, 1),
     .example = "\"lognormal 10 %\""},
    {.table = "timing.spikes", .key = "rate", .forms = kRate,
     .meaning = "Per second of step; a step of length d is hit with probability 1 - exp(-rate d), at most once.",
     .required = true, .range = above(0, 1e6), .example = "\"2 Hz\""},
    {.table = "timing.spikes", .key = "cost", .forms = kDuration, .meaning = "What a hit adds.", .required = true,
     .range = above(0, kLongestSpike_s), .example = "\"4 ms\""},
    {.table = "timing.preemption", .key = "rate", .forms = kRate,
     .meaning = "Per second of work; as for spikes, but visualizations are hit too.", .required = true,
     .range = above(0, 1e6), .example = "\"2 Hz\""},
    {.table = "timing.preemption", .key = "cost", .forms = kPareto,
     .meaning = "What a hit adds: Pareto distributed between these two.", .required = true,
     .range = above(0, kLongestSpike_s), .example = "\"pareto 3 ms cap 40 ms\""},
    {.table = "timing.preemption", .key = "tail", .forms = kNumber, .default_toml = "1.5",
     .meaning = "Tail index: P(cost > x) falls as x^-tail.", .range = between(0.1, 10)},
    {.table = "timing.regimes", .key = "factor", .forms = kNumber, .meaning = "Of the longer to the shorter visualization.",
     .required = true, .range = between(1, 100), .example = "1.6"},
    {.table = "timing.regimes", .key = "mean_length", .forms = kSegments,
     .meaning = "How long one lasts on average (geometrically distributed); 2: a fair draw for each segment.",
     .required = true, .range = between(1, 1e6), .example = "\"8 segments\""},
    {.table = "timing.changes", .key = "at", .forms = kDuration, .meaning = "Increasing from entry to entry.",
     .required = true, .range = between(0, kLongestRun_s), .example = "\"2 s\""},
    {.table = "timing.changes", .key = "visualization", .forms = kDuration, .meaning = "V from then on.",
     .range = between(0, kLongestRun_s), .example = "\"22.2 ms\""},
    {.table = "timing.changes", .key = "step", .forms = kDuration, .meaning = "s from then on.",
     .range = above(0, kLongestRun_s), .example = "\"1.5 ms\""},
    {.table = "timing.changes", .key = "steps", .forms = kInteger, .shape = Shape::one_or_list,
     .meaning = "N from then on. Not with `concurrent`: there `step` decides.", .range = between(1, kMostSteps),
     .example = "15"},
};

const std::vector<Field> kScene{
    {.table = "scene", .key = "kind", .forms = kWord,
     .meaning = "`spring`: F = -k x, memoryless. `wall`: pushes out what is behind its surface. `mode`: a mass between two "
                "springs, which rings. `tissue`: particles on a lattice, each joined to its 18 neighbours by springs.",
     .words = "spring|wall|mode|tissue", .required = true, .example = "\"spring\""},
    {.table = "scene", .key = "solver", .forms = kWord, .default_toml = "\"cpu-double\"", .meaning = "What computes it.",
     .words = "opencl|cpu|cpu-double", .kinds = "spring"},
    {.table = "scene", .key = "solver", .forms = kWord, .default_toml = "\"opencl\"",
     .meaning = "What computes it; `cpu` (float) and `opencl` agree bit for bit.", .words = "opencl|cpu|cpu-double",
     .kinds = "tissue"},
    {.table = "scene", .key = "stiffness", .forms = kQuantity, .default_toml = "\"200 N/m\"",
     .meaning = "k; of a `mode` at rest, twice that at once.", .kinds = "spring|wall|mode", .dimension = D::stiffness,
     .range = at_least(0)},
    {.table = "scene", .key = "stiffness", .forms = kQuantity, .default_toml = "\"50 N/m\"",
     .meaning = "k of each spring.", .kinds = "tissue",
     .dimension = D::stiffness, .range = above(0)},
    {.table = "scene", .key = "normal", .forms = kNumber, .shape = Shape::three, .default_toml = "[1, 0, 0]",
     .meaning = "Out of the surface, towards the tool; of any length.", .kinds = "wall|mode"},
    {.table = "scene", .key = "surface", .forms = kQuantity, .default_toml = "\"0 mm\"",
     .meaning = "Where the surface is along the normal, counted from the origin.", .kinds = "wall|mode", .dimension = D::length},
    {.table = "scene", .key = "hardening", .forms = kQuantity,
     .meaning = "F = k (p + p^2 / hardening) at the depth p. Default: F = k p.", .kinds = "wall", .dimension = D::length,
     .range = above(0), .example = "\"5 mm\""},
    {.table = "scene", .key = "frequency", .forms = kRate, .meaning = "Of the mass between its springs, the tool held still.",
     .kinds = "mode", .required = true, .range = between(0.01, 1000), .example = "\"30 Hz\""},
    {.table = "scene", .key = "damping_ratio", .forms = kNumber, .default_toml = "0.1", .meaning = "Of that mass.", .kinds = "mode",
     .range = between(0, 10)},
    {.table = "scene", .key = "one_sided", .forms = kBoolean, .default_toml = "false",
     .meaning = "It pushes along its normal and never pulls. Otherwise it pushes and pulls along every axis, from the origin.",
     .kinds = "mode"},
    {.table = "scene", .key = "step_size", .forms = kWord | kDuration | kRate, .default_toml = "\"fill\"",
     .meaning = "Simulation time per step, or steps per simulated second. `fill`: segment / mean N, so that simulated "
                "time keeps pace with real time (a trace: its length / its steps).",
     .words = "fill", .range = above(0)},
    {.table = "scene", .key = "lattice", .forms = kInteger, .shape = Shape::three, .default_toml = "[27, 27, 28]",
     .meaning = "Particles along x, y, z.",
     .kinds = "tissue", .range = between(1, 10'000)},
    {.table = "scene", .key = "particles", .forms = kInteger,
     .meaning = "Cut the lattice to so many by leaving out the last sites of its top layer. Default: all.",
     .kinds = "tissue",
     .range = between(1, kMostParticles), .example = "20270"},
    {.table = "scene", .key = "spacing", .forms = kQuantity, .default_toml = "\"5 mm\"", .meaning = "Between neighbours.",
     .kinds = "tissue",
     .dimension = D::length, .range = above(0, 1)},
    {.table = "scene", .key = "mass", .forms = kQuantity, .default_toml = "\"0.125 g\"", .meaning = "Of one particle.",
     .kinds = "tissue",
     .dimension = D::mass, .range = above(0)},
    {.table = "scene", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
     .meaning = "Drag on one particle: a force of damping * velocity against its motion.", .kinds = "tissue",
     .dimension = D::damping,
     .range = at_least(0)},
    {.table = "scene", .key = "axial_damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
     .meaning = "Damper along every spring: a force of axial_damping * the velocity at which its ends part.", .kinds = "tissue",
     .dimension = D::damping, .range = at_least(0)},
    {.table = "scene", .key = "gravity", .forms = kQuantity, .shape = Shape::three,
     .default_toml = "[\"0 m/s2\", \"0 m/s2\", \"0 m/s2\"]", .meaning = "On every particle.", .kinds = "tissue",
     .dimension = D::acceleration, .example = "[\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]"},
    {.table = "scene", .key = "fixed", .forms = kWord, .shape = Shape::one_or_list, .default_toml = "\"bottom\"",
     .meaning = "Faces of the lattice whose particles never move: `left` and `right` (least and greatest x), `front` and "
                "`back` (y), `bottom` and `top` (z).",
     .words = "left|right|front|back|bottom|top|none", .kinds = "tissue"},
    {.table = "scene", .key = "regions", .forms = kTable, .shape = Shape::list, .default_toml = "[]",
     .meaning = "Boxes of another material; of two that hold the same particle the later counts. A spring between two "
                "materials has the mean of their stiffnesses. At most 60.",
     .kinds = "tissue"},
    {.table = "scene", .key = "method", .forms = kWord, .default_toml = "\"symplectic-euler\"",
     .meaning = "How the equations of motion are integrated. The last three are implicit: stable at any step, and each step "
                "costs its iterations.",
     .words = kMethods, .kinds = "tissue"},
    {.table = "scene", .key = "iterations", .forms = kInteger,
     .meaning = "Of an implicit method's solver, per substep: of conjugate gradients, or sweeps of `vertex-block-descent`. "
                "Default: the method's own.",
     .kinds = "tissue", .range = between(1, kMostIterations), .example = "10"},
    {.table = "scene", .key = "local_model", .forms = kWord, .default_toml = "\"none\"",
     .meaning = "Stiffness at the tool that the solver reports with each force. `instantaneous`: the other particles stay; "
                "`settled`: they come to rest again (measured at rest when the scene loads).",
     .words = "none|instantaneous|settled", .kinds = "tissue"},
    {.table = "scene", .key = "substeps", .forms = kWord | kInteger, .default_toml = "\"auto\"",
     .meaning = "Solver steps per step. `auto`: the fewest that are stable in every configuration.", .words = "auto",
     .kinds = "tissue",
     .range = between(1, kMostSubsteps)},
    {.table = "scene", .key = "allow_unstable", .forms = kBoolean, .default_toml = "false",
     .meaning = "Lets an unstable step size start.",
     .kinds = "tissue"},
    {.table = "scene", .key = "work_group_size", .forms = kInteger, .default_toml = "64",
     .meaning = "OpenCL work items per group; results do not depend on it.",
     .kinds = "tissue", .range = between(1, 4096)},
    {.table = "scene.regions", .key = "min", .forms = kQuantity, .shape = Shape::three,
     .meaning = "Corner of the box, in the block's coordinates at rest: the origin is the block's minimum corner.",
     .required = true, .dimension = D::length, .example = "[\"0 mm\", \"0 mm\", \"0 mm\"]"},
    {.table = "scene.regions", .key = "max", .forms = kQuantity, .shape = Shape::three,
     .meaning = "Opposite corner; particles on the faces are inside.", .required = true, .dimension = D::length,
     .example = "[\"10 mm\", \"10 mm\", \"10 mm\"]"},
    {.table = "scene.regions", .key = "stiffness", .forms = kQuantity,
     .meaning = "k of each spring. Default: as outside.", .dimension = D::stiffness, .range = above(0)},
    {.table = "scene.regions", .key = "mass", .forms = kQuantity, .meaning = "Of one particle. Default: as outside.",
     .dimension = D::mass, .range = above(0)},
};

const std::vector<Field> kDevice{
    {.table = "device", .key = "name", .forms = kText,
     .meaning = "Letters, digits, _ and -; the first part of its signals.", .required = true,
     .example = "\"left\""},
    {.table = "device", .key = "driver", .forms = kWord, .default_toml = "\"reference\"",
     .meaning = "The driver code that runs.", .words = "reference"},
    {.table = "device", .key = "transport", .forms = kWord, .default_toml = "\"simulated\"",
     .meaning = "What the driver talks to under the virtual clock.", .words = "simulated"},
    {.table = "device", .key = "queue", .forms = kWord, .default_toml = "\"hidraw\"",
     .meaning = "Of unread reports: `hidraw` keeps 63 and drops the newest, `libusb` keeps 32 and drops the oldest.",
     .words = "hidraw|libusb"},
    {.table = "device", .key = "rate", .forms = kRate, .default_toml = "\"1 kHz\"",
     .meaning = "Of its ticks (one report in, one force out).",
     .range = between(1, 100'000)},
    {.table = "device", .key = "phase", .forms = kSpan, .default_toml = "\"0 ms\"",
     .meaning = "Its first tick, counted from the start of segment 0; less than one period.", .range = at_least(0)},
    {.table = "device", .key = "grab", .forms = kTable,
     .meaning = "How it touches the tissue, and where (tissue only, obligatory there)."},
    {.table = "device", .key = "motion", .forms = kTable,
     .meaning = "Of the programmed hand. Default: it stays at the origin."},
    {.table = "device", .key = "delay", .forms = kSpan, .default_toml = "\"0 s\"",
     .meaning = "From the tick that sends a force to when a `hand` feels it. A programmed motion feels none.",
     .range = between(0, 1)},
    {.table = "device", .key = "render", .forms = kTable, .meaning = "How scheduled forces reach the device."},
    {.table = "device", .key = "force_limit", .forms = kQuantity, .default_toml = "\"100 N\"",
     .meaning = "A longer force vector is shortened to this before it is sent.", .dimension = D::force, .range = above(0)},
    {.table = "device", .key = "slew_limit", .forms = kQuantity, .default_toml = "\"1000 kN/s\"",
     .meaning = "Largest change of the force per time.",
     .dimension = D::slew, .range = above(0)},
    {.table = "device.grab", .key = "center", .forms = kQuantity, .shape = Shape::three,
     .meaning = "In the block's coordinates: the origin is its minimum corner.", .required = true, .dimension = D::length,
     .example = "[\"65 mm\", \"65 mm\", \"135 mm\"]"},
    {.table = "device.grab", .key = "radius", .forms = kQuantity,
     .meaning = "Particles within it are held; of a `probe`: of its sphere.", .required = true,
     .dimension = D::length, .range = above(0), .example = "\"6 mm\""},
    {.table = "device.grab", .key = "coupling", .forms = kWord, .default_toml = "\"grab\"",
     .meaning = "`grab`: particles move rigidly with the tool. `spring`: a spring and a damper from the tool to them. `probe`: "
                "a sphere that pushes what is inside it outwards and never pulls.",
     .words = "grab|spring|probe"},
    {.table = "device.grab", .key = "stiffness", .forms = kQuantity,
     .meaning = "Of the whole spring, shared evenly; of a probe against each particle that it touches.",
     .kinds = "spring|probe", .required = true, .dimension = D::stiffness, .range = above(0)},
    {.table = "device.grab", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
     .meaning = "Of the whole coupling, shared evenly.", .kinds = "spring", .dimension = D::damping, .range = at_least(0)},
    {.table = "device.motion", .key = "kind", .forms = kWord, .meaning = "Every motion rests at its start for t < 0. `hand`: a mass that feels the force.",
     .words = kMotions, .required = true, .example = "\"still\""},
    {.table = "device.motion", .key = "velocity", .forms = kQuantity, .shape = Shape::three,
     .default_toml = "[\"0 m/s\", \"0 m/s\", \"0 m/s\"]", .meaning = "At t = 0.", .kinds = "hand", .dimension = D::velocity},
    {.table = "device.motion", .key = "velocity", .forms = kQuantity, .shape = Shape::three,
     .meaning = "After the start; of `stick-slip` the mean.",
     .kinds = "constant-velocity|ramp-stop|stick-slip", .required = true, .dimension = D::velocity,
     .example = "[\"0.1 m/s\", \"0 m/s\", \"0 m/s\"]"},
    {.table = "device.motion", .key = "start", .forms = kSmooth, .default_toml = "\"smooth 0 s\"",
     .meaning = "The velocity rises as a smoothstep over this time.", .kinds = "constant-velocity|ramp-stop",
     .range = between(0, kLongestRun_s),
     .example = "\"smooth 0.2 s\""},
    {.table = "device.motion", .key = "stop", .forms = kSpan, .meaning = "Dead stop at this time after its begin.",
     .kinds = "ramp-stop", .required = true,
     .range = above(0, kLongestRun_s), .example = "\"1 s\""},
    {.table = "device.motion", .key = "stick", .forms = kSpan,
     .meaning = "How long it holds at the start of each period `stick` + `slip`.", .kinds = "stick-slip",
     .required = true,
     .range = between(0, kLongestRun_s), .example = "\"90 ms\""},
    {.table = "device.motion", .key = "slip", .forms = kSpan,
     .meaning = "How long it then moves, evenly, to where the mean velocity has brought it.", .kinds = "stick-slip",
     .required = true,
     .range = above(0, kLongestRun_s), .example = "\"10 ms\""},
    {.table = "device.motion", .key = "amplitude", .forms = kQuantity, .shape = Shape::three,
     .meaning = "x = amplitude (1 - cos(2 pi f t)) / 2.", .kinds = "sine", .required = true, .dimension = D::length,
     .example = "[\"10 mm\", \"0 mm\", \"0 mm\"]"},
    {.table = "device.motion", .key = "frequency", .forms = kRate, .meaning = "f.", .kinds = "sine", .required = true,
     .range = above(0, 10'000),
     .example = "\"2 Hz\""},
    {.table = "device.motion", .key = "file", .forms = kFile,
     .meaning = "CSV with the header t_s,x_m,y_m,z_m and increasing times; linear between rows, held at the ends.",
     .kinds = "recorded",
     .required = true, .example = "\"motion.csv\""},
    {.table = "device.motion", .key = "delay", .forms = kSpan, .default_toml = "\"0 s\"",
     .meaning = "The motion begins this much after t = 0.",
     .kinds = "constant-velocity|sine|ramp-stop|stick-slip|recorded|minimum-jerk", .range = between(0, kLongestRun_s)},
    {.table = "device.motion", .key = "moves", .forms = kTable, .shape = Shape::list,
     .meaning = "One after the other, from the origin on; each from rest to rest with the least jerk.", .kinds = "minimum-jerk",
     .required = true, .example = "[{ to = [\"10 mm\", \"0 mm\", \"0 mm\"], duration = \"0.4 s\" }]"},
    {.table = "device.motion", .key = "mass", .forms = kQuantity, .meaning = "Of the device's moving part.", .kinds = "hand",
     .required = true, .dimension = D::mass, .range = above(0), .example = "\"0.2 kg\""},
    {.table = "device.motion", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
     .meaning = "Of the device, against its motion.", .kinds = "hand", .dimension = D::damping, .range = at_least(0)},
    {.table = "device.motion", .key = "stiffness", .forms = kQuantity, .default_toml = "\"0 N/m\"",
     .meaning = "Of what pulls it to its path.", .kinds = "hand", .dimension = D::stiffness, .range = at_least(0)},
    {.table = "device.motion", .key = "path", .forms = kTable,
     .meaning = "Where it means to go: any other motion. Default: it means to stay at the origin.", .kinds = "hand"},
    {.table = "device.motion", .key = "arm", .forms = kTable,
     .meaning = "Grips the device rigidly. Default: nobody holds it, the worst case.", .kinds = "hand"},
    {.table = "device.motion", .key = "push", .forms = kQuantity, .shape = Shape::three,
     .default_toml = "[\"0 N\", \"0 N\", \"0 N\"]", .meaning = "A constant force besides.", .kinds = "hand",
     .dimension = D::force},
    {.table = "device.motion", .key = "offset", .forms = kQuantity, .shape = Shape::three,
     .default_toml = "[\"0 mm\", \"0 mm\", \"0 mm\"]", .meaning = "From the path at t = 0, where it is released.",
     .kinds = "hand", .dimension = D::length, .range = between(-2, 2)},
    {.table = "device.motion.moves", .key = "to", .forms = kQuantity, .shape = Shape::three, .meaning = "Where it ends.",
     .required = true, .dimension = D::length, .example = "[\"10 mm\", \"0 mm\", \"0 mm\"]"},
    {.table = "device.motion.moves", .key = "duration", .forms = kSpan, .meaning = "Of the move.", .required = true,
     .range = above(0, kLongestRun_s), .example = "\"0.4 s\""},
    {.table = "device.motion.moves", .key = "rest", .forms = kSpan, .default_toml = "\"0 s\"",
     .meaning = "How long it stays there, before the next move.", .range = between(0, kLongestRun_s)},
    {.table = "device.motion.arm", .key = "mass", .forms = kQuantity, .meaning = "Added to the device's.", .required = true,
     .dimension = D::mass, .range = at_least(0), .example = "\"0.554 kg\""},
    {.table = "device.motion.arm", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
     .meaning = "Against its motion relative to the path.", .dimension = D::damping, .range = at_least(0)},
    {.table = "device.motion.arm", .key = "stiffness", .forms = kQuantity, .default_toml = "\"0 N/m\"",
     .meaning = "Towards the path.", .dimension = D::stiffness, .range = at_least(0)},
    {.table = "device.render", .key = "kind", .forms = kWord, .default_toml = "\"force\"",
     .meaning = "What a tick sends (docs/stiffness.md). `force`: the scheduled force itself. `local`: with the contact's stiffness, "
                "corrected for where the hand is by now. `smith`: corrected by a model of one mode.",
     .words = "force|local|smith"},
    {.table = "device.render", .key = "emission", .forms = kWord, .default_toml = "\"linear\"",
     .meaning = "`hold`: the latest scheduled force. `linear`: between two; one slot more latency.", .words = "linear|hold"},
    {.table = "device.render", .key = "alpha", .forms = kWord | kNumber, .default_toml = "1.0",
     .meaning = "The local stiffness is played so many times as stiff. `auto`: what makes up for the latency, and 0.07 more; 1 "
                "where the hand's damping allows more than that.",
     .words = "auto", .kinds = "local", .range = above(0, 4)},
    {.table = "device.render", .key = "stiffness", .forms = kWord, .default_toml = "\"instantaneous\"",
     .meaning = "Which one the solver reports, as `local_model` of [scene], which this sets.",
     .words = "instantaneous|settled", .kinds = "local"},
    {.table = "device.render", .key = "gap", .forms = kBoolean, .default_toml = "true",
     .meaning = "Whether the distance to a surface that is not touched is used. `false` is a control: the touch then comes late, "
                "with a jump.",
     .kinds = "local"},
    {.table = "device.render", .key = "cap", .forms = kWord | kQuantity,
     .meaning = "A stiffer contact is played as stiff as this, along its stiff directions, force and stiffness alike. `law`: nine "
                "tenths of the largest stable stiffness of a spring in this device's `hand`. Default: none.",
     .words = "law", .kinds = "local", .dimension = D::stiffness, .range = above(0), .example = "\"2000 N/m\""},
    {.table = "device.render", .key = "frequency", .forms = kRate,
     .meaning = "Of the model's mass between its springs, the tool held still. Default: the scene's, of kind `mode`.",
     .kinds = "smith", .range = above(0, 1000), .example = "\"7 Hz\""},
    {.table = "device.render", .key = "damping_ratio", .forms = kNumber,
     .meaning = "Of that mass; 1 is critical. Default: the scene's, of kind `mode`.", .kinds = "smith", .range = between(0, 10),
     .example = "0.1"},
    {.table = "device.render", .key = "static_stiffness", .forms = kQuantity,
     .meaning = "What the tool feels when the mass has come to rest; each of the two springs has twice that. Default: the "
                "scene's, of kind `mode`.",
     .kinds = "smith", .dimension = D::stiffness, .range = above(0)},
    {.table = "device.render", .key = "factor", .forms = kNumber, .default_toml = "1.1",
     .meaning = "Both springs are so many times as stiff in the model: too stiff costs little, too soft much.", .kinds = "smith",
     .range = above(0, 4)},
};

const std::vector<Field> kRemap{
    {.table = "remap", .key = "estimate", .forms = kTable, .meaning = "Of the segment length (strategy `paper`)."},
    {.table = "remap", .key = "bandwidth", .forms = kRate, .default_toml = "\"2 Hz\"",
     .meaning = "Of the loop of strategy `phase_locked`.",
     .range = above(0, 1000)},
    {.table = "remap", .key = "latency", .forms = kWord | kSpan, .default_toml = "\"minimal\"",
     .meaning = "From reading the hand to emitting the force. `minimal`: the least without underrun for any device phase; "
                "`minimal-this-phase`: for the phase of this run.",
     .words = "minimal|minimal-this-phase", .range = between(0, kLongestRun_s)},
    {.table = "remap", .key = "lead", .forms = kWord | kSpan, .default_toml = "\"minimal\"",
     .meaning = "How far before its slot a step reads the hand; `minimal` as for `latency`.",
     .words = "minimal|minimal-this-phase",
     .range = between(0, kLongestRun_s)},
    {.table = "remap", .key = "underrun", .forms = kTable, .meaning = "What is used when data is missing."},
    {.table = "remap", .key = "predict_window", .forms = kSpan, .default_toml = "\"8 ms\"",
     .meaning = "Strategy `predict` takes the hand's velocity from so much of the past.", .range = above(0, 1)},
    {.table = "remap", .key = "filter", .forms = kTable, .meaning = "Of strategy `filtered`: `direct`, smoothed."},
    {.table = "remap.estimate", .key = "kind", .forms = kWord, .default_toml = "\"ewma\"",
     .meaning = "Exponentially weighted moving average.",
     .words = "ewma"},
    {.table = "remap.estimate", .key = "weight", .forms = kNumber, .default_toml = "0.1",
     .meaning = "Of the newest segment.", .range = above(0, 1)},
    {.table = "remap.underrun", .key = "interaction", .forms = kWord, .default_toml = "\"clamp\"",
     .meaning = "`clamp`: the newest sample. `gate`: the step waits for its sample. `extrapolate`: the line through the "
                "last 4 ms of samples, at most 10 ms on.",
     .words = "clamp|gate|extrapolate"},
    {.table = "remap.underrun", .key = "force", .forms = kWord, .default_toml = "\"hold\"",
     .meaning = "`hold`: the last force. `extrapolate`: the line through the last two, at most 10 ms on; needs `linear` "
                "emission.",
     .words = "hold|extrapolate"},
    {.table = "remap.filter", .key = "kind", .forms = kWord, .default_toml = "\"butterworth\"",
     .meaning = "`butterworth`: second order low-pass. `one-euro`: a first order low-pass whose cutoff rises with speed.",
     .words = "moving-average|butterworth|one-euro"},
    {.table = "remap.filter", .key = "on", .forms = kWord, .default_toml = "\"force\"",
     .meaning = "`interaction`: of what the steps read. `force`: of what the device's ticks play.",
     .words = "interaction|force"},
    {.table = "remap.filter", .key = "window", .forms = kSpan, .default_toml = "\"1 segment\"",
     .meaning = "What is averaged.", .kinds = "moving-average", .range = above(0, kLongestRun_s)},
    {.table = "remap.filter", .key = "cutoff", .forms = kRate, .default_toml = "\"10 Hz\"",
     .meaning = "Where it is down by 3 dB.", .kinds = "butterworth", .range = above(0, 100'000)},
    {.table = "remap.filter", .key = "min_cutoff", .forms = kRate, .default_toml = "\"1 Hz\"",
     .meaning = "Cutoff at rest.", .kinds = "one-euro", .range = above(0, 100'000)},
    {.table = "remap.filter", .key = "beta", .forms = kNumber, .default_toml = "1.0",
     .meaning = "Hz more of cutoff per m/s (interaction) or N/s (force).", .kinds = "one-euro", .range = at_least(0)},
    {.table = "remap.filter", .key = "derivative_cutoff", .forms = kRate, .default_toml = "\"1 Hz\"",
     .meaning = "Of the low-pass on the speed.", .kinds = "one-euro", .range = above(0, 100'000)},
};

const std::vector<Field> kStudy{
    {.table = "study", .key = "duration", .forms = kSpan, .default_toml = "\"64 ms\"",
     .meaning = "Simulated time that is judged, from the begin of the first motion on.", .range = above(0, kLongestRun_s)},
    {.table = "study", .key = "methods", .forms = kWord, .shape = Shape::list,
     .default_toml = "[\"symplectic-euler\", \"velocity-verlet\", \"rk4\", \"implicit-euler\", \"implicit-midpoint\", "
                     "\"vertex-block-descent\"]",
     .meaning = "Of [scene] `method`, instead of the scene's own.", .words = kMethods},
    {.table = "study", .key = "solvers", .forms = kWord, .shape = Shape::list, .default_toml = "[\"cpu\"]",
     .meaning = "Of [scene] `solver`, instead of the scene's own.", .words = "opencl|cpu|cpu-double"},
    {.table = "study", .key = "step_sizes", .forms = kDuration | kRate, .shape = Shape::list,
     .meaning = "Of the methods: whole parts of the scene's step, or multiples of it. Default: halvings of it; for explicit "
                "methods from the first one above the limit to the fourth below it, for implicit ones down to an eighth.",
     .range = above(0), .example = "[\"1 ms\", \"0.5 ms\"]"},
    {.table = "study", .key = "iterations", .forms = kInteger, .shape = Shape::list,
     .meaning = "Of the methods that iterate, each with all of them. Default: each method's own.",
     .range = between(1, kMostIterations), .example = "[5, 20]"},
    {.table = "study", .key = "repeats", .forms = kInteger, .default_toml = "5",
     .meaning = "Times that each cost is measured: least, median and greatest are reported.", .range = between(1, 1000)},
    {.table = "study", .key = "stiffness_limit", .forms = kTable,
     .meaning = "Look for the largest [scene] `stiffness` at which every strategy is stable in a `hand`, and for nothing else."},
    {.table = "study.stiffness_limit", .key = "from", .forms = kQuantity, .meaning = "Where the search begins; stable, it should be.",
     .required = true, .dimension = D::stiffness, .range = above(0), .example = "\"20 N/m\""},
    {.table = "study.stiffness_limit", .key = "to", .forms = kQuantity, .meaning = "Where it gives up.", .required = true,
     .dimension = D::stiffness, .range = above(0), .example = "\"30000 N/m\""},
    {.table = "study.stiffness_limit", .key = "seeds", .forms = kInteger, .default_toml = "1",
     .meaning = "Stable is what is so with each of so many seeds, from [run] `seed` on.", .range = between(1, 1000)},
    {.table = "study.stiffness_limit", .key = "mass", .forms = kWord, .default_toml = "\"kept\"",
     .meaning = "Of a tissue, whose regions and tools become stiffer in proportion. `kept`: what is stiffer swings faster. "
                "`in-proportion`: masses and axial damping too, so that its frequencies stay, as those of a `mode` do.",
     .words = "kept|in-proportion"},
};

const std::vector<Field> kSweep{
    {.table = "sweep", .key = "seeds", .forms = kText | kInteger, .shape = Shape::one_or_list,
     .meaning = "Of [run] `seed`. `\"0..30000\"` is 30000 seeds, 0 to 29999. Default: that of [run].",
     .range = at_least(0), .example = "\"0..30000\""},
    {.table = "sweep", .key = "stop_after", .forms = kInteger,
     .meaning = "So many failures, by number of point; what comes after is left out. Not with `find`.", .range = between(1, 1e9),
     .example = "100"},
    {.table = "sweep", .key = "keep_worst", .forms = kInteger, .default_toml = "5",
     .meaning = "Points named at the end: the farthest over their limits, or the nearest below.", .range = between(0, 1000)},
    {.table = "sweep", .key = "grid", .forms = kTable,
     .meaning = "Every combination of these values runs with every seed; the first key varies slowest."},
    {.table = "sweep", .key = "find", .forms = kTable,
     .meaning = "The sweep passes if there is such a value, whatever fails on its other side."},
    {.table = "sweep.grid", .key = "*", .forms = kTable | kAnything, .shape = Shape::one_or_list,
     .meaning = "A key of this scenario, as `--set` names it, and its values; a table is evenly spaced ones.",
     .example = "[\"5 ms\", \"10 ms\"]"},
    {.table = "sweep.grid.*", .key = "from", .forms = kLimit, .meaning = "The first value.", .required = true,
     .example = "\"5 ms\""},
    {.table = "sweep.grid.*", .key = "to", .forms = kLimit, .meaning = "The last value, in the unit of the first.",
     .required = true, .example = "\"20 ms\""},
    {.table = "sweep.grid.*", .key = "count", .forms = kInteger,
     .meaning = "How many. Those between are rounded to twelve digits, times to a nanosecond.", .required = true,
     .range = between(2, 100'000), .example = "7"},
    {.table = "sweep.find", .key = "smallest", .forms = kText,
     .meaning = "This key of the grid: its smallest value for which it and all larger ones pass.",
     .example = "\"remap.latency\""},
    {.table = "sweep.find", .key = "largest", .forms = kText,
     .meaning = "This key of the grid: its largest value for which it and all smaller ones pass.",
     .example = "\"timing.visualization\""},
    {.table = "sweep.find", .key = "where", .forms = kWord, .default_toml = "\"all-pass\"",
     .meaning = "Every seed, with every value of the other keys.", .words = "all-pass"},
    {.table = "sweep.find", .key = "at_most", .forms = kLimit, .meaning = "Of `smallest`: a larger one fails the sweep.",
     .example = "\"16 ms\""},
    {.table = "sweep.find", .key = "at_least", .forms = kLimit, .meaning = "Of `largest`: a smaller one fails the sweep.",
     .example = "\"10 ms\""},
};

const std::vector<Field> kExpect{
    {.table = "expect", .key = "signal", .forms = kText,
     .meaning = "`<device>.interaction.<strategy>`, `<device>.force.<strategy>`, "
                "`<device>.buffers.<strategy>`, `closed_loop.<device>.<strategy>`, `solver.<strategy>`, "
                "`events.<lane>.<name>` or `run`; `*` for any one part. Of a case: `case.<method>.<solver>`.",
     .required = true, .example = "\"left.interaction.phase_locked\""},
    {.table = "expect", .key = "metric", .forms = kText, .meaning = "A number of that signal: docs/metrics.md.",
     .required = true,
     .example = "\"velocity_jump\""},
    {.table = "expect", .key = "min", .forms = kLimit, .meaning = "The value must not be below.", .example = "\"4 step\""},
    {.table = "expect", .key = "max", .forms = kLimit, .meaning = "The value must not be above.",
     .example = "\"1e-6 step\""},
    {.table = "expect", .key = "equals", .forms = kLimit, .meaning = "min and max in one.", .example = "0"},
    {.table = "expect", .key = "at", .forms = kNumber, .shape = Shape::list,
     .meaning = "Of a case: only its cells with values between these two.", .example = "[0.1, 1]"},
    {.table = "expect", .key = "confidence", .forms = kQuantity,
     .meaning = "Of an `underrun_rate`: how sure the `max` must be. Judged is the upper bound of Clopper and Pearson on the "
                "share of segments with an underrun; the maps alone run over the seeds that takes.",
     .dimension = D::ratio, .range = above(0, 0.999999), .example = "\"95 %\""},
    {.table = "expect", .key = "seeds", .forms = kInteger,
     .meaning = "With `confidence`: the seeds to run, this run's and the ones after it. Default: the fewest that suffice if none "
                "underruns.",
     .range = between(1, 1e6), .example = "100"},
    {.table = "expect", .key = "because", .forms = kText, .default_toml = "\"\"", .meaning = "Why it must hold."},
    {.table = "expect", .key = "expect_fail", .forms = kBoolean, .default_toml = "false",
     .meaning = "A known fault: passing then fails."},
    {.table = "expect_stop", .key = "reason", .forms = kWord, .meaning = "Why the run stops.",
     .words = "unstable-step|diverged|bad-input",
     .required = true, .example = "\"diverged\""},
    {.table = "expect_stop", .key = "at_most_step", .forms = kInteger, .meaning = "It stops at this step or before.",
     .range = between(0, 1e12),
     .example = "100"},
};

// clang-format on

/// What a hand means to do is any motion but a hand.
std::vector<Field> path_fields() {
  std::vector<Field> rows;
  for (Field field : kDevice) {
    if (field.table == "device.motion.moves")
      field.table = "device.motion.path.moves";
    else if (field.table == "device.motion" && field.kinds != "hand")
      field.table = "device.motion.path";
    else
      continue;
    if (field.key == "kind") {
      field.words = kPaths;
      field.meaning = "Every motion rests at its start for t < 0.";
    }
    rows.push_back(field);
  }
  return rows;
}

std::vector<Field> joined() {
  std::vector<Field> all;
  const std::vector<Field> paths = path_fields();
  for (const std::vector<Field>* part : {&kTop, &kCase, &kRun, &kTiming, &kScene, &kDevice, &paths, &kRemap, &kStudy, &kSweep, &kExpect}) {
    all.insert(all.end(), part->begin(), part->end());
  }
  return all;
}

}  // namespace

const std::vector<Field>& fields() {
  static const std::vector<Field> all = joined();
  return all;
}

}  // namespace evenstep::internal
