#include <algorithm>

#include "evenstep/reports/measures.h"
#include "src/judged.h"
#include "src/line_measures.h"
#include "src/straight.h"

namespace evenstep {
namespace {

/// A signal to be divided into bins: its samples, the real time of each, and the real times of its underruns.
struct Timeline {
  internal::Series series;
  std::vector<internal::Window> pieces;
  std::vector<RealTime> at;
  std::vector<RealTime> underruns;
};

Timeline interaction_timeline(const StrategyRecord& strategy, const DeviceRecord& device,
                              const std::vector<std::size_t>& steps, const Nominal& nominal) {
  Timeline timeline{internal::interaction_series(strategy, device, steps, nominal.slot_s),
                    internal::straight_steps(strategy, internal::nominal_device(nominal, device.name), steps),
                    {},
                    {}};
  for (const std::size_t n : steps) {
    timeline.at.push_back(strategy.steps[n].begin);
    if (device.steps[n].read == StepRead::underrun) timeline.underruns.push_back(strategy.steps[n].begin);
  }
  return timeline;
}

Timeline force_timeline(const StrategyRecord& strategy, const DeviceRecord& device, const std::vector<std::size_t>& steps,
                        const Nominal& nominal) {
  const std::vector<std::size_t> ticks = internal::judged_ticks(device, nominal);
  Timeline timeline{internal::force_series(device, ticks, nominal.judged_from),
                    internal::straight_ticks(strategy, device, internal::nominal_device(nominal, device.name), ticks),
                    {},
                    {}};
  for (const std::size_t k : ticks) timeline.at.push_back(device.ticks[k].at);
  for (const std::size_t n : steps) {
    if (internal::is_late(strategy.steps[n])) timeline.underruns.push_back(strategy.steps[n].begin);
  }
  return timeline;
}

/// The parts of the pieces in [begin, end).
std::vector<internal::Window> within(const std::vector<internal::Window>& pieces, std::size_t begin, std::size_t end) {
  std::vector<internal::Window> parts;
  for (const internal::Window& piece : pieces) {
    const internal::Window part{std::max(piece.begin, begin), std::min(piece.end, end)};
    if (part.begin < part.end) parts.push_back(part);
  }
  return parts;
}

bool any_line(const std::vector<internal::Window>& parts) {
  return std::any_of(parts.begin(), parts.end(), [](const internal::Window& part) { return part.size() >= 3; });
}

/// Divides into bins [origin + b * width, + width). A jump belongs to the bin of its middle sample, so that none is lost at
/// an edge.
std::vector<BinRow> cut(const Timeline& timeline, RealTime origin, double bin_s) {
  std::vector<BinRow> rows;
  const Duration width{static_cast<std::int64_t>(bin_s * 1e9)};
  std::size_t begin = 0;
  const auto first_at = [](const std::vector<RealTime>& times, RealTime t) {
    return static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), t) - times.begin());
  };
  for (std::int64_t b = 0; begin < timeline.at.size(); ++b) {
    const RealTime to = origin + width * (b + 1);
    const std::size_t end = first_at(timeline.at, to);
    const std::vector<internal::Window> parts = within(timeline.pieces, begin, end);
    if (any_line(parts)) {
      const std::span<const double> t(timeline.series.t_s);
      const std::span<const Vec3> x(timeline.series.value);
      const auto with_neighbours = within(timeline.pieces, begin == 0 ? 0 : begin - 1, end + 1);
      rows.push_back({.from_s = seconds(origin + width * b),
                      .deviation_max = internal::deviation(t, x, internal::windows(t, parts, internal::kWindow_s)).max,
                      .velocity_jump = internal::velocity_jump(x, with_neighbours),
                      .underruns_so_far = static_cast<std::int64_t>(first_at(timeline.underruns, to))});
    }
    begin = end;
  }
  return rows;
}

}  // namespace

std::map<std::string, std::vector<BinRow>> bins(const RunRecord& run, double bin_s) {
  std::map<std::string, std::vector<BinRow>> result;
  for (const StrategyRecord& strategy : run.strategies) {
    const std::vector<std::size_t> steps = internal::judged_steps(strategy, run.nominal);
    for (const DeviceRecord& device : strategy.devices) {
      result[device.name + ".interaction." + strategy.name] =
          cut(interaction_timeline(strategy, device, steps, run.nominal), run.nominal.judged_from, bin_s);
      result[device.name + ".force." + strategy.name] =
          cut(force_timeline(strategy, device, steps, run.nominal), run.nominal.judged_from, bin_s);
    }
  }
  return result;
}

}  // namespace evenstep
