#include <algorithm>
#include <cmath>

#include "evenstep/campaigns/fit_report.h"
#include "evenstep/format/reader.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/scheduler/frame_governor.h"
#include "evenstep/scheduler/random.h"

namespace evenstep {
namespace {

constexpr Duration kWindow{250'000'000};

std::vector<StepTimes> steps_of(std::span<const SegmentTiming> segments) {
  std::vector<StepTimes> steps;
  for (const SegmentTiming& segment : segments) {
    for (const Interval& step : segment.steps) steps.push_back({step.begin, step.end, segment.index, 0});
  }
  return steps;
}

std::vector<std::int64_t> window_needs(std::span<const StepTimes> steps) {
  std::vector<std::int64_t> needs;
  const RealTime last = steps.back().begin;
  for (std::size_t from = 0; from < steps.size();) {
    const RealTime end = steps[from].begin + kWindow;
    std::size_t to = from;
    while (to < steps.size() && steps[to].begin < end) ++to;
    if (end > last && !needs.empty()) break;
    needs.push_back(best_line(steps.subspan(from, to - from)).latency.ns);
    from = to;
  }
  std::sort(needs.begin(), needs.end());
  return needs;
}

Duration phase_locked_need(std::span<const SegmentTiming> segments) {
  const MapSetup setup{.grids = {SamplingGrid{}}, .emission = Emission::hold, .end = RealTime{} + replay_duration(segments)};
  std::vector<MappedStep> steps;
  each_mapped_step(setup, StrategyKind::phase_locked, segments,
                   [&](std::span<const MappedStep> some) { steps.insert(steps.end(), some.begin(), some.end()); });
  return least_latency_any_phase(steps, setup.grids, setup.emission).latency;
}

std::vector<SegmentTiming> played(const TimingFit& fit, std::uint64_t seed, std::size_t count) {
  ProgrammedTiming timing = fit.timing;
  timing.seed = seed;
  auto source = make_programmed_timing(timing);
  if (fit.spread) source = make_governed_timing(std::move(source), {.spread = true}, grid_period(timing));
  std::vector<SegmentTiming> segments(count);
  for (SegmentTiming& segment : segments) source->next(segment);
  return segments;
}

/// The segments, each with the time until the next one begins, in the order of random keys. If a step reaches into the next
/// segment, everything after it waits.
std::vector<SegmentTiming> shuffled(std::span<const SegmentTiming> segments, std::uint64_t seed) {
  const RandomStream keys(seed, "fit.shuffle");
  std::vector<std::size_t> order(segments.size() - 1);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys.bits(a) < keys.bits(b); });
  std::vector<SegmentTiming> out;
  RealTime begin{}, step_end{};
  for (const std::size_t k : order) {
    const Duration by = begin - segments[k].begin;
    SegmentTiming moved;
    moved.index = static_cast<std::int64_t>(out.size());
    moved.begin = moved.end = begin;
    for (const Interval& step : segments[k].steps) {
      const RealTime from = std::max(step.begin + by, step_end);
      step_end = from + (step.end - step.begin);
      moved.steps.push_back({from, step_end});
      moved.end = step_end;
    }
    out.push_back(std::move(moved));
    begin = begin + (segments[k + 1].begin - segments[k].begin);
  }
  return out;
}

LatencyNeed median_of(const std::vector<LatencyNeed>& needs) {
  if (needs.empty()) return {};
  const auto median = [&](Duration LatencyNeed::*part) {
    std::vector<std::int64_t> values;
    for (const LatencyNeed& need : needs) values.push_back((need.*part).ns);
    std::sort(values.begin(), values.end());
    return Duration{values[values.size() / 2]};
  };
  return {median(&LatencyNeed::window_p50), median(&LatencyNeed::window_p99), median(&LatencyNeed::whole),
          median(&LatencyNeed::phase_locked)};
}

}  // namespace

LatencyNeed latency_need(std::span<const SegmentTiming> segments) {
  const std::vector<StepTimes> steps = steps_of(segments);
  if (steps.empty()) return {};
  const std::vector<std::int64_t> needs = window_needs(steps);
  const auto rank = [&](double share) {
    const double n = static_cast<double>(needs.size());
    return Duration{needs[static_cast<std::size_t>(std::max(std::ceil(share * n) - 1, 0.0))]};
  };
  return {rank(0.5), rank(0.99), best_line(steps).latency, phase_locked_need(segments)};
}

std::string table_objection(const TimingFit& fit) {
  const std::string name = "the table that was fitted";
  internal::Errors errors;
  internal::Value document = internal::parse_toml(
      "format = 1\n[run]\nduration = \"1 s\"\n[scene]\nkind = \"spring\"\n[[device]]\nname = \"left\"\n[timing]\n" +
          fitted_table(fit),
      name, errors);
  if (errors.any()) return errors.sorted(name).front().message;
  const ReadResult read = internal::read_document(std::move(document), name);
  return read ? "" : read.error().front().message;
}

FitComparison compare(const TimingFit& fit, std::span<const SegmentTiming> segments, int seeds) {
  FitComparison out;
  out.objection = table_objection(fit);
  out.recording = latency_need(segments.first(segments.size() - 1));
  LongestPause pauses;
  for (const SegmentTiming& one : segments)
    pauses.add_segment({one.begin, one.end}, one.visualization, one.steps, one.overlaps());
  out.pause = pauses.parts();
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto stream = static_cast<std::uint64_t>(seed);
    if (out.objection.empty()) out.model.push_back(latency_need(played(fit, stream, segments.size() - 1)));
    out.shuffled.push_back(latency_need(shuffled(segments, stream)));
  }
  out.model_median = median_of(out.model);
  out.shuffled_median = median_of(out.shuffled);
  return out;
}

std::vector<std::string> differences(const LatencyNeed& a, const LatencyNeed& b) {
  std::vector<std::string> out;
  const auto compare_part = [&](Duration x, Duration y, double tolerance, const char* name) {
    const auto [less, more] = std::minmax(x.ns, y.ns);
    if (static_cast<double>(more) > tolerance * static_cast<double>(less)) out.emplace_back(name);
  };
  compare_part(a.window_p50, b.window_p50, kFitTolerance, "250 ms p50");
  compare_part(a.window_p99, b.window_p99, kFitTolerance, "250 ms p99");
  compare_part(a.whole, b.whole, kFitTolerance, "whole recording");
  compare_part(a.phase_locked, b.phase_locked, kMapTolerance, "phase_locked");
  return out;
}

}  // namespace evenstep
