#include "recorded_timing.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/format/load.h"
#include "evenstep/recordings/recording.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/text/rational.h"

namespace evenstep::internal {
namespace {

/// Sets the nominal times to the exact means over a recording.
void set_nominal_of_trace(Scenario& scenario) {
  std::int64_t visualizations = 0, steps = 0, visualization_ns = 0, step_ns = 0, end_ns = 0;
  const std::vector<SegmentTiming>& trace = scenario.timing.trace;
  for (const SegmentTiming& segment : trace) {
    if (segment.visualization) {
      ++visualizations;
      visualization_ns += (segment.visualization->end - segment.visualization->begin).ns;
    }
    steps += static_cast<std::int64_t>(segment.steps.size());
    for (const Interval& step : segment.steps) step_ns += (step.end - step.begin).ns;
    end_ns = std::max(end_ns, segment.end.ns);
  }
  scenario.nominal.segment = {end_ns / static_cast<std::int64_t>(trace.size())};
  scenario.nominal.visualization = {visualizations == 0 ? 0 : visualization_ns / visualizations};
  scenario.nominal.slot = {end_ns / steps};
  scenario.nominal.step_run_time = {step_ns / steps};
  scenario.nominal.known = true;
  scenario.scene.step_rate = reduced_rate(__int128{steps} * 1'000'000'000, end_ns);
  if (const Duration size = usual_step_size(trace); size.ns > 0) {
    scenario.scene.step_rate = reduced_rate(1'000'000'000, size.ns);
    scenario.nominal.slot = size;
  }
}

/// What the names of a profiler's file are. Adds an error if they cannot be used.
RecordingOptions read_roles(const Table& table, Errors& errors) {
  RecordingOptions options;
  options.profile = {table.has("format") ? table.text("format") : "", {}, table.integer("header")};
  options.profile.columns = {table.text("name"),
                             table.text("begin"),
                             table.text("end"),
                             table.text("duration"),
                             "",
                             table.has("unit") ? table.text("unit") : ""};
  if (table.has("preset")) options.preset = table.text("preset");
  Roles& roles = options.roles;
  roles = {table.text("segment"),
           table.text("visualization"),
           table.text("step"),
           table.text("step_begin"),
           table.text("process"),
           table.integer("steps"),
           {}};
  if (table.has("step_time")) roles.step_time = table.duration("step_time");
  if ((roles.steps == 0) != (roles.step_time == Duration{}))
    errors.add(table.place("steps"), "'steps' and 'step_time' go together: so many steps, each so long");
  return options;
}

constexpr std::int64_t kMostPlayed = 10'000'000;  // segments and steps, as many as a timing.csv may have rows
constexpr std::int64_t kMostPlayed_ns = 1'000'000'000'000'000;

/// Plays a recording `times` times, one after the other. Adds an error if that is too long.
void repeat(std::vector<SegmentTiming>& trace, std::int64_t times, const Place& place, Errors& errors) {
  std::int64_t played = 0;
  RealTime end{0};
  for (const SegmentTiming& segment : trace) {
    played += 1 + static_cast<std::int64_t>(segment.steps.size());
    end = std::max(end, segment.end);
  }
  const std::int64_t most = std::min(kMostPlayed / played, kMostPlayed_ns / end.ns);
  if (times > 1 && times > most)
    return errors.add(place, fmt::format("'repeat': this recording can be played {} times at most: 10 million segments and "
                                         "steps, 1e6 s",
                                         std::max<std::int64_t>(most, 1)));
  const std::size_t once = trace.size();
  trace.reserve(once * static_cast<std::size_t>(times));
  for (std::int64_t n = 1; n < times; ++n) {
    const Duration by{n * end.ns};
    for (std::size_t k = 0; k < once; ++k) {
      SegmentTiming segment = trace[k];
      segment.index = static_cast<std::int64_t>(trace.size());
      segment.begin = segment.begin + by;
      segment.end = segment.end + by;
      if (segment.visualization)
        segment.visualization = Interval{segment.visualization->begin + by, segment.visualization->end + by};
      for (Interval& step : segment.steps) step = {step.begin + by, step.end + by};
      for (SimTime& t : segment.simulated) t.ns += by.ns;
      trace.push_back(std::move(segment));
    }
  }
}

/// Draws the timing of a run from a source of the program.
Result<std::vector<SegmentTiming>> draw(const Foreign& part, const TimingFactory& make, std::uint64_t seed, RealTime end) {
  try {
    const std::unique_ptr<StepTiming> source = make({part.name, part.options, seed});
    if (!source) return Failure(std::string("its factory returned nothing"));
    return draw_timing(*source, end);
  } catch (const std::exception& error) {
    return Failure(std::string(error.what()));
  }
}

/// How long the run is, which must be known before its segments are; empty, with an error, if that is not possible.
std::optional<Duration> length_of_run(ScenarioReading& reading) {
  const Table run = reading.section("run");
  if (!reading.sound("run")) return std::nullopt;
  const Result<Duration> length =
      run.has("duration") ? parse_duration(run.text("duration")) : Result<Duration>(Failure(std::string()));
  if (length) return *length;
  reading.errors.add(run.place("duration"),
                     "[timing] foreign is asked for as much as the run lasts; write duration = \"4 s\"");
  return std::nullopt;
}

}  // namespace

void read_trace(ScenarioReading& reading, const Table& timing) {
  const Value path = timing.at("trace");
  TimingSpec& spec = reading.scenario.timing;
  spec.trace_file = path_from(path);
  RecordingOptions options;
  if (timing.has("roles")) {
    options = read_roles(timing.table("roles"), reading.errors);
    if (is_timing_csv(spec.trace_file))
      reading.errors.add(timing.place("roles"),
                         fmt::format("'roles' are those of a profiler's file, and '{}' is a timing.csv; "
                                     "remove them",
                                     spec.trace_file));
  }
  Recording csv = read_recording(spec.trace_file, options, false, &spec.trace_damage);
  for (const Diagnostic& error : csv.error_or({})) {
    if (error.line == 0) {
      reading.errors.add(path.place, fmt::format("'trace': '{}' {}", error.file, error.message));
    } else {
      reading.errors.add({error.file, error.line, error.column}, error.message);
    }
  }
  if (!csv) return;
  const bool any_step = std::any_of(csv->begin(), csv->end(), [](const SegmentTiming& s) { return !s.steps.empty(); });
  if (!any_step || csv->back().end.ns <= 0) {
    reading.errors.add(path.place, fmt::format("'trace': '{}' holds no step, so there is nothing to run", spec.trace_file));
    return;
  }
  spec.trace = *std::move(csv);
  repeat(spec.trace, timing.integer("repeat"), timing.place("repeat"), reading.errors);
  set_nominal_of_trace(reading.scenario);
}

void read_foreign_timing(ScenarioReading& reading, const Table& timing) {
  TimingSpec& spec = reading.scenario.timing;
  Foreign part = read_foreign(reading, timing.table("foreign"));
  const TimingFactory make = maker_of("timing source", part, reading.registry.timings(), &Library::timing, reading.errors);
  const std::optional<Duration> length = length_of_run(reading);
  if (!make || !length) return;
  spec.source = part;
  auto drawn = draw(part, make, reading.scenario.seed, RealTime{length->ns});
  const auto again = draw(part, make, reading.scenario.seed, RealTime{length->ns});
  const auto refuse = [&](const std::string& why) {
    reading.errors.add(part.place, fmt::format("the timing source '{}': {}", part.name, why));
  };
  if (!drawn) return refuse(drawn.error());
  const std::int64_t differs = again ? first_unequal(*drawn, *again) : 0;
  if (differs >= 0)
    return refuse(
        fmt::format("segment {} is another one when it is asked again with the same seed; it must not depend on "
                    "anything but its options and the seed",
                    differs));
  spec.trace = *std::move(drawn);
  set_nominal_of_trace(reading.scenario);
}

}  // namespace evenstep::internal
