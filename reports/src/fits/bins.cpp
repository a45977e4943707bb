#include <algorithm>
#include <cmath>

#include "evenstep/reports/measures.h"
#include "src/fits/straight.h"
#include "src/judged.h"
#include "src/line_measures.h"
#include "src/vec3.h"

namespace evenstep {
namespace {

constexpr std::int64_t kLeastBins = 20, kWantedBins = 60;
constexpr std::int64_t kSamplesOfABin = 4;  // a line needs three

/// Squares of an error, and the time of each.
struct Squares {
  Rows<RealTime> at;
  Rows<double> square;
};

/// A signal to be divided into bins: its samples, the real time of each, the squares of its other errors, and the real times
/// of its underruns.
struct Timeline {
  internal::Series series;
  std::vector<internal::Window> pieces;
  Rows<RealTime> at;
  Squares error, from_ideal;
  Rows<RealTime> underruns;
};

/// An empty timeline whose columns are kept where the rows are.
Timeline timeline_beside(const RowAllocator<StepRow>& rows) {
  const auto squares = [&] { return Squares{Rows<RealTime>(rows), Rows<double>(rows)}; };
  return {{Rows<double>(rows), Rows<Vec3>(rows)}, {}, Rows<RealTime>(rows), squares(), squares(), Rows<RealTime>(rows)};
}

void add(Squares& squares, RealTime at, const Vec3& is, const Vec3& should_be) {
  const double distance = internal::norm(internal::minus(is, should_be));
  squares.at.push_back(at);
  squares.square.push_back(distance * distance);
}

Timeline interaction_timeline(const StrategyRecord& strategy, const DeviceRecord& device, const Rows<std::size_t>& steps,
                              const Nominal& nominal) {
  Timeline timeline = timeline_beside(strategy.steps.get_allocator());
  timeline.series = internal::interaction_series(strategy, device, steps, nominal.slot_s);
  timeline.pieces = internal::straight_steps(strategy, internal::nominal_device(nominal, device.name), steps);
  for (const std::size_t n : steps) {
    const StepSample& sample = device.steps[n];
    timeline.at.push_back(strategy.steps[n].begin);
    if (sample.true_position_m) add(timeline.error, strategy.steps[n].begin, sample.position_m, *sample.true_position_m);
    if (sample.read == StepRead::underrun) timeline.underruns.push_back(strategy.steps[n].begin);
  }
  return timeline;
}

Timeline force_timeline(const StrategyRecord& strategy, std::size_t device_index, const Rows<std::size_t>& steps,
                        const Nominal& nominal) {
  const DeviceRecord& device = strategy.devices[device_index];
  const Rows<std::size_t> ticks = internal::judged_ticks(device, nominal);
  Timeline timeline = timeline_beside(strategy.steps.get_allocator());
  timeline.series = internal::force_series(device, ticks, nominal.judged_from);
  timeline.pieces = internal::straight_ticks(strategy, device, internal::nominal_device(nominal, device.name), ticks);
  for (const std::size_t k : ticks) {
    const TickRow& tick = device.ticks[k];
    timeline.at.push_back(tick.at);
    if (tick.undelayed_N) add(timeline.error, tick.at, tick.force_N, *tick.undelayed_N);
  }
  for (const std::size_t n : steps) {
    const RealTime begin = strategy.steps[n].begin;
    const std::size_t twin = n * strategy.devices.size() + device_index;
    if (twin < strategy.twin_force_N.size())
      add(timeline.from_ideal, begin, device.steps[n].force_N, strategy.twin_force_N[twin]);
    if (is_late(strategy.steps[n], device)) timeline.underruns.push_back(begin);
  }
  return timeline;
}

std::size_t first_at(std::span<const RealTime> times, RealTime t) {
  return static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), t) - times.begin());
}

/// Empty if there is no such error in [from, to).
std::optional<double> rms_in(const Squares& squares, RealTime from, RealTime to) {
  const std::size_t begin = first_at(squares.at, from), end = first_at(squares.at, to);
  if (begin >= end) return std::nullopt;
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += squares.square[i];
  return std::sqrt(sum / static_cast<double>(end - begin));
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

/// Distance of each sample from the line of its window. The windows are those of the whole run, so that a bin shows its part
/// of what the whole run is judged by. Empty where a window has too few samples for a line.
Rows<std::optional<double>> distances(const Timeline& timeline) {
  const std::span<const double> t(timeline.series.t_s);
  const std::span<const Vec3> x(timeline.series.value);
  Rows<std::optional<double>> result(x.size(), timeline.at.get_allocator());
  for (const internal::Window& window : internal::windows(t, timeline.pieces, internal::kWindow_s)) {
    if (window.size() < 3) continue;
    const std::vector<Vec3> residual =
        internal::line_residual(t.subspan(window.begin, window.size()), x.subspan(window.begin, window.size()));
    for (std::size_t i = 0; i < residual.size(); ++i) result[window.begin + i] = internal::norm(residual[i]);
  }
  return result;
}

void put_deviation(BinRow& row, std::span<const std::optional<double>> distances) {
  internal::Peak peak;
  double squares = 0, count = 0;
  for (const std::optional<double>& distance : distances) {
    if (!distance) continue;
    peak.add(*distance);
    squares += *distance * *distance;
    ++count;
  }
  row.deviation_max = peak.value;
  row.deviation_rms = std::sqrt(squares / count);
}

/// A jump belongs to the bin of its middle sample, so that none is lost at an edge.
std::vector<BinRow> cut(const Timeline& timeline, const BinLayout& layout, RealTime run_end) {
  std::vector<BinRow> rows;
  const Rows<std::optional<double>> deviation = distances(timeline);
  for (std::int64_t b = 0; b < layout.count; ++b) {
    const bool last = b + 1 == layout.count;
    const RealTime from = layout.origin + layout.width * b, to = from + layout.width;
    const RealTime before = last ? RealTime{INT64_MAX} : to;
    const std::size_t begin = first_at(timeline.at, from), end = first_at(timeline.at, before);
    const std::vector<internal::Window> parts = within(timeline.pieces, begin, end);
    if (!any_line(parts)) continue;
    const auto with_neighbours = within(timeline.pieces, begin == 0 ? 0 : begin - 1, end + 1);
    BinRow& row = rows.emplace_back();
    row.from_s = seconds(from);
    row.to_s = seconds(last ? run_end : to);
    for (const Vec3& value : std::span(timeline.series.value).subspan(begin, end - begin))
      row.largest = std::max(row.largest, internal::norm(value));
    put_deviation(row, std::span(deviation).subspan(begin, end - begin));
    row.velocity_jump = internal::velocity_jump(timeline.series.value, with_neighbours);
    row.error_rms = rms_in(timeline.error, from, before);
    row.deviation_from_ideal_rms = rms_in(timeline.from_ideal, from, before);
    row.underruns_so_far = static_cast<std::int64_t>(first_at(timeline.underruns, before));
  }
  return rows;
}

/// The mean time between two steps of the strategy that made most steps.
Duration step_distance(const RunRecord& run, Duration judged) {
  std::int64_t most = 1;
  for (const StrategyRecord& strategy : run.strategies)
    most = std::max(most, std::ssize(internal::judged_steps(strategy, run.nominal)));
  return {judged.ns / most};
}

/// The periods after which a run's errors repeat: a segment, and the way there and back. Bins of whole periods are alike.
std::vector<Duration> periods(const Nominal& nominal) {
  std::vector<Duration> result{nominal.segment};
  for (const Nominal::Device& device : nominal.devices) {
    if (device.turns) result.push_back((device.turns->straight + device.turns->turn) * 2);
  }
  return result;
}

}  // namespace

BinLayout bin_layout(const RunRecord& run) {
  const Duration judged = run.nominal.end - run.nominal.judged_from;
  if (judged.ns <= 0) return {run.nominal.judged_from, {1}, 0};
  Duration sample = step_distance(run, judged);
  for (const Nominal::Device& device : run.nominal.devices) sample = std::max(sample, period_ceil(device.rate));
  Duration width{std::max<std::int64_t>(judged.ns / kLeastBins, 1)};
  for (const Duration period : periods(run.nominal)) {
    const std::int64_t count = period.ns > 0 ? judged.ns / period.ns : 0;
    if (count >= kLeastBins) width = period * std::max<std::int64_t>(count / kWantedBins, 1);
  }
  width = std::max(width, std::min(judged, sample * kSamplesOfABin));
  // A remainder that is shorter than half a bin is added to the last bin.
  return {run.nominal.judged_from, width, std::max<std::int64_t>((judged.ns + width.ns / 2) / width.ns, 1)};
}

std::map<std::string, std::vector<BinRow>> bins(const RunRecord& run) { return bins(run, bin_layout(run)); }

std::map<std::string, std::vector<BinRow>> bins(const RunRecord& run, const BinLayout& layout) {
  std::map<std::string, std::vector<BinRow>> result;
  for (const StrategyRecord& strategy : run.strategies) {
    const Rows<std::size_t> steps = internal::judged_steps(strategy, run.nominal);
    for (std::size_t d = 0; d < strategy.devices.size(); ++d) {
      const DeviceRecord& device = strategy.devices[d];
      result[device.name + ".interaction." + strategy.name] =
          cut(interaction_timeline(strategy, device, steps, run.nominal), layout, run.nominal.end);
      result[device.name + ".force." + strategy.name] =
          cut(force_timeline(strategy, d, steps, run.nominal), layout, run.nominal.end);
    }
  }
  return result;
}

}  // namespace evenstep
