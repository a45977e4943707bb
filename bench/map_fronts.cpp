// Latency and velocity jump of each map on recordings, with held forces and a device of 1 kHz at any phase, as `evenstep
// size` computes them. Prints a row per recording and map, then how the jump of the default map compares with that of the
// loops at 2 Hz, and writes a figure.
//   build/bench/bench_map_fronts FOLDER [FIGURE.svg]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/campaigns/size.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/remap/jump_bound.h"
#include "evenstep/remap/latency_budget.h"
#include "evenstep/remap/phase_locked_map.h"
#include "evenstep/remap/velocity_jump.h"
#include "former_maps.h"
#include "map_fronts_svg.h"

namespace evenstep::bench {
namespace {

constexpr double kUsual_Hz = 2;             // the default bandwidth
constexpr Duration kSamplingTerm{999'999};  // h - 1 ns

double milliseconds(Duration duration) { return static_cast<double>(duration.ns) * 1e-6; }

struct Recording {
  std::vector<SegmentTiming> segments;
  std::vector<StepTimes> steps;
  RealTime end;  // the end of the last segment
  Duration slot;

  explicit Recording(std::vector<SegmentTiming> read) : segments(std::move(read)) {
    for (const SegmentTiming& segment : segments) {
      end = std::max(end, segment.end + Duration{1});
      for (const Interval& step : segment.steps) steps.push_back({step.begin, step.end});
    }
    if (steps.size() > 1) slot = {(steps.back().begin - steps.front().begin).ns / (std::ssize(steps) - 1)};
  }
  Duration mean_segment() const { return {(end - segments.front().begin).ns / std::ssize(segments)}; }
  double in_slots(std::int64_t ns) const { return static_cast<double>(ns) / static_cast<double>(slot.ns); }
};

struct MapKind {
  const char* name;
  std::function<std::unique_ptr<SlotMap>(const Recording&, double bandwidth_Hz)> make;
};

const std::vector<MapKind>& map_kinds() {
  static const std::vector<MapKind> kinds{
      {"phase_locked",
       [](const Recording&, double Hz) { return std::make_unique<PhaseLockedMap>(Duration{}, Duration{}, Hz); }},
      {"former", [](const Recording&, double Hz) { return std::make_unique<FormerMap>(Hz); }},
      {"DLL of JACK",
       [](const Recording& of, double Hz) { return std::make_unique<DelayLockedLoop>(Hz, of.mean_segment()); }},
      {"bare loop", [](const Recording&, double Hz) { return std::make_unique<BareLoop>(Hz); }}};
  return kinds;
}

FrontPoint measured(const Recording& recording, const MapKind& kind, double bandwidth_Hz) {
  const std::unique_ptr<SlotMap> map = kind.make(recording, bandwidth_Hz);
  const SamplingGrid device;  // 1 kHz
  RunningNeeds needs({&device, 1}, Emission::hold, RunningNeeds::Phase::any);
  VelocityJump jump(recording.steps.front().begin + Duration{1'000'000'000});
  each_mapped_step(*map, recording.end, recording.segments, [&](std::span<const MappedStep> steps) {
    needs.add(steps);
    jump.add(steps);
  });
  return {bandwidth_Hz, recording.in_slots(jump.most_ns()), milliseconds(needs.budget().latency)};
}

/// The latency that any path needs, at jumps from 0.001 to 100 slots.
std::vector<FrontPoint> any_path(const Recording& recording) {
  constexpr int kPerDecade = 6;
  std::vector<FrontPoint> points;
  for (int i = -3 * kPerDecade; i <= 2 * kPerDecade; ++i) {
    const double jump = std::pow(10.0, static_cast<double>(i) / kPerDecade);
    const Duration most{static_cast<std::int64_t>(jump * static_cast<double>(recording.slot.ns))};
    points.push_back({0, jump, milliseconds(least_latency_with_jump(recording.steps, most) + kSamplingTerm)});
  }
  return points;
}

/// Everything about a recording; nullopt, after saying why, if it cannot be read or `size` finds something else.
std::optional<Fronts> fronts_of(const std::filesystem::path& path) {
  const SizeResult sized = size_recording(path.string(), {});
  TimingCsv csv = read_timing_or_steps(path.string());
  if (!csv || !sized.errors.empty()) {
    std::fprintf(stderr, "%s: not a recording; `evenstep size` says why\n", path.c_str());
    return std::nullopt;
  }
  const Recording recording(*std::move(csv));
  Fronts fronts{path.stem().string(), milliseconds(sized.record.held.best_line.latency),
                milliseconds(sized.record.held.pause), any_path(recording)};
  for (const MapKind& kind : map_kinds()) {
    fronts.maps.push_back({kind.name});
    for (const double bandwidth_Hz : {0.5, 1.0, kUsual_Hz, 4.0})
      fronts.maps.back().points.push_back(measured(recording, kind, bandwidth_Hz));
  }
  for (const SizeStrategy& one : sized.record.strategies) {
    const FrontPoint& usual = at_bandwidth(fronts.maps.front(), kUsual_Hz);
    if (one.name != fronts.maps.front().name) continue;
    if (one.velocity_jump == usual.jump && milliseconds(one.any_phase.latency) == usual.latency_ms) return fronts;
  }
  std::fprintf(stderr, "%s: `evenstep size` finds another latency or jump for phase_locked\n", path.c_str());
  return std::nullopt;
}

void print_rows(const std::vector<Fronts>& all) {
  std::printf("%-30s %-13s %9s %12s %12s %12s\n", "recording", "map", "Hz", "latency ms", "jump slots", "pause bounds");
  for (const Fronts& one : all) {
    const auto bound = [&](const char* name, double latency_ms) {
      std::printf("%-30s %-13s %9s %12.3f %12s %12.2f\n", one.recording.c_str(), name, "", latency_ms, "",
                  latency_ms / one.pause_ms);
    };
    bound("pause bound", one.pause_ms);
    bound("plain line", one.best_line_ms);
    for (const MapFront& map : one.maps) {
      for (const FrontPoint& point : map.points)
        std::printf("%-30s %-13s %9g %12.3f %12.4f %12.2f\n", one.recording.c_str(), map.name.c_str(), point.bandwidth_Hz,
                    point.latency_ms, point.jump, point.latency_ms / one.pause_ms);
    }
  }
}

/// Prints all maps at 2 Hz, and the jump of the default map divided by the smaller one of the former map and the bare loop.
void print_comparison(const std::vector<Fronts>& all) {
  std::printf("\nat %g Hz: latency ms, jump slots; jump of phase_locked / the lesser of former and bare loop\n%-30s",
              kUsual_Hz, "recording");
  for (const MapKind& kind : map_kinds()) std::printf(" %17s", kind.name);
  std::printf(" %8s\n", "times");
  for (const Fronts& one : all) {
    std::printf("%-30s", one.recording.c_str());
    for (const MapFront& map : one.maps)
      std::printf(" %8.3f %8.4f", at_bandwidth(map, kUsual_Hz).latency_ms, at_bandwidth(map, kUsual_Hz).jump);
    const auto jump = [&](std::size_t map) { return at_bandwidth(one.maps[map], kUsual_Hz).jump; };
    std::printf(" %8.2f\n", jump(0) / std::min(jump(1), jump(3)));
  }
}

std::vector<std::filesystem::path> recordings_in(const char* folder) {
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".csv") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

int run(const char* folder, const char* figure) {
  std::vector<Fronts> all;
  for (const std::filesystem::path& path : recordings_in(folder)) {
    std::optional<Fronts> fronts = fronts_of(path);
    if (!fronts) return 1;
    all.push_back(*std::move(fronts));
  }
  if (all.empty()) {
    std::fprintf(stderr, "%s: no folder with recordings (.csv)\n", folder);
    return 2;
  }
  print_rows(all);
  print_comparison(all);
  if (figure == nullptr) return 0;
  std::ofstream out(figure);
  out << fronts_svg(all);
  if (out.flush()) return 0;
  std::fprintf(stderr, "%s: cannot be written\n", figure);
  return 1;
}

}  // namespace
}  // namespace evenstep::bench

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "bench_map_fronts FOLDER [FIGURE.svg]\n");
    return 2;
  }
  return evenstep::bench::run(argv[1], argc == 3 ? argv[2] : nullptr);
}
