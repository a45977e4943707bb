// What sizing a long recording costs: the process CPU for three million steps (200 000 segments of 15, 10 % jitter), on one
// thread.
//   build/bench/bench_sizing [REPETITIONS]
// Measured are all of `evenstep size` on segments in memory, its parts, and reading the same from the text of a timing.csv.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "evenstep/campaigns/size.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/remap/step_cycle.h"

namespace {

using namespace evenstep;

std::vector<SegmentTiming> recording() {
  ProgrammedTiming timing;
  timing.visualization_variation = timing.step_variation = 0.1;
  const auto source = make_programmed_timing(timing);
  std::vector<SegmentTiming> segments(200'000);
  for (SegmentTiming& segment : segments) source->next(segment);
  return segments;
}

std::string written(const std::vector<SegmentTiming>& segments) {
  std::string text = "segment,kind,index,begin_ns,end_ns\n";
  char row[128];
  const auto put = [&](const char* kind, std::int64_t segment, std::size_t index, Interval interval) {
    text.append(row, static_cast<std::size_t>(std::snprintf(
                         row, sizeof row, "%lld,%s,%zu,%lld,%lld\n", static_cast<long long>(segment), kind, index,
                         static_cast<long long>(interval.begin.ns), static_cast<long long>(interval.end.ns))));
  };
  for (const SegmentTiming& segment : segments) {
    put("visualization", segment.index, 0, *segment.visualization);
    for (std::size_t i = 0; i < segment.steps.size(); ++i) put("step", segment.index, i, segment.steps[i]);
  }
  return text;
}

void measure(const char* what, int repetitions, const std::function<void()>& work) {
  std::vector<double> spent_s;
  for (int i = 0; i < repetitions; ++i) {
    const double before_s = process_cpu_seconds();
    work();
    spent_s.push_back(process_cpu_seconds() - before_s);
  }
  std::sort(spent_s.begin(), spent_s.end());
  std::printf("%-52s %8.1f %8.1f\n", what, 1e3 * spent_s.front(), 1e3 * spent_s[spent_s.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = std::max(argc > 1 ? std::atoi(argv[1]) : 9, 1);
  const std::vector<SegmentTiming> segments = recording();
  const std::string text = written(segments);
  std::vector<StepTimes> steps;
  for (const SegmentTiming& segment : segments) {
    for (const Interval& step : segment.steps) steps.push_back({step.begin, step.end, segment.index, 0});
  }
  Scenario scenario;
  scenario.devices.emplace_back();
  scenario.run_duration = replay_duration(segments);
  const MapSetup setup = map_setup(scenario);
  const std::vector<SamplingGrid>& grids = setup.grids;
  std::vector<MappedStep> mapped;

  std::printf("%-52s %8s %8s\n", "three million steps, CPU ms", "least", "median");
  measure("best line", repetitions, [&] { best_line(steps); });
  measure("least path", repetitions, [&] { least_path(steps); });
  measure("taut string at 20 ms", repetitions, [&] { taut_string(steps, {20'000'000}, {999'999}); });
  for (const StrategyKind kind : {StrategyKind::paper, StrategyKind::phase_locked}) {
    const std::string name = name_of(kind);
    measure((name + ": the map over all steps").c_str(), repetitions, [&] {
      mapped.clear();
      each_mapped_step(setup, kind, segments,
                       [&](std::span<const MappedStep> some) { mapped.insert(mapped.end(), some.begin(), some.end()); });
    });
    measure((name + ": least latency and rings, any phase").c_str(), repetitions,
            [&] { least_latency_any_phase(mapped, grids, Emission::hold); });
    measure((name + ": least latency and rings, this phase").c_str(), repetitions,
            [&] { least_latency_this_phase(mapped, grids, Emission::hold); });
  }
  measure("finding the cycle", repetitions, [&] { find_cycle(steps); });
  measure("evenstep size, all of it, from memory", repetitions, [&] { size_segments(segments, "", {}); });
  measure("reading the same from timing.csv", repetitions, [&] { (void)parse_timing_csv(text, "timing.csv"); });
}
