// [timing]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/format/load.h"
#include "evenstep/text/rational.h"
#include "governor.h"
#include "recorded_timing.h"
#include "src/field_rows.h"
#include "src/sections.h"
#include "timing_models.h"

namespace evenstep::internal {
namespace {

constexpr __int128 kNsPerSecond = 1'000'000'000;
// With at least 10 us, every product below fits into 128 bits (at most 1e9 steps in a list: kMostStepCounts). With at most
// 9 s, a whole number of ns is an exact rate (kMostRateDen).
constexpr Duration kShortestSegment{10'000}, kLongestSegment{kMostRateDen};

Duration floor_ns(__int128 num, __int128 den) { return {static_cast<std::int64_t>(num / den)}; }

/// T, V, N and s as exact numbers: T = den / num seconds, mean N = sum / count.
struct Shares {
  Rate segment;
  __int128 sum = 0, count = 0;
  Duration visualization;

  Duration segment_length() const { return {instant_ns(segment, 1)}; }
  /// V + mean N * s, in ns times count.
  __int128 used(Duration step) const { return visualization.ns * count + step.ns * sum; }
  bool fits(Duration step) const { return used(step) * segment.num <= segment.den * kNsPerSecond * count; }
  Duration filled_step() const {
    const __int128 left = segment.den * kNsPerSecond - static_cast<__int128>(visualization.ns) * segment.num;
    return floor_ns(left * count, sum * segment.num);
  }
};

/// Stands for the length of a drawing, which nobody knows before it is made, in all that is computed before the run.
constexpr Duration kUnknownDrawing{1};

/// Adds an error if the sizes do not go with what is drawn.
void read_picture(const Table& timing, TimingSpec& spec, Errors& errors) {
  if (!timing.has("picture")) return;
  if (spec.work != VisualizationWork::render)
    return errors.add(timing.place("picture"),
                      "'picture' is about visualization = \"render\", and nothing is drawn here; remove it");
  const std::vector<Value> sides = timing.at("picture").list;
  if (sides.size() != 2)
    return errors.add(timing.place("picture"), "'picture': it has a width and a height; write picture = [800, 600]");
  spec.picture_px = {static_cast<int>(sides[0].integer), static_cast<int>(sides[1].integer)};
}

/// Reads the visualization into `spec`; of a drawing without a length V is kUnknownDrawing.
void read_visualization(ScenarioReading& reading, const Table& timing) {
  TimingSpec& spec = reading.scenario.timing;
  const WorkText written = timing.work("visualization");
  spec.work = written.work;
  spec.work_place = timing.place("visualization");
  spec.programmed.visualization = written.length.value_or(kUnknownDrawing);
  if (!written.length) {
    spec.real_steps = spec.real_steps || !spec.programmed.step;  // "fill" shares out what V leaves
    if (!reading.real_time)
      reading.errors.add(timing.place("visualization"),
                         "'visualization': \"render\" takes as long as it takes, which only a wall clock can tell; write "
                         "\"render 11.1 ms\", or `evenstep record --visualization render` here and replay its trace");
  } else if (spec.work != VisualizationWork::pause && written.length->ns == 0) {
    reading.errors.add(
        timing.place("visualization"),
        fmt::format("'visualization': \"{}\" is out of range; it must be above 0 s", timing.text("visualization")));
  }
  read_picture(timing, spec, reading.errors);
}

Shares read_shares(const Table& timing, ProgrammedTiming& programmed, Errors& errors) {
  Shares shares;
  programmed.steps = read_step_counts(timing, errors);
  for (const int count : programmed.steps) shares.sum += count;
  shares.count = static_cast<__int128>(programmed.steps.size());
  shares.visualization = programmed.visualization;
  return shares;
}

/// Reads the segment. Returns false, with an error, if its length is not usable.
bool read_segment(const Table& timing, Shares& shares, Errors& errors) {
  const std::string text = timing.text("segment");
  const Result<Rate> rate = parse_rate(text);
  const Duration length = rate ? Duration{instant_ns(*rate, 1)} : *parse_duration(text);
  if (length < kShortestSegment || length > kLongestSegment) {
    errors.add(timing.place("segment"),
               fmt::format("'segment': \"{}\" is out of range; it must be between 10 us and 9 s", text));
    return false;
  }
  shares.segment = rate ? *rate : reduced_rate(kNsPerSecond, length.ns);
  return true;
}

/// Without a segment: T = V + mean N * s.
bool join_segment(const Table& timing, Shares& shares, Duration step, Errors& errors) {
  const __int128 length_ns = shares.used(step) / shares.count;
  if (length_ns < kShortestSegment.ns || length_ns > kLongestSegment.ns) {
    errors.add(timing.place("step"), "'step': V + N s is out of range; it must be between 10 us and 9 s");
    return false;
  }
  shares.segment = reduced_rate(kNsPerSecond * shares.count, shares.used(step));
  return true;
}

/// s = (T - V) / mean N.
Duration fill(const Table& timing, const Shares& shares, Errors& errors) {
  const std::string lengths =
      fmt::format("V = {} of a segment of T = {}", in_ms(shares.visualization), in_ms(shares.segment_length()));
  if (!shares.fits({0}) || shares.filled_step().ns < 1) {
    errors.add(timing.place("visualization"),
               fmt::format("'visualization': {} leaves no time for steps; make it shorter, or the segment longer", lengths));
    return {};
  }
  return shares.filled_step();
}

void check_fixed_step(const Table& timing, const Shares& shares, Duration step, Errors& errors) {
  if (shares.fits(step)) return;
  if (step > shares.segment_length()) {
    errors.add(timing.place("step"),
               fmt::format("'step': {} is longer than the segment of {}", in_ms(step), in_ms(shares.segment_length())));
    return;
  }
  errors.add(timing.place("step"),
             fmt::format("'step': V + N s = {} is longer than the segment of {}; write step = \"fill\", fewer steps, or "
                         "leave 'segment' out",
                         in_ms(floor_ns(shares.used(step), shares.count)), in_ms(shares.segment_length())));
}

/// The error for a missing segment: without it there is no grid to wait for, and no time that "fill" could share out.
void missing_segment(const Table& timing, std::string_view what, Errors& errors) {
  errors.add(timing.place("segment"),
             fmt::format("[timing] has no 'segment', which {} needs; write segment = \"30 Hz\"", what));
}

/// Computes T for visualizations and steps that take turns; false, with an error, if that is impossible.
bool read_length(const Table& timing, const ProgrammedTiming& programmed, Shares& shares, Errors& errors) {
  if (timing.has("segment")) {
    if (!read_segment(timing, shares, errors)) return false;
    if (programmed.step) check_fixed_step(timing, shares, *programmed.step, errors);
    return true;
  }
  if (programmed.paced) return missing_segment(timing, "paced = true", errors), false;
  if (programmed.step) return join_segment(timing, shares, *programmed.step, errors);
  return missing_segment(timing, fmt::format("step = \"{}\"", timing.text("step")), errors), false;
}

/// Adds an error if nothing waits for the grid that is given.
void check_grid_is_used(const Table& timing, const ProgrammedTiming& programmed, Errors& errors) {
  if (!timing.has("segment") || !programmed.step || programmed.paced || is_periodic(programmed)) return;
  errors.add(timing.place("segment"),
             "'segment': where run times vary, segments of a given 'step' follow each other without a gap; write "
             "paced = true to keep them to this grid, or leave 'segment' out");
}

/// The time that the models add to the mean segment, ns; negative if dropped visualizations shorten it.
double added_ns(const ProgrammedTiming& programmed) {
  ProgrammedTiming plain = programmed;
  plain.first_step = plain.dropped_visualization = plain.merged_visualization = 0;
  plain.spikes.reset();
  plain.hitch.reset();
  plain.preemption.reset();
  return mean_timing(programmed).segment_ns - mean_timing(plain).segment_ns;
}

/// Sets the nominal times. Segment and slot are means (to 1 ns if a model adds to them); visualization and step are as
/// written.
void set_nominal(Scenario& scenario, const Shares& shares, Duration step) {
  const ProgrammedTiming& programmed = scenario.timing.programmed;
  const std::int64_t added = programmed.paced ? 0 : std::llround(added_ns(programmed));
  // T = length / num ns.
  const __int128 num = shares.segment.num, length = shares.segment.den * kNsPerSecond + added * num;
  const Rate slots = reduced_rate(shares.sum * kNsPerSecond * num, length * shares.count);
  scenario.scene.step_rate = slots;
  scenario.nominal = {.segment = floor_ns(length, num),
                      .visualization = shares.visualization,
                      .slot = {instant_ns(slots, 1)},
                      .step_run_time = step,
                      .known = true};
}

void read_in_turn(ScenarioReading& reading, const Table& timing) {
  Errors& errors = reading.errors;
  const std::size_t errors_before = errors.count();
  ProgrammedTiming& programmed = reading.scenario.timing.programmed;
  Shares shares = read_shares(timing, programmed, errors);
  if (!read_length(timing, programmed, shares, errors)) return;
  const Duration step = programmed.step ? *programmed.step : fill(timing, shares, errors);
  if (errors.count() > errors_before) return;
  programmed.segment = shares.segment;
  read_timing_models(timing, programmed, errors);
  check_grid_is_used(timing, programmed, errors);
  check_pace(timing, programmed, errors);
  if (errors.count() == errors_before) set_nominal(reading.scenario, shares, step);
}

/// Checks that no visualization is so long that more steps come beside it, or become due, than a segment may have. `step`:
/// what there is one of in that time, the shortest.
void check_steps_beside(const Table& timing, const ProgrammedTiming& programmed, Duration step, Errors& errors) {
  const auto check = [&](const Table& table, Duration visualization) {
    if (static_cast<double>(visualization.ns) <= kMostSteps * static_cast<double>(step.ns)) return;
    errors.add(
        table.place("visualization"),
        fmt::format("'visualization': more than {:.0f} steps of {} come beside it, or become due; write a shorter time",
                    kMostSteps, in_ms(step)));
  };
  check(timing, programmed.visualization);
  const std::vector<Table> changes = timing.tables("changes");
  for (std::size_t i = 0; i < changes.size() && i < programmed.changes.size(); ++i)
    check(changes[i], programmed.changes[i].visualization.value_or(Duration{}));
  if (programmed.hitch) check(timing.table("hitch"), programmed.hitch->visualization);
}

/// Computes T and s for a visualization in a lane of its own; false, with an error, if that is impossible.
bool read_lanes(const Table& timing, ProgrammedTiming& programmed, Shares& shares, Errors& errors) {
  shares.visualization = programmed.visualization;
  if (programmed.visualization.ns == 0) {
    errors.add(timing.place("visualization"),
               "'visualization': order = \"concurrent\" needs one, it opens the segments; write a longer time, or another "
               "order");
    return false;
  }
  if (timing.has("segment") != programmed.paced) {
    if (programmed.paced) return missing_segment(timing, "paced = true", errors), false;
    errors.add(timing.place("segment"),
               "'segment': with order = \"concurrent\" visualizations follow each other without a gap; write paced = true "
               "to keep them to this grid, or leave 'segment' out");
    return false;
  }
  if (timing.has("steps") == programmed.step.has_value()) {
    errors.add(timing.place(programmed.step ? "steps" : "step"),
               "order = \"concurrent\" needs either 'steps', the mean number per segment, or 'step', a run time: the one "
               "gives the other");
    return false;
  }
  programmed.steps = {timing.has("steps") ? static_cast<int>(timing.integer("steps")) : 1};
  if (programmed.paced) return read_segment(timing, shares, errors);
  shares.segment = reduced_rate(kNsPerSecond, programmed.visualization.ns);
  return true;
}

/// Steps follow each other without a gap, so the mean slot is the mean step. It is exact if nothing is added to the steps
/// that 'steps' asks for (except for what mean_timing neglects), otherwise to 1 ps.
void set_nominal_of_lanes(Scenario& scenario, const Shares& shares) {
  const ProgrammedTiming& programmed = scenario.timing.programmed;
  const MeanTiming mean = mean_timing(programmed);
  const bool as_asked = !programmed.step && added_ns(programmed) == 0 && !programmed.spikes;
  const double segment_ns = programmed.paced ? static_cast<double>(shares.segment_length().ns) : mean.segment_ns;
  const Rate slots = as_asked ? reduced_rate(shares.segment.num * programmed.steps.front(), shares.segment.den)
                              : reduced_rate(kNsPerSecond * 1000, std::llround(1000 * segment_ns / mean.steps));
  const Duration slot{instant_ns(slots, 1)};
  scenario.scene.step_rate = slots;
  scenario.nominal = {.segment = {std::llround(segment_ns)},
                      .visualization = programmed.visualization,
                      .slot = slot,
                      .step_run_time = slot,
                      .known = true};
}

void read_concurrent(ScenarioReading& reading, const Table& timing) {
  Errors& errors = reading.errors;
  const std::size_t errors_before = errors.count();
  ProgrammedTiming& programmed = reading.scenario.timing.programmed;
  Shares shares;
  if (!read_lanes(timing, programmed, shares, errors)) return;
  programmed.segment = shares.segment;
  read_timing_models(timing, programmed, errors);
  check_pace(timing, programmed, errors);
  Duration step = starting_step(programmed);
  for (const TimingChange& change : programmed.changes) step = std::min(step, change.step.value_or(step));
  check_steps_beside(timing, programmed, step, errors);
  if (errors.count() == errors_before) set_nominal_of_lanes(reading.scenario, shares);
}

/// When a paced schedule wakes up after a segment that took too long.
void read_wake(const Table& timing, ProgrammedTiming& programmed, Errors& errors) {
  const std::string wake = timing.text("wake");
  if (wake == "catch-up") return;
  programmed.wake = wake == "absolute-grid" ? WakeUp::absolute_grid : WakeUp::from_last_update;
  if (programmed.paced && programmed.order == SegmentOrder::visualization_first) return;
  errors.add(
      timing.place("wake"),
      fmt::format("'wake': \"{}\" needs paced = true and order = \"visualization-first\": otherwise segments wait for no "
                  "grid, or their visualization does",
                  wake));
}

constexpr std::string_view kOrders[] = {"visualization-first", "steps-first", "concurrent"};

/// Adds an error if the steps take all the time there is, at the beginning or after a change.
void check_load(const Table& timing, const ProgrammedTiming& programmed, Errors& errors) {
  const Accumulator& loop = *programmed.accumulator;
  if (loop.max_steps) return;
  ProgrammedTiming changed = programmed;
  const auto falls_behind = [&](const Place& place) {
    const double step_ns = mean_timing(changed).step_ns, size_ns = 1e9 / in_Hz(loop.step_rate);
    if (step_ns < size_ns) return false;
    errors.add(place,
               fmt::format("'step': a step takes {:.6g} ms on average and simulates {:.6g} ms, so each frame has more "
                           "steps than the one before; make it shorter, the step_size longer, or write max_steps = 8",
                           step_ns * 1e-6, size_ns * 1e-6));
    return true;
  };
  if (falls_behind(timing.place("step"))) return;
  const std::vector<Table> entries = timing.tables("changes");
  for (std::size_t i = 0; i < programmed.changes.size(); ++i) {
    if (!programmed.changes[i].step) continue;
    changed.step = programmed.changes[i].step;
    if (falls_behind(entries[i].place("step"))) return;
  }
}

/// Adds an error if a frame may take no time.
void check_frames_take_time(const Table& timing, const ProgrammedTiming& programmed, Errors& errors) {
  if (programmed.paced) return;
  const auto refuse = [&](const Place& place, std::string_view key) {
    errors.add(place, fmt::format("'{}': a frame without a visualization takes no time if no step is due; write segment = "
                                  "\"60 Hz\", which it waits for",
                                  key));
  };
  if (programmed.visualization.ns == 0) return refuse(timing.place("visualization"), "visualization");
  if (programmed.dropped_visualization > 0) return refuse(timing.place("dropped_visualization"), "dropped_visualization");
  const std::vector<Table> entries = timing.tables("changes");
  for (std::size_t i = 0; i < programmed.changes.size(); ++i) {
    if (programmed.changes[i].visualization == Duration{0})
      return refuse(entries[i].place("visualization"), "visualization");
  }
}

/// A loop that keeps up with real time. [scene] says how much a step simulates.
void read_accumulator(ScenarioReading& reading, const Table& timing) {
  Errors& errors = reading.errors;
  const std::size_t errors_before = errors.count();
  ProgrammedTiming& programmed = reading.scenario.timing.programmed;
  const Table scene = reading.section("scene");
  if (!reading.sound("scene") || reading.document.find("scene") == nullptr) return;  // it has its own error
  Accumulator& loop = programmed.accumulator.emplace();
  loop.step_rate = read_step_rate(scene, {0, 1});
  if (loop.step_rate.num == 0)
    return errors.add(scene.place("step_size"),
                      "[scene] has no 'step_size', which loop = \"accumulator\" needs to know when "
                      "a step is due; write step_size = \"60 Hz\"");
  const Duration size{instant_ns(loop.step_rate, 1)};
  if (timing.has("max_steps")) loop.max_steps = static_cast<int>(timing.integer("max_steps"));
  loop.jitter_fix = {static_cast<std::int64_t>(timing.number("jitter_fix") * static_cast<double>(size.ns))};
  loop.refresh_jitter = timing.duration("refresh_jitter");
  programmed.steps = {1};
  programmed.paced = timing.has("segment");
  Shares shares{.visualization = programmed.visualization};
  if (programmed.paced && !read_segment(timing, shares, errors)) return;
  if (programmed.paced) programmed.segment = shares.segment;
  if (timing.has("refresh_jitter") && (!programmed.paced || loop.refresh_jitter >= shares.segment_length()))
    errors.add(timing.place("refresh_jitter"),
               "'refresh_jitter' delays the frames that wait for a 'segment', by less than its "
               "length; write segment = \"60 Hz\", or a shorter time");
  read_timing_models(timing, programmed, errors);
  check_frames_take_time(timing, programmed, errors);
  check_load(timing, programmed, errors);
  if (!loop.max_steps) check_steps_beside(timing, programmed, size, errors);
  if (errors.count() > errors_before) return;
  const MeanTiming mean = mean_timing(programmed);
  const Duration frame = programmed.paced ? shares.segment_length() : Duration{std::llround(mean.segment_ns)};
  if (frame < kShortestSegment || frame > kLongestSegment)
    return errors.add(timing.place("step"), "'step': a frame, V + N s, is out of range; it must be between 10 us and 9 s");
  reading.scenario.scene.step_rate = loop.step_rate;
  reading.scenario.nominal = {.segment = frame,
                              .visualization = programmed.visualization,
                              .slot = size,
                              .step_run_time = *programmed.step,
                              .known = true};
}

void read_programmed(ScenarioReading& reading, const Table& timing) {
  TimingSpec& spec = reading.scenario.timing;
  ProgrammedTiming& programmed = spec.programmed;
  const std::string step_text = timing.text("step");
  spec.real_steps = step_text == "real";
  if (step_text != "fill" && !spec.real_steps) programmed.step = timing.duration("step");
  const auto order = std::find(std::begin(kOrders), std::end(kOrders), timing.text("order"));
  programmed.order = static_cast<SegmentOrder>(order - std::begin(kOrders));
  programmed.seed = reading.scenario.seed;
  read_visualization(reading, timing);
  if (timing.text("loop") == kAccumulator) return read_accumulator(reading, timing);
  programmed.paced = timing.boolean("paced");
  read_wake(timing, programmed, reading.errors);
  if (programmed.order == SegmentOrder::concurrent) {
    read_concurrent(reading, timing);
  } else {
    read_in_turn(reading, timing);
  }
}

/// Checks that 1 + drift * t stays above 0 for the whole run.
void check_drift(ScenarioReading& reading, const Table& timing) {
  const double drift = reading.scenario.timing.programmed.drift_per_s;
  const Table run = reading.section("run");
  if (drift >= 0 || !reading.scenario.nominal.known || !reading.sound("run") || !run.has("duration")) return;
  Errors of_read_run;
  const Duration duration = run.span("duration", reading.scenario.nominal, of_read_run);
  if (1 + drift * seconds(duration) > 0) return;
  reading.errors.add(timing.place("drift"),
                     fmt::format("'drift': {} leaves no run time after {:.6g} s of {:.6g} s; write a slower drift, or a "
                                 "shorter run",
                                 timing.text("drift"), -1 / drift, seconds(duration)));
}

}  // namespace

void read_timing(ScenarioReading& reading) {
  if (!reading.sound("timing") || reading.document.find("timing") == nullptr) return;
  const Table timing = reading.section("timing");
  if (timing.has("trace") && timing.has("foreign"))
    return reading.errors.add(timing.place("foreign"), "'foreign' does not go with 'trace'; remove one of them");
  if (timing.has("trace")) {
    read_trace(reading, timing);
  } else if (timing.has("foreign")) {
    read_foreign_timing(reading, timing);
  } else {
    read_programmed(reading, timing);
    check_drift(reading, timing);
  }
  if (timing.has("governor")) read_governor(reading, timing.table("governor"));
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& timing_fields() {
  static const std::vector<Field> rows{
      {.table = "timing", .key = "segment", .forms = kRate | kDuration,
       .meaning = "Rate or length T of the time segment (one visualization and its steps). Obligatory unless `step` is a "
                  "duration: then segments follow each other without a gap. 10 us to 9 s.",
       .kinds = kAnyOrder, .range = above(0), .example = "\"30 Hz\""},
      {.table = "timing", .key = "segment", .forms = kRate | kDuration,
       .meaning = "The refresh that each frame waits for: the next one after its work. Without it frames follow each other "
                  "without a gap. 10 us to 9 s.",
       .kinds = kAccumulator, .range = above(0), .example = "\"60 Hz\""},
      {.table = "timing", .key = "visualization", .forms = kWord | kWork | kDuration,
       .meaning = "Run time V of the visualization, the mean where it varies. On a wall clock nothing is done in it, unless "
                  "it is `render`: the tissue is drawn, however long that takes; or `burn`: the compute device is kept "
                  "busy. Under the virtual clock only V matters, so `render` needs it.",
       .words = "render", .kinds = kAnyLoop, .required = true, .range = between(0, kLongestRun_s),
       .example = "\"11.1 ms\""},
      {.table = "timing", .key = "picture", .forms = kInteger, .shape = Shape::list,
       .meaning = "Width and height, in pixels, of what `render` draws; [800, 600] if it is not given.",
       .kinds = kAnyLoop, .range = between(16, 8192), .example = "[800, 600]"},
      {.table = "timing", .key = "steps", .forms = kInteger, .shape = Shape::one_or_list,
       .meaning = "Steps N per segment; of several values one is drawn per segment.",
       .kinds = kInTurn, .required = true, .range = between(1, kMostSteps), .example = "15"},
      {.table = "timing", .key = "steps", .forms = kInteger,
       .meaning = "Mean steps per segment, which gives the `step`. Write one of the two.",
       .kinds = "concurrent", .range = between(1, kMostSteps), .example = "15"},
      {.table = "timing", .key = "step", .forms = kWord | kDuration, .default_toml = "\"fill\"",
       .meaning = "Run time s of a step, the mean where it varies. `fill`: (T - V) / N. `real`: on a wall clock what the "
                  "solver really takes; `fill` under the virtual clock.",
       .words = "fill|real", .kinds = kInTurn, .range = above(0, kLongestRun_s)},
      {.table = "timing", .key = "step", .forms = kWord | kDuration, .default_toml = "\"fill\"",
       .meaning = "Run time s of a step, the mean where it varies. `fill`: computed from `steps`.",
       .words = "fill", .kinds = "concurrent", .range = above(0, kLongestRun_s)},
      {.table = "timing", .key = "step", .forms = kDuration,
       .meaning = "Run time s of a step, the mean where it varies.",
       .kinds = kAccumulator, .required = true, .range = above(0, kLongestRun_s), .example = "\"1 ms\""},
      {.table = "timing", .key = "max_steps", .forms = kInteger,
       .meaning = "The most steps of a frame; of more that are due the oldest are dropped, with their simulated time.",
       .kinds = kAccumulator, .range = between(1, kMostSteps), .example = "8"},
      {.table = "timing", .key = "jitter_fix", .forms = kNumber, .default_toml = "0",
       .meaning = "Godot's `physics_jitter_fix`: a step may run by this share of its size before or after it is due, if "
                  "frames then have as many steps as before.",
       .kinds = kAccumulator, .range = between(0, 1), .example = "0.5"},
      {.table = "timing", .key = "refresh_jitter", .forms = kDuration, .default_toml = "\"0 ms\"",
       .meaning = "With `segment`: a frame begins later than its refresh by up to this, all values equally likely.",
       .kinds = kAccumulator, .range = between(0, 9), .example = "\"0.1 ms\""},
      {.table = "timing", .key = "order", .forms = kWord, .default_toml = "\"visualization-first\"",
       .meaning =
           "What opens a segment. `steps-first` needs a lead of V. `concurrent`: the visualization has a lane of its own "
           "and stops no step; a segment lasts from one visualization's begin to the next's.",
       .words = kAnyOrder, .kinds = kAnyOrder},
      {.table = "timing", .key = "order", .forms = kWord, .default_toml = "\"steps-first\"",
       .meaning = "What a frame begins with.",
       .words = kInTurn, .kinds = kAccumulator},
      {.table = "timing", .key = "paced", .forms = kBoolean, .default_toml = "false",
       .meaning =
           "Where anything varies: segments still wait for the grid of `segment`, and idle until then. (`concurrent`: "
           "visualizations do.)",
       .kinds = kAnyOrder},
      {.table = "timing", .key = "wake", .forms = kWord, .default_toml = "\"catch-up\"",
       .meaning = "`paced`, after a segment that took longer than T: `catch-up`: the next ones follow without idle time; "
                  "`absolute-grid`: at the next tick of the grid, the missed ones are left out; `from-last-update`: T after "
                  "the start of the segment before, or at once if that is past.",
       .words = "catch-up|absolute-grid|from-last-update", .kinds = kAnyOrder},
      {.table = "timing", .key = "loop", .forms = kWord, .default_toml = "\"segments\"",
       .meaning = "`accumulator`: a game's loop. Each frame runs the steps of [scene] `step_size` that are due then.",
       .words = "segments|accumulator", .kinds = kAnyLoop},
      {.table = "timing", .key = "trace", .forms = kFile,
       .meaning =
           "A recording to replay: timing.csv (segment,kind,index,begin_ns,end_ns), or a profiler's file, with `roles` if "
           "these cannot be guessed. Then [timing] holds nothing else but `roles`, `repeat` and `governor`.",
       .example = "\"recorded/x.csv\""},
      {.table = "timing", .key = "roles", .forms = kTable,
       .meaning = "Which names of a profiler's file are what: the options of `evenstep import`.",
       .kinds = "trace"},
      {.table = "timing", .key = "repeat", .forms = kInteger, .default_toml = "1",
       .meaning = "How often the recording is played, each time following on the last without a gap.",
       .kinds = "trace", .range = between(1, 1'000'000)},
      {.table = "timing", .key = "foreign", .forms = kTable,
       .meaning = "A source that is not evenstep's own; then [timing] holds nothing else but `governor`."},
      {.table = "timing.roles", .key = "segment", .forms = kText, .default_toml = "\"\"",
       .meaning = "Names that begin a segment, as an extended regular expression; without it, visualizations do."},
      {.table = "timing.roles", .key = "visualization", .forms = kText, .default_toml = "\"\"",
       .meaning = "Names that are visualizations."},
      {.table = "timing.roles", .key = "step", .forms = kText, .default_toml = "\"\"", .meaning = "Names that are steps."},
      {.table = "timing.roles", .key = "step_begin", .forms = kText, .default_toml = "\"\"",
       .meaning = "Names that a step of several parts begins with; without it, each part is a step."},
      {.table = "timing.roles", .key = "preset", .forms = kWord,
       .meaning = "The names that this engine gives to those that are not given.",
       .words = "unity|godot|unreal|mujoco|pytorch|isaac", .example = "\"unity\""},
      {.table = "timing.roles", .key = "process", .forms = kText, .default_toml = "\"\"",
       .meaning = "If several processes have such names: the one to use."},
      {.table = "timing.roles", .key = "steps", .forms = kInteger, .default_toml = "0",
       .meaning = "For a recording of pictures: how many steps follow each of them.",
       .range = between(0, 10'000)},
      {.table = "timing.roles", .key = "step_time", .forms = kDuration,
       .meaning = "How long each of these steps is.",
       .range = above(0, kLongestRun_s), .example = "\"1.2 ms\""},
      {.table = "timing.roles", .key = "format", .forms = kWord,
       .meaning = "The format, if the begin of the file does not tell.",
       .words = "sqlite|capframex|chrome-json|presentmon|frame-csv|csv", .example = "\"presentmon\""},
      {.table = "timing.roles", .key = "header", .forms = kInteger, .default_toml = "0",
       .meaning = "For a CSV file: the line that names its columns, if its cells do not tell.",
       .range = between(0, 100'000)},
      {.table = "timing.roles", .key = "name", .forms = kText, .default_toml = "\"\"",
       .meaning = "For a CSV file with other columns: the column with the name."},
      {.table = "timing.roles", .key = "begin", .forms = kText, .default_toml = "\"\"",
       .meaning = "The column with the begin."},
      {.table = "timing.roles", .key = "end", .forms = kText, .default_toml = "\"\"", .meaning = "The column with the end."},
      {.table = "timing.roles", .key = "duration", .forms = kText, .default_toml = "\"\"",
       .meaning = "In place of `end`: the column with the length."},
      {.table = "timing.roles", .key = "unit", .forms = kWord,
       .meaning = "The unit of these columns.",
       .words = "ns|us|ms|s", .example = "\"ms\""},
  };
  static const std::vector<Field> all =
      joined(joined(joined(joined(rows, library_rows("timing", "")), timing_model_fields()), governor_fields()),
             foreign_rows("timing.foreign", ""));
  return all;
}
// clang-format on

}  // namespace evenstep::internal
