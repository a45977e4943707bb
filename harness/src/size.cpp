#include "evenstep/harness/size.h"

#include <algorithm>
#include <cmath>

#include "evenstep/harness/sizing.h"
#include "evenstep/harness/timing_csv.h"
#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/remap/step_cycle.h"
#include "evenstep/remap/step_windows.h"
#include "size_mend.h"

namespace evenstep {
namespace {

using internal::Mending;

/// What is sized: segments, and the devices and map parameters of a scenario.
struct Input {
  Scenario scenario;
  std::vector<SegmentTiming> segments;
};

std::vector<SegmentTiming> segments_of(const Scenario& scenario) {
  std::vector<SegmentTiming> segments;
  const std::unique_ptr<StepTiming> timing = make_timing(scenario);
  for (SegmentTiming segment; timing->next(segment) && segment.begin < RealTime{scenario.run_duration.ns};)
    segments.push_back(segment);
  return segments;
}

/// Steps that end within the run, as the maps see them.
void put_steps(const Input& input, std::vector<StepTimes>& steps) {
  const RealTime end{input.scenario.run_duration.ns};
  steps.clear();
  for (const SegmentTiming& segment : input.segments) {
    for (std::size_t i = 0; i < segment.steps.size() && segment.steps[i].end < end; ++i)
      steps.push_back({segment.steps[i].begin, segment.steps[i].end, segment.index, static_cast<std::int32_t>(i)});
  }
}

Duration longest_period(const std::vector<SamplingGrid>& devices) {
  Duration longest;
  for (const SamplingGrid& device : devices) longest = std::max(longest, period_ceil(device.rate));
  return longest;
}

template <class Step, class LatencyOf>
SizeWindows windows_of(std::span<const Step> steps, LatencyOf latency_of) {
  std::vector<Duration> latencies;
  for (const auto& [from, to] : step_windows(steps)) latencies.push_back(latency_of(steps.subspan(from, to - from)));
  if (latencies.empty()) return {};
  std::sort(latencies.begin(), latencies.end());
  const auto rank = [&](double share) {
    const double n = static_cast<double>(latencies.size());
    return latencies[static_cast<std::size_t>(std::max(std::ceil(share * n) - 1, 0.0))];
  };
  return {rank(0.5), rank(0.99), latencies.back(), static_cast<std::int64_t>(latencies.size())};
}

/// One input looked at from all sides.
class Sizer {
 public:
  Sizer(Input& input, const SizeOptions& options)
      : input_(input),
        options_(options),
        devices_(sampling_grids(input.scenario)),
        mending_(input.segments) {
    put_steps(input, steps_);
    if (steps_.size() > 1) {
      const Duration begins = steps_.back().begin - steps_.front().begin;
      slot_ = {begins.ns / static_cast<std::int64_t>(steps_.size() - 1)};
    }
  }

  void size(SizeRecord& record) {
    record.steps = static_cast<std::int64_t>(steps_.size());
    record.segments = static_cast<std::int64_t>(input_.segments.size());
    record.length = steps_.empty() ? Duration{} : steps_.back().end - steps_.front().begin;
    record.sampling_period = longest_period(devices_);
    record.interpolated = strictest_emission(input_.scenario) == Emission::linear;
    record.damping_N_s_per_m = options_.damping_N_s_per_m;
    record.held = bounds(false);
    if (record.interpolated) record.linear = bounds(true);
    for (const StrategyKind kind : {StrategyKind::paper, StrategyKind::phase_locked}) record.strategies.push_back(strategy(kind));
  }

 private:
  Duration sampling_term() const { return longest_period(devices_) - Duration{1}; }

  void close_loop(SizeNeed& need, bool linear) const {
    need.total_delay = need.latency + (linear ? Duration{} : Duration{slot_.ns / 2});
    const double held_s = seconds(longest_period(devices_)) / 2;
    need.stiffness_limit_N_per_m = options_.damping_N_s_per_m / (held_s + seconds(need.total_delay));
  }

  /// `least` finds a latency without the sampling term, and its culprit, in steps whose ends are when forces are due.
  template <class Least>
  SizeNeed bound(bool linear, Least least, SizeCulprit (Mending::*blame)(std::int64_t) const) {
    SizeNeed need;
    if (steps_.empty()) return need;
    put_steps(input_, steps_);
    if (linear) interpolate(steps_);
    const std::span<const StepTimes> steps(steps_);
    const auto found = least(steps);
    need.latency = found.latency + sampling_term();
    need.windows = windows_of(steps, [&](std::span<const StepTimes> part) { return least(part).latency + sampling_term(); });
    const auto last = static_cast<std::int64_t>(steps.size()) - 1;
    need.culprit = (mending_.*blame)(std::min(found.latency_culprit + (linear ? 1 : 0), last));
    need.culprit.mended_latency = need.latency;
    mending_.mended(need.culprit, [&] {
      put_steps(input_, steps_);
      if (linear) interpolate(steps_);
      need.culprit.mended_latency = least(std::span<const StepTimes>(steps_)).latency + sampling_term();
    });
    close_loop(need, linear);
    return need;
  }

  SizeBounds bounds(bool linear) {
    return {bound(linear, [](std::span<const StepTimes> steps) { return best_line(steps); }, &Mending::blame),
            bound(linear, [](std::span<const StepTimes> steps) { return least_path(steps); }, &Mending::blame_run_time)};
  }

  SizeStrategy strategy(StrategyKind kind) {
    const Emission emission = strictest_emission(input_.scenario);
    map_steps(input_.scenario, kind, input_.segments, mapped_);
    const std::span<const MappedStep> steps(mapped_);
    const LatencyBudget any = least_latency_any_phase(steps, devices_, emission);
    const LatencyBudget here = least_latency_this_phase(steps, devices_, emission);
    SizeStrategy out{name_of(kind)};
    out.lead = any.lead;
    out.latency_this_phase = here.latency;
    out.lead_this_phase = here.lead;
    out.lead_culprit = any.lead_culprit;
    out.interaction_capacity = static_cast<std::int64_t>(any.interaction_capacity);
    out.force_capacity = static_cast<std::int64_t>(any.force_capacity);
    SizeNeed& need = out.any_phase;
    need.latency = any.latency;
    need.windows = windows_of(steps, [&](std::span<const MappedStep> part) {
      return least_needs_any_phase(part, devices_, emission).latency;
    });
    close_loop(need, emission == Emission::linear);
    if (any.latency_culprit < 0) return out;
    need.culprit = mending_.blame(any.latency_culprit);
    need.culprit.mended_latency = need.latency;
    mending_.mended(need.culprit, [&] {
      map_steps(input_.scenario, kind, input_.segments, mapped_);
      need.culprit.mended_latency = least_needs_any_phase(mapped_, devices_, emission).latency;
    });
    return out;
  }

  Input& input_;
  const SizeOptions& options_;
  std::vector<SamplingGrid> devices_;
  Mending mending_;
  std::vector<StepTimes> steps_;        // storage for what is looked at
  std::vector<MappedStep> mapped_;      // likewise
  Duration slot_;                       // mean distance of the steps' begins
};

SizeCycle in_record(const StepCycle& cycle) {
  const std::size_t first = cycle.boundaries.empty() ? 0 : cycle.boundaries.front();
  return {.found = cycle.found,
          .reason = cycle.reason,
          .segments = cycle.segments,
          .steps_per_segment = cycle.steps_per_segment,
          .least_steps = cycle.least_steps,
          .most_steps = cycle.most_steps,
          .first_boundary = static_cast<std::int64_t>(first),
          .period = cycle.period,
          .pause = cycle.pause,
          .longest_gap = cycle.longest_gap,
          .period_variation = cycle.period_variation,
          .confidence = cycle.confidence,
          .regularity = cycle.regularity};
}

/// The same steps in segments that begin with the steps named; what comes before the first is left out.
std::vector<SegmentTiming> cut_at(const std::vector<StepTimes>& steps, const std::vector<std::size_t>& boundaries) {
  std::vector<SegmentTiming> segments;
  for (std::size_t k = 0; k < boundaries.size(); ++k) {
    const std::size_t end = k + 1 < boundaries.size() ? boundaries[k + 1] : steps.size();
    SegmentTiming segment;
    segment.index = static_cast<std::int64_t>(k);
    segment.begin = steps[boundaries[k]].begin;
    for (std::size_t n = boundaries[k]; n < end; ++n) segment.steps.push_back({steps[n].begin, steps[n].end});
    segment.end = segment.steps.back().end;
    segments.push_back(std::move(segment));
  }
  return segments;
}

std::vector<StepTimes> all_steps(const std::vector<SegmentTiming>& segments) {
  std::vector<StepTimes> steps;
  for (const SegmentTiming& segment : segments) {
    for (const Interval& step : segment.steps) steps.push_back({step.begin, step.end, segment.index, 0});
  }
  return steps;
}

/// Segments for a list that has none. A list that begins in the middle of a cycle loses the steps before the first pause.
void find_segments(Input& input, SizeRecord& record) {
  const std::vector<StepTimes> steps = all_steps(input.segments);
  const StepCycle cycle = find_cycle(steps);
  record.cycle = in_record(cycle);
  const bool given = input.segments.size() > 1 || input.segments.front().visualization.has_value();
  if (given) return;
  std::vector<std::size_t> boundaries = cycle.boundaries;
  record.segments_from = "cycle";
  if (!cycle.found) {
    record.segments_from = "step";
    boundaries.resize(steps.size());
    for (std::size_t n = 0; n < steps.size(); ++n) boundaries[n] = n;
  } else if (static_cast<std::int64_t>(boundaries.front()) == cycle.steps_per_segment) {
    boundaries.insert(boundaries.begin(), 0);
  }
  record.left_out = boundaries.empty() ? 0 : static_cast<std::int64_t>(boundaries.front());
  input.segments = cut_at(steps, boundaries);
}

/// Step numbers of the record count all steps of the file.
void shift_numbers(SizeRecord& record) {
  const auto shift = [&](SizeNeed& need) {
    for (std::int64_t* step : {&need.culprit.step, &need.culprit.late_step}) *step += *step >= 0 ? record.left_out : 0;
  };
  for (SizeBounds* bounds : {&record.held, record.linear ? &*record.linear : nullptr}) {
    if (bounds == nullptr) continue;
    shift(bounds->best_line);
    shift(bounds->taut_string);
  }
  for (SizeStrategy& strategy : record.strategies) {
    shift(strategy.any_phase);
    if (strategy.lead_culprit >= 0) strategy.lead_culprit += record.left_out;
  }
}

}  // namespace

SizeResult size_scenario(const Scenario& scenario, const SizeOptions& options) {
  if (scenario.case_spec)
    return {{}, {{scenario.file, 0, 0, "a [case] drives the solver without a loop: there is no latency to size"}}};
  Input input{scenario, segments_of(scenario)};
  SizeResult result;
  result.record.input = scenario.file;
  result.record.segments_from = scenario.timing.trace.empty() ? "programmed" : "recording";
  Sizer(input, options).size(result.record);
  return result;
}

SizeRecord size_segments(std::vector<SegmentTiming> segments, const std::string& name, const SizeOptions& options) {
  SizeRecord record;
  record.input = name;
  record.segments_from = "recording";
  Input input;
  input.segments = std::move(segments);
  find_segments(input, record);
  input.scenario.devices.push_back({.name = "device", .rate = options.sampling, .emission = options.emission});
  for (const SegmentTiming& segment : input.segments)   // a step may end behind the segment after its own
    input.scenario.run_duration = std::max(input.scenario.run_duration, segment.end - RealTime{} + Duration{1});
  Sizer(input, options).size(record);
  shift_numbers(record);
  return record;
}

SizeResult size_recording(const std::string& path, const SizeOptions& options) {
  TimingCsv csv = read_timing_or_steps(path);
  if (!csv.errors.empty()) return {{}, std::move(csv.errors)};
  const auto has_steps = [](const SegmentTiming& segment) { return !segment.steps.empty(); };
  if (std::none_of(csv.segments.begin(), csv.segments.end(), has_steps))
    return {{}, {{path, 0, 0, "there is no step in it; write a row of kind step for each"}}};
  return {size_segments(std::move(csv.segments), path, options), {}};
}

}  // namespace evenstep
