// [timing]
#include <fmt/format.h>

#include <algorithm>

#include "evenstep/harness/timing_csv.h"
#include "load.h"
#include "rational.h"
#include "sections.h"

namespace evenstep::internal {
namespace {

constexpr __int128 kNsPerSecond = 1'000'000'000;
// From 10 us, every product below stays in 128 bits (at most 1e9 steps in a list); up to 9 s, a whole number of ns is an
// exact rate (kMostRateDen).
constexpr Duration kShortestSegment{10'000}, kLongestSegment{kMostRateDen};
constexpr std::size_t kMostStepCounts = 1000;

Duration floor_ns(__int128 num, __int128 den) { return {static_cast<std::int64_t>(num / den)}; }

/// Exact means over a recording.
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
  scenario.scene.step_rate = reduced_rate(steps * kNsPerSecond, end_ns);
}

void read_trace(ScenarioReading& reading, const Table& timing) {
  const Value path = timing.at("trace");
  TimingSpec& spec = reading.scenario.timing;
  spec.trace_file = path_from(path);
  TimingCsv csv = read_timing_csv(spec.trace_file);
  for (const Diagnostic& error : csv.errors) {
    if (error.line == 0) {
      reading.errors.add(path.place, fmt::format("'trace': '{}' {}", error.file, error.message));
    } else {
      reading.errors.add({error.file, error.line, error.column}, error.message);
    }
  }
  if (!csv.errors.empty()) return;
  const bool any_step =
      std::any_of(csv.segments.begin(), csv.segments.end(), [](const SegmentTiming& s) { return !s.steps.empty(); });
  if (!any_step || csv.segments.back().end.ns <= 0) {
    reading.errors.add(path.place, fmt::format("'trace': '{}' holds no step, so there is nothing to run", spec.trace_file));
    return;
  }
  spec.paced_by_segment = false;
  spec.trace = std::move(csv.segments);
  set_nominal_of_trace(reading.scenario);
}

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

Shares read_shares(const Table& timing, ProgrammedTiming& programmed, Errors& errors) {
  Shares shares;
  const Value steps = timing.at("steps");
  programmed.steps.clear();
  if (steps.is(Value::Kind::integer)) programmed.steps.push_back(static_cast<int>(steps.integer));
  for (const Value& count : steps.list) programmed.steps.push_back(static_cast<int>(count.integer));
  if (programmed.steps.size() > kMostStepCounts)
    errors.add(steps.place, fmt::format("'steps' lists more than {} values", kMostStepCounts));
  for (const int count : programmed.steps) shares.sum += count;
  shares.count = static_cast<__int128>(programmed.steps.size());
  shares.visualization = timing.duration("visualization");
  return shares;
}

/// False with an error where there is no segment to speak of.
bool read_segment(const Table& timing, Shares& shares, Errors& errors) {
  const std::string text = timing.text("segment");
  const Parsed<Rate> rate = parse_rate(text);
  const Duration length = rate.ok() ? Duration{instant_ns(rate.value, 1)} : parse_duration(text).value;
  if (length < kShortestSegment || length > kLongestSegment) {
    errors.add(timing.place("segment"),
               fmt::format("'segment': \"{}\" is out of range; it must be between 10 us and 9 s", text));
    return false;
  }
  shares.segment = rate.ok() ? rate.value : reduced_rate(kNsPerSecond, length.ns);
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

void read_programmed(ScenarioReading& reading, const Table& timing) {
  Errors& errors = reading.errors;
  const std::size_t errors_before = errors.count();
  TimingSpec& spec = reading.scenario.timing;
  ProgrammedTiming& programmed = spec.programmed;
  Shares shares = read_shares(timing, programmed, errors);

  const std::string step_text = timing.text("step");
  spec.real_steps = step_text == "real";
  if (step_text != "fill" && !spec.real_steps) programmed.step = timing.duration("step");
  spec.paced_by_segment = timing.has("segment");
  if (spec.paced_by_segment) {
    if (!read_segment(timing, shares, errors)) return;
  } else if (programmed.step) {
    if (!join_segment(timing, shares, *programmed.step, errors)) return;
  } else {
    errors.add(timing.place("segment"),
               fmt::format("[timing] has no 'segment', which step = \"{}\" needs; write segment = \"30 Hz\"", step_text));
    return;
  }
  if (programmed.step && spec.paced_by_segment) check_fixed_step(timing, shares, *programmed.step, errors);
  const Duration step = programmed.step ? *programmed.step : fill(timing, shares, errors);
  if (errors.count() > errors_before) return;

  programmed.segment = shares.segment;
  programmed.visualization = shares.visualization;
  programmed.steps_first = timing.text("order") == "steps-first";
  const Table jitter = timing.table("jitter");
  if (jitter.has("visualization")) programmed.visualization_variation = jitter.lognormal("visualization");
  if (jitter.has("step")) programmed.step_variation = jitter.lognormal("step");
  programmed.seed = reading.scenario.seed;

  const Rate slots = reduced_rate(shares.segment.num * shares.sum, shares.segment.den * shares.count);
  reading.scenario.scene.step_rate = slots;
  reading.scenario.nominal = {shares.segment_length(), shares.visualization, {instant_ns(slots, 1)}, step, true};
}

}  // namespace

void read_timing(ScenarioReading& reading) {
  if (!reading.sound("timing") || reading.document.find("timing") == nullptr) return;
  const Table timing = reading.section("timing");
  if (timing.has("trace")) return read_trace(reading, timing);
  read_programmed(reading, timing);
}

}  // namespace evenstep::internal
