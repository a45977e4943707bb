// [run]
#include <fmt/format.h>

#include <algorithm>

#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {

void read_strategies(ScenarioReading& reading) {
  if (!reading.sound("run")) return;
  const Table run = reading.section("run");
  Scenario& scenario = reading.scenario;
  // The field table allows no other names.
  const auto kind_named = [](const std::string& name) { return strategy_named(name)->kind; };
  for (const Value& name : run.at("strategies").list) {
    const StrategyKind kind = kind_named(name.text);
    if (std::find(scenario.strategies.begin(), scenario.strategies.end(), kind) == scenario.strategies.end()) {
      scenario.strategies.push_back(kind);
    } else {
      reading.errors.add(name.place, fmt::format("'strategies' names \"{}\" twice", name.text));
    }
  }
  if (scenario.strategies.empty()) reading.errors.add(run.place("strategies"), "'strategies' is empty; name at least one");
  scenario.live = kind_named(run.text("live"));
  scenario.seed = static_cast<std::uint64_t>(run.integer("seed"));
  scenario.keep_rows = run.text("keep") == "all";
}

namespace {

/// How long a run of the whole recording is; a governor makes it shorter or longer.
Duration length_of_trace(const TimingSpec& timing) {
  if (timing.trace.empty() || !timing.governor) return replay_duration(timing.trace);
  const auto governed = make_governed_replay(timing.trace, *timing.governor);
  std::vector<SegmentTiming> segments;
  for (SegmentTiming segment; governed->next(segment);) segments.push_back(segment);
  return std::min(replay_duration(segments), Duration{1'000'000'000'000'000});  // 1e6 s, as long as any run may be
}

}  // namespace

void read_run(ScenarioReading& reading) {
  if (!reading.sound("run")) return;
  const Table run = reading.section("run");
  Scenario& scenario = reading.scenario;
  const bool has_trace = !scenario.timing.trace.empty();
  const Duration trace_length = length_of_trace(scenario.timing);

  if (run.has("duration")) {
    scenario.run_duration = run.span("duration", scenario.nominal, reading.errors);
    if (has_trace && scenario.run_duration > trace_length) {
      reading.errors.add(run.place("duration"),
                         scenario.timing.source
                             ? fmt::format("'duration': the timing source '{}' ends at {}; run at most so long",
                                           scenario.timing.source->name, in_ms(trace_length))
                             : fmt::format("'duration': the trace ends at {}; run at most so long, or leave 'duration' out",
                                           in_ms(trace_length)));
    }
  } else if (has_trace) {
    scenario.run_duration = trace_length;
  } else if (reading.document.find("timing") == nullptr || reading.document.find("timing")->find("trace") == nullptr) {
    reading.errors.add(run.place("duration"), "[run] has no 'duration'; write duration = \"4 s\"");
    return;
  }
  if (scenario.nominal.known && scenario.nominal.slot.ns > 0) {
    const std::int64_t steps = scenario.run_duration.ns / scenario.nominal.slot.ns;
    if (steps > kMostRunSteps)
      reading.errors.add(run.place("duration"),
                         fmt::format("'duration': this is {} steps, and a run has at most {}; run for "
                                     "{} at most",
                                     steps, kMostRunSteps, in_ms(scenario.nominal.slot * kMostRunSteps)));
  }
  if (run.has("interrupt")) scenario.interrupt = run.span("interrupt", scenario.nominal, reading.errors);
  if (scenario.nominal.known && scenario.interrupt && *scenario.interrupt >= scenario.run_duration) {
    reading.errors.add(run.place("interrupt"),
                       fmt::format("'interrupt': the run has ended by {}; interrupt it earlier, or run longer",
                                   in_ms(scenario.run_duration)));
  }
  scenario.warmup = run.span("warmup", scenario.nominal, reading.errors);
  if (scenario.nominal.known && scenario.warmup >= scenario.run_duration) {
    reading.errors.add(run.place("warmup"), fmt::format("'warmup': {} of {} leave nothing to judge", in_ms(scenario.warmup),
                                                        in_ms(scenario.run_duration)));
  }
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& run_fields() {
  static const std::vector<Field> rows{
      {.table = "run", .key = "duration", .forms = kSpan,
       .meaning = "Real time to run. Obligatory, except with a trace: then all of it.",
       .range = above(0, kLongestRun_s), .example = "\"4 s\""},
      {.table = "run", .key = "warmup", .forms = kSpan, .default_toml = "\"0 s\"",
       .meaning = "Real time at the start that is not judged.",
       .range = between(0, kLongestRun_s), .example = "\"8 segments\""},
      {.table = "run", .key = "interrupt", .forms = kSpan,
       .meaning = "A signal (SIGINT, SIGTERM, a hang-up) comes at this time and ends the run within 20 ms. Default: none. "
                  "Virtual clock only.",
       .range = between(0, kLongestRun_s), .example = "\"1 s\""},
      {.table = "run", .key = "faults_off", .forms = kText, .shape = Shape::list, .default_toml = "[]",
       .meaning = "Programmed faults that are left out, by where they are written: `timing.hitch`, "
                  "`device.left.faults.2` (counted from 0). A swarm writes it (docs/timings/sweep.md).",
       .example = "[\"timing.hitch\"]"},
      {.table = "run", .key = "seed", .forms = kInteger, .default_toml = "1",
       .meaning = "Seed of everything that is drawn at random.",
       .range = at_least(0)},
      {.table = "run", .key = "strategies", .forms = kWord, .shape = Shape::list,
       .default_toml = "[\"ideal\", \"direct\", \"paper\", \"phase_locked\"]",
       .meaning = "Run side by side over the same timing, each with a solver of its own.",
       .words = strategy_words()},
      {.table = "run", .key = "live", .forms = kWord, .default_toml = "\"phase_locked\"",
       .meaning = "The strategy that drives the device on a wall clock. (Not `ideal`: it would have to know the hand's "
                  "motion beforehand.)",
       .words = "direct|paper|phase_locked|clocked"},
      {.table = "run", .key = "keep", .forms = kWord, .default_toml = "\"all\"",
       .meaning = "`summary`: series.csv has the bins only and there is no events.bin: for runs of many minutes.",
       .words = "all|summary"},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
