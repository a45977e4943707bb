// The field table. One row per key; a key that means different things for different kinds has a row for each.
#include "fields.h"

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

using D = Dimension;
constexpr std::string_view kStrategies = "ideal|direct|paper|phase_locked";

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
    {.table = "", .key = "run", .forms = kTable, .meaning = "How long, how often, with which strategies."},
    {.table = "", .key = "timing", .forms = kTable, .meaning = "What the GPU costs.", .required = true},
    {.table = "", .key = "scene", .forms = kTable,
     .meaning = "What is simulated. Only what is named here exists in the run.", .required = true},
    {.table = "", .key = "device", .forms = kTable, .shape = Shape::list, .meaning = "The hands: one or two.",
     .required = true},
    {.table = "", .key = "remap", .forms = kTable, .meaning = "The map between real time and simulation time."},
    {.table = "", .key = "expect", .forms = kTable, .shape = Shape::list,
     .meaning = "What must hold; each entry is judged on its own."},
    {.table = "", .key = "expect_append", .forms = kTable, .shape = Shape::list,
     .meaning = "Expectations added to those of the files named in `extends`."},
    {.table = "", .key = "expect_stop", .forms = kTable,
     .meaning = "The run must stop early, for this reason; anything else fails."},
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
};

const std::vector<Field> kTiming{
    {.table = "timing", .key = "segment", .forms = kRate | kDuration,
     .meaning = "Rate or length T of the time segment (one visualization and its steps). Obligatory unless `step` is a "
                "duration: then segments follow each other without a gap. 10 us to 9 s.",
     .kinds = "programmed", .range = above(0), .example = "\"30 Hz\""},
    {.table = "timing", .key = "visualization", .forms = kDuration,
     .meaning = "Run time V of the visualization, the mean where it varies.",
     .kinds = "programmed", .required = true, .range = between(0, kLongestRun_s), .example = "\"11.1 ms\""},
    {.table = "timing", .key = "steps", .forms = kInteger, .shape = Shape::one_or_list,
     .meaning = "Steps N per segment; of several values one is drawn per segment.", .kinds = "programmed",
     .required = true, .range = between(1, kMostSteps), .example = "15"},
    {.table = "timing", .key = "step", .forms = kWord | kDuration, .default_toml = "\"fill\"",
     .meaning = "Run time s of a step, the mean where it varies. `fill`: (T - V) / N. `real`: on a wall clock what the "
                "solver really takes; `fill` under the virtual clock.",
     .words = "fill|real", .kinds = "programmed", .range = above(0, kLongestRun_s)},
    {.table = "timing", .key = "order", .forms = kWord, .default_toml = "\"visualization-first\"",
     .meaning = "What opens a segment. `steps-first` needs a lead of V.", .words = "visualization-first|steps-first",
     .kinds = "programmed"},
    {.table = "timing", .key = "jitter", .forms = kTable,
     .meaning = "Random run times. Segments then follow each other without a gap.", .kinds = "programmed"},
    {.table = "timing", .key = "trace", .forms = kFile,
     .meaning = "A recording to replay (segment,kind,index,begin_ns,end_ns); then [timing] holds nothing else.",
     .example = "\"recorded/x.csv\""},
    {.table = "timing.jitter", .key = "visualization", .forms = kLognormal,
     .meaning = "Log-normal with this coefficient of variation; the mean stays V.", .range = between(0, 1),
     .example = "\"lognormal 10 %\""},
    {.table = "timing.jitter", .key = "step", .forms = kLognormal, .meaning = "The same for each step; the mean stays s.",
     .range = between(0, 1),
     .example = "\"lognormal 10 %\""},
};

const std::vector<Field> kScene{
    {.table = "scene", .key = "kind", .forms = kWord,
     .meaning = "`spring`: F = -k x, memoryless. `tissue`: particles on a lattice, each joined to its 18 neighbours by "
                "springs.",
     .words = "spring|tissue", .required = true, .example = "\"spring\""},
    {.table = "scene", .key = "solver", .forms = kWord, .default_toml = "\"cpu-double\"", .meaning = "What computes it.",
     .words = "opencl|cpu|cpu-double", .kinds = "spring"},
    {.table = "scene", .key = "solver", .forms = kWord, .default_toml = "\"opencl\"",
     .meaning = "What computes it; `cpu` (float) and `opencl` agree bit for bit.", .words = "opencl|cpu|cpu-double",
     .kinds = "tissue"},
    {.table = "scene", .key = "stiffness", .forms = kQuantity, .default_toml = "\"200 N/m\"", .meaning = "k.",
     .kinds = "spring",
     .dimension = D::stiffness, .range = at_least(0)},
    {.table = "scene", .key = "stiffness", .forms = kQuantity, .default_toml = "\"50 N/m\"",
     .meaning = "k of each spring.", .kinds = "tissue",
     .dimension = D::stiffness, .range = above(0)},
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
    {.table = "scene", .key = "fixed", .forms = kWord, .default_toml = "\"bottom\"",
     .meaning = "Particles that never move.", .words = "bottom|none",
     .kinds = "tissue"},
    {.table = "scene", .key = "substeps", .forms = kWord | kInteger, .default_toml = "\"auto\"",
     .meaning = "Solver steps per step. `auto`: the fewest that are stable in every configuration.", .words = "auto",
     .kinds = "tissue",
     .range = between(1, 10'000)},
    {.table = "scene", .key = "allow_unstable", .forms = kBoolean, .default_toml = "false",
     .meaning = "Lets an unstable step size start.",
     .kinds = "tissue"},
    {.table = "scene", .key = "work_group_size", .forms = kInteger, .default_toml = "64",
     .meaning = "OpenCL work items per group; results do not depend on it.",
     .kinds = "tissue", .range = between(1, 4096)},
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
     .meaning = "Which particles it holds (tissue only, obligatory there)."},
    {.table = "device", .key = "motion", .forms = kTable,
     .meaning = "Of the programmed hand. Default: it stays at the origin."},
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
     .meaning = "Particles within it move rigidly with the tool.", .required = true,
     .dimension = D::length, .range = above(0), .example = "\"6 mm\""},
    {.table = "device.motion", .key = "kind", .forms = kWord, .meaning = "Every motion rests at its start for t < 0.",
     .words = "still|constant-velocity|sine|ramp-stop|stick-slip|recorded", .required = true, .example = "\"still\""},
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
     .kinds = "constant-velocity|sine|ramp-stop|stick-slip|recorded", .range = between(0, kLongestRun_s)},
    {.table = "device.render", .key = "kind", .forms = kWord, .default_toml = "\"force\"",
     .meaning = "The scheduled force itself.", .words = "force"},
    {.table = "device.render", .key = "emission", .forms = kWord, .default_toml = "\"linear\"",
     .meaning = "`hold`: the latest scheduled force. `linear`: between two; one slot more latency.", .words = "linear|hold"},
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
    {.table = "remap.estimate", .key = "kind", .forms = kWord, .default_toml = "\"ewma\"",
     .meaning = "Exponentially weighted moving average.",
     .words = "ewma"},
    {.table = "remap.estimate", .key = "weight", .forms = kNumber, .default_toml = "0.1",
     .meaning = "Of the newest segment.", .range = above(0, 1)},
    {.table = "remap.underrun", .key = "interaction", .forms = kWord, .default_toml = "\"clamp\"",
     .meaning = "The newest sample.", .words = "clamp"},
    {.table = "remap.underrun", .key = "force", .forms = kWord, .default_toml = "\"hold\"", .meaning = "The last force.",
     .words = "hold"},
};

const std::vector<Field> kExpect{
    {.table = "expect", .key = "signal", .forms = kText,
     .meaning = "`<device>.interaction.<strategy>`, `<device>.force.<strategy>`, "
                "`<device>.buffers.<strategy>`, `solver.<strategy>`, `events.<lane>.<name>` or `run`; `*` for any one part.",
     .required = true, .example = "\"left.interaction.phase_locked\""},
    {.table = "expect", .key = "metric", .forms = kText, .meaning = "A number of that signal: docs/metrics.md.",
     .required = true,
     .example = "\"velocity_jump\""},
    {.table = "expect", .key = "min", .forms = kLimit, .meaning = "The value must not be below.", .example = "\"4 step\""},
    {.table = "expect", .key = "max", .forms = kLimit, .meaning = "The value must not be above.",
     .example = "\"1e-6 step\""},
    {.table = "expect", .key = "equals", .forms = kLimit, .meaning = "min and max in one.", .example = "0"},
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

std::vector<Field> joined() {
  std::vector<Field> all;
  for (const std::vector<Field>* part : {&kTop, &kRun, &kTiming, &kScene, &kDevice, &kRemap, &kExpect}) {
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
