#include "timing_models.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

void read_regimes(const Table& regimes, ProgrammedTiming& timing, Errors& errors) {
  timing.regimes = Regimes{regimes.number("factor"), regimes.segments("mean_length"), regimes.si("slow_share")};
  if (shortest_mean_stay(*timing.regimes) >= 1) return;
  errors.add(
      regimes.place(regimes.has("slow_share") ? "slow_share" : "mean_length"),
      fmt::format("'slow_share': of 2 mean_length, {:.6g} segments, {:.6g} would be at the level that is rarer, and a "
                  "stay has at least 1; write a share nearer to 50 %, or a longer mean_length",
                  2 * timing.regimes->mean_length, shortest_mean_stay(*timing.regimes)));
}

void read_hitch(const Table& hitch, ProgrammedTiming& timing, Errors& errors) {
  timing.hitch = Hitch{hitch.duration("every"), hitch.duration("visualization")};
  if (timing.hitch->visualization < timing.hitch->every) return;
  errors.add(
      hitch.place("visualization"),
      fmt::format("'visualization': a hitch of {} every {} leaves no time for anything else; write a shorter one, or a "
                  "longer 'every'",
                  in_ms(timing.hitch->visualization), in_ms(timing.hitch->every)));
}

void read_disturbed(const Table& table, ProgrammedTiming& timing, Errors& errors) {
  timing.disturbed = Disturbed{RealTime{table.duration("from").ns}, RealTime{table.duration("to").ns}};
  if (timing.disturbed->from < timing.disturbed->to) return;
  errors.add(table.place("to"), "'to': must be after 'from'");
}

void read_additions(const Table& table, ProgrammedTiming& timing, Errors& errors) {
  if (table.has("spikes")) {
    const Table spikes = table.table("spikes");
    timing.spikes = Spikes{in_Hz(spikes.rate("rate")), spikes.duration("cost")};
  }
  if (table.has("preemption")) {
    const Table preemption = table.table("preemption");
    const ParetoText cost = preemption.pareto("cost");
    timing.preemption = Preemption{in_Hz(preemption.rate("rate")), cost.least, cost.most, preemption.number("tail")};
  }
  if (table.has("regimes")) read_regimes(table.table("regimes"), timing, errors);
  if (table.has("hitch")) read_hitch(table.table("hitch"), timing, errors);
  if (table.has("disturbed")) read_disturbed(table.table("disturbed"), timing, errors);
}

TimingChange read_change(const Table& entry, const ProgrammedTiming& timing, Errors& errors) {
  TimingChange change;
  change.at = RealTime{entry.duration("at").ns};
  if (entry.has("visualization")) change.visualization = entry.duration("visualization");
  if (entry.has("step")) change.step = entry.duration("step");
  if (entry.has("steps")) change.steps = read_step_counts(entry, errors);
  if (!change.visualization && !change.step && change.steps.empty())
    errors.add(entry.place("at"), "'changes': this entry changes nothing; write visualization, step or steps");
  if (timing.accumulator && !change.steps.empty())
    errors.add(entry.place("steps"),
               "'steps' cannot change with loop = \"accumulator\", where what is due decides; remove it");
  if (timing.order != SegmentOrder::concurrent) return change;
  if (!change.steps.empty())
    errors.add(entry.place("steps"),
               "'steps' cannot change with order = \"concurrent\", where the step decides; write step");
  if (change.visualization == Duration{0})
    errors.add(entry.place("visualization"), "'visualization': order = \"concurrent\" needs one; write a longer time");
  return change;
}

void read_changes(const Table& table, ProgrammedTiming& timing, Errors& errors) {
  for (const Table& entry : table.tables("changes")) {
    timing.changes.push_back(read_change(entry, timing, errors));
    if (timing.changes.size() < 2) continue;
    const TimingChange &earlier = *(timing.changes.end() - 2), &later = timing.changes.back();
    if (later.at > earlier.at) continue;
    errors.add(entry.place("at"), fmt::format("'at': {} is not after the change before it, at {}; sort the entries",
                                              in_ms({later.at.ns}), in_ms({earlier.at.ns})));
  }
}

/// Checks that there is a visualization, at the beginning or after a change, if a model is about visualizations.
void check_visualization_exists(const Table& table, const ProgrammedTiming& timing, Errors& errors) {
  const bool later = std::any_of(timing.changes.begin(), timing.changes.end(), [](const TimingChange& change) {
    return change.visualization.value_or(Duration{0}).ns > 0;
  });
  if (timing.visualization.ns > 0 || later) return;
  for (const char* key : {"first_step", "regimes", "dropped_visualization", "merged_visualization"}) {
    const bool says_nothing = key == std::string_view("first_step") && timing.first_step == 0;
    if (!table.has(key) || says_nothing) continue;
    errors.add(table.place(key), fmt::format("'{}' means nothing with visualization = \"0 s\"; remove it", key));
  }
}

void check_shares(const Table& table, const ProgrammedTiming& timing, Errors& errors) {
  if (timing.dropped_visualization + timing.merged_visualization > 1) {
    errors.add(table.place("merged_visualization"),
               fmt::format("'merged_visualization': {} and {} dropped are more than all segments; together at most 100 %",
                           table.text("merged_visualization"), table.text("dropped_visualization")));
  }
  if (timing.order == SegmentOrder::concurrent && timing.dropped_visualization > 0 && !timing.paced) {
    errors.add(
        table.place("dropped_visualization"),
        "'dropped_visualization': with order = \"concurrent\" a segment without one has no length; write paced = true "
        "and segment = \"30 Hz\"");
  }
}

/// The mean work of a segment; only that of the visualization if steps do not wait for it.
double work_ns(const ProgrammedTiming& timing) { return mean_timing(timing).segment_ns; }

}  // namespace

std::vector<int> read_step_counts(const Table& table, Errors& errors) {
  const Value steps = table.at("steps");
  std::vector<int> counts;
  if (steps.is(Value::Kind::integer)) counts.push_back(static_cast<int>(steps.integer));
  for (const Value& count : steps.list) counts.push_back(static_cast<int>(count.integer));
  if (counts.size() > kMostStepCounts)
    errors.add(steps.place, fmt::format("'steps' lists more than {} values", kMostStepCounts));
  return counts;
}

void read_timing_models(const Table& table, ProgrammedTiming& timing, Errors& errors) {
  const Table jitter = table.table("jitter");
  const auto read_jitter = [&](const char* key, JitterLaw& law, double& variation) {
    if (!jitter.has(key)) return;
    const JitterText text = jitter.jitter(key);
    law = text.law;
    variation = text.variation;
  };
  read_jitter("visualization", timing.visualization_law, timing.visualization_variation);
  read_jitter("step", timing.step_law, timing.step_variation);
  if (timing.order == SegmentOrder::concurrent) {
    timing.slowdown = table.number("slowdown");
  } else {
    timing.first_step = table.si("first_step");
  }
  timing.drift_per_s = table.si("drift");
  timing.dropped_visualization = table.si("dropped_visualization");
  timing.merged_visualization = table.si("merged_visualization");
  read_additions(table, timing, errors);
  read_changes(table, timing, errors);
  check_visualization_exists(table, timing, errors);
  check_shares(table, timing, errors);
}

void check_pace(const Table& table, const ProgrammedTiming& timing, Errors& errors) {
  if (!timing.paced || is_periodic(timing)) return;
  // The means of "fill" are rounded to ns, so the sum may exceed the segment by up to N / 2 ns.
  const double segment_ns = 1e9 / in_Hz(timing.segment), rounding_ns = 0.5 * mean_timing(timing).steps + 1;
  const auto refuse = [&](std::string_view key, const Place& place, double work) {
    errors.add(place,
               fmt::format("'{}': the mean work of a segment, {:.6g} ms, is longer than the segment of {:.6g} ms, so a "
                           "paced schedule never catches up; make 'step' or 'visualization' shorter, or leave "
                           "'paced' out",
                           key, work * 1e-6, segment_ns * 1e-6));
  };
  if (work_ns(timing) > segment_ns + rounding_ns) return refuse("paced", table.place("paced"), work_ns(timing));
  ProgrammedTiming changed = timing;
  changed.step = starting_step(timing);
  const std::vector<Table> entries = table.tables("changes");
  for (std::size_t i = 0; i < timing.changes.size(); ++i) {
    const TimingChange& change = timing.changes[i];
    if (change.visualization) changed.visualization = *change.visualization;
    if (change.step) changed.step = change.step;
    if (!change.steps.empty()) changed.steps = change.steps;
    if (work_ns(changed) > segment_ns + rounding_ns) return refuse("changes", entries[i].place("at"), work_ns(changed));
  }
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& timing_model_fields() {
  static const std::vector<Field> rows{
      {.table = "timing", .key = "jitter", .forms = kTable,
       .meaning =
           "Random run times. With this or any key below, segments follow each other without a gap, unless `paced` is set.",
       .kinds = kAnyLoop},
      {.table = "timing", .key = "first_step", .forms = kQuantity, .default_toml = "\"0 %\"",
       .meaning = "The first step after a visualization takes longer by this share.",
       .kinds = kNoLanes, .dimension = D::ratio, .range = between(0, 100), .example = "\"+20 %\""},
      {.table = "timing", .key = "slowdown", .forms = kNumber, .default_toml = "1",
       .meaning = "Factor on the length of a step that begins while a visualization runs.",
       .kinds = "concurrent", .range = between(1, 100), .example = "1.5"},
      {.table = "timing", .key = "spikes", .forms = kTable,
       .meaning = "Steps are hit now and then, for the same time each (a scheduler's tick).",
       .kinds = kAnyLoop},
      {.table = "timing", .key = "preemption", .forms = kTable,
       .meaning = "Steps and visualizations are interrupted now and then, for times with a long tail.",
       .kinds = kAnyLoop},
      {.table = "timing", .key = "regimes", .forms = kTable,
       .meaning = "The visualization jumps between two lengths, each of which lasts a while. The mean stays V.",
       .kinds = kAnyLoop},
      {.table = "timing", .key = "hitch", .forms = kTable,
       .meaning = "A long visualization again and again: another tab, a garbage collector, a texture that is loaded.",
       .kinds = kAnyLoop},
      {.table = "timing", .key = "disturbed", .forms = kTable,
       .meaning =
           "When there are spikes, pre-emption, regimes, hitches, dropped and merged visualizations: only in segments "
           "that begin then. Default: in all.",
       .kinds = kAnyLoop},
      {.table = "timing", .key = "drift", .forms = kQuantity, .default_toml = "\"0 %/s\"",
       .meaning = "V and s of a segment are those of t = 0 times 1 + drift * its begin.",
       .kinds = kAnyLoop, .dimension = D::drift, .range = between(-10, 10), .example = "\"10 %/s\""},
      {.table = "timing", .key = "dropped_visualization", .forms = kQuantity, .default_toml = "\"0 %\"",
       .meaning = "Share of the segments without one: their steps follow at once.",
       .kinds = kAnyLoop, .dimension = D::ratio, .range = between(0, 1), .example = "\"2 %\""},
      {.table = "timing", .key = "merged_visualization", .forms = kQuantity, .default_toml = "\"0 %\"",
       .meaning = "Share of the segments with two in a row, 2 V.",
       .kinds = kAnyLoop, .dimension = D::ratio, .range = between(0, 1), .example = "\"2 %\""},
      {.table = "timing", .key = "changes", .forms = kTable, .shape = Shape::list,
       .meaning = "New values, each from the first segment on that begins at its time or later. `fill` keeps its step.",
       .kinds = kAnyLoop, .example = "[{ at = \"2 s\", visualization = \"22.2 ms\" }]"},
      {.table = "timing.jitter", .key = "visualization", .forms = kJitter,
       .meaning = "Log-normal with this coefficient of variation, or uniform: shorter or longer by up to this share. The "
                  "mean stays V.",
       .range = between(0, 1), .example = "\"lognormal 10 %\""},
      {.table = "timing.jitter", .key = "step", .forms = kJitter,
       .meaning = "The same for each step; the mean stays s.",
       .range = between(0, 1), .example = "\"lognormal 10 %\""},
      {.table = "timing.spikes", .key = "rate", .forms = kRate,
       .meaning = "Per second of step; a step of length d is hit with probability 1 - exp(-rate d), at most once.",
       .required = true, .range = above(0, 1e6), .example = "\"2 Hz\""},
      {.table = "timing.spikes", .key = "cost", .forms = kDuration,
       .meaning = "What a hit adds.",
       .required = true, .range = above(0, kLongestSpike_s), .example = "\"4 ms\""},
      {.table = "timing.preemption", .key = "rate", .forms = kRate,
       .meaning = "Per second of work; as for spikes, but visualizations are hit too.",
       .required = true, .range = above(0, 1e6), .example = "\"2 Hz\""},
      {.table = "timing.preemption", .key = "cost", .forms = kPareto,
       .meaning = "What a hit adds: Pareto distributed between these two.",
       .required = true, .range = above(0, kLongestSpike_s), .example = "\"pareto 3 ms cap 40 ms\""},
      {.table = "timing.preemption", .key = "tail", .forms = kNumber, .default_toml = "1.5",
       .meaning = "Tail index: P(cost > x) falls as x^-tail.",
       .range = between(0.1, 10)},
      {.table = "timing.regimes", .key = "factor", .forms = kNumber,
       .meaning = "Ratio of the longer to the shorter visualization.",
       .required = true, .range = between(1, 100), .example = "1.6"},
      {.table = "timing.regimes", .key = "mean_length", .forms = kSegments,
       .meaning = "How long each of them lasts on average (geometrically distributed); 2: a fair draw for each segment.",
       .required = true, .range = between(1, 1e6), .example = "\"8 segments\""},
      {.table = "timing.regimes", .key = "slow_share", .forms = kQuantity, .default_toml = "\"50 %\"",
       .meaning = "Share of the segments with the longer visualization. It lasts 2 slow_share mean_length segments on "
                  "average, the shorter one the rest of 2 mean_length; each lasts at least 1.",
       .dimension = D::ratio, .range = above(0, 0.999), .example = "\"30 %\""},
      {.table = "timing.hitch", .key = "every", .forms = kDuration,
       .meaning = "The first visualization that begins at or after each multiple of it.",
       .required = true, .range = above(0, kLongestRun_s), .example = "\"2 s\""},
      {.table = "timing.hitch", .key = "visualization", .forms = kDuration,
       .meaning = "V of these visualizations, shorter than `every`. Jitter and all else apply to them as to any other.",
       .required = true, .range = above(0, kLongestRun_s), .example = "\"20 ms\""},
      {.table = "timing.disturbed", .key = "from", .forms = kDuration,
       .meaning = "From the first segment on that begins at this time or later.",
       .required = true, .range = between(0, kLongestRun_s), .example = "\"2 s\""},
      {.table = "timing.disturbed", .key = "to", .forms = kDuration,
       .meaning = "Until the first segment that begins at this time or later; that one is not disturbed.",
       .required = true, .range = above(0, kLongestRun_s), .example = "\"4 s\""},
      {.table = "timing.changes", .key = "at", .forms = kDuration,
       .meaning = "Increasing from entry to entry.",
       .required = true, .range = between(0, kLongestRun_s), .example = "\"2 s\""},
      {.table = "timing.changes", .key = "visualization", .forms = kDuration,
       .meaning = "V from then on.",
       .range = between(0, kLongestRun_s), .example = "\"22.2 ms\""},
      {.table = "timing.changes", .key = "step", .forms = kDuration,
       .meaning = "s from then on.",
       .range = above(0, kLongestRun_s), .example = "\"1.5 ms\""},
      {.table = "timing.changes", .key = "steps", .forms = kInteger, .shape = Shape::one_or_list,
       .meaning = "N from then on. Not with `concurrent`: there `step` decides.",
       .range = between(1, kMostSteps), .example = "15"},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
