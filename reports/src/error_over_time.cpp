#include <algorithm>
#include <array>
#include <cmath>

#include "evenstep/reports/figures.h"
#include "evenstep/reports/measures.h"
#include "src/strategy_looks.h"
#include "src/svg.h"

namespace evenstep {
namespace {

using internal::Axis;
using internal::Range;

constexpr double kBin_s = 1;
constexpr std::size_t kLeastBins = 10;
constexpr double kMargin = 0.05;  // share of the span below the lowest value, so that broad curves stay inside
constexpr double kDecades = 9;    // the most that are shown: below a billionth of the largest error there is only rounding

// Per device a block of three panels (deviation, jump, underruns) in two columns (interaction, force).
constexpr double kWidth = 1100, kHead = 58, kBlock = 540, kPanelHeight = 140, kPanelDistance = 160;
struct Column {
  const char* kind;
  double left, right;
};
constexpr std::array kColumns = std::to_array<Column>({{"interaction", 86, 536}, {"force", 636, 1086}});

struct Curve {
  std::string strategy;
  std::vector<double> t_s, value;
};

/// One signal of one device: the bins of every strategy, in the unit that is shown.
struct Signal {
  std::string name, unit;
  double unit_size = 1;
  std::vector<std::pair<std::string, std::vector<BinRow>>> strategies;
};

Signal signal_of(const RunRecord& run, const std::map<std::string, std::vector<BinRow>>& all, const std::string& name) {
  const std::optional<double> step = step_unit(run.nominal, name + ".any");
  Signal signal{name, step ? "step" : base_unit(name + ".any", "deviation_max"), step.value_or(1), {}};
  for (const std::string& strategy : internal::in_drawing_order(run)) {
    const auto found = all.find(name + "." + strategy);
    if (found != all.end()) signal.strategies.emplace_back(strategy, found->second);
  }
  return signal;
}

/// The value of a bin is drawn in its middle; a missing bin interrupts the curve.
std::vector<Curve> error_curves(const Signal& signal, double BinRow::*error, double end_s) {
  std::vector<Curve> curves;
  for (const auto& [strategy, rows] : signal.strategies) {
    Curve& curve = curves.emplace_back(Curve{strategy, {}, {}});
    for (std::size_t b = 0; b < rows.size(); ++b) {
      if (b > 0 && rows[b].from_s - rows[b - 1].from_s > 1.5 * kBin_s) {
        curve.t_s.push_back(rows[b].from_s);
        curve.value.push_back(NAN);
      }
      curve.t_s.push_back((rows[b].from_s + std::min(rows[b].from_s + kBin_s, end_s)) / 2);
      curve.value.push_back(rows[b].*error / signal.unit_size);
    }
  }
  return curves;
}

/// The underruns up to the end of each bin; 0 at the begin of the first.
std::vector<Curve> underrun_curves(const Signal& signal, double end_s) {
  std::vector<Curve> curves;
  for (const auto& [strategy, rows] : signal.strategies) {
    Curve& curve = curves.emplace_back(Curve{strategy, {}, {}});
    if (rows.empty()) continue;
    curve.t_s.push_back(rows.front().from_s);
    curve.value.push_back(0);
    for (const BinRow& row : rows) {
      curve.t_s.push_back(std::min(row.from_s + kBin_s, end_s));
      curve.value.push_back(static_cast<double>(row.underruns_so_far));
    }
  }
  return curves;
}

/// Replaces every value by its log10, and returns a range of whole decades. Values that are 0 or too small are drawn at the
/// lowest one.
Range to_decades(std::vector<Curve>& curves) {
  double least = INFINITY, most = 0;
  for (const Curve& curve : curves) {
    for (const double value : curve.value) {
      if (!(value > 0) || std::isinf(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  Range range{-1, 1};
  if (most > 0) {
    range.high = std::ceil(std::log10(most) + 0.02);
    range.low = std::clamp(std::floor(std::log10(least) - 0.02), range.high - kDecades, range.high - 2);
  }
  for (Curve& curve : curves) {
    for (double& value : curve.value)
      value = value > 0 || std::isnan(value) ? std::max(std::log10(value), range.low) : range.low;
  }
  return {range.low - kMargin * (range.high - range.low), range.high};
}

Range count_range(const std::vector<Curve>& curves) {
  double most = 5;  // at least this, so that the ticks are at whole counts
  for (const Curve& curve : curves) {
    for (const double value : curve.value) most = std::max(most, value);
  }
  return {-kMargin * most, most * 1.08};
}

void draw_signal(internal::Svg& svg, const RunRecord& run, const Signal& signal, const Range& time_s, const Column& column,
                 double top) {
  svg.text({column.left, top + 12}, signal.name, internal::Svg::Anchor::start, 13, true);
  std::vector<Curve> deviation = error_curves(signal, &BinRow::deviation_max, time_s.high);
  std::vector<Curve> jump = error_curves(signal, &BinRow::velocity_jump, time_s.high);
  const std::vector<Curve> underruns = underrun_curves(signal, time_s.high);
  const Axis deviation_axis{to_decades(deviation), "deviation max", signal.unit, true};
  const Axis jump_axis{to_decades(jump), "velocity jump", signal.unit, true};
  const Axis underrun_axis{count_range(underruns), "underruns so far", "count"};
  double y = top + 22;
  const auto panel = [&](const std::vector<Curve>& curves, const Axis& axis, bool last) {
    internal::Panel drawn(svg, {column.left, y, column.right, y + kPanelHeight}, {time_s, "run time", "s"}, axis);
    drawn.draw_axes(last, last);
    for (std::size_t i = 0; i < curves.size(); ++i)
      drawn.curve(curves[i].t_s, curves[i].value, internal::look_of(run, curves[i].strategy));
    y += kPanelDistance;
  };
  panel(deviation, deviation_axis, false);
  panel(jump, jump_axis, false);
  panel(underruns, underrun_axis, true);
}

}  // namespace

std::optional<std::string> error_over_time_svg(const RunRecord& run) {
  const auto all = bins(run, kBin_s);
  const bool enough = std::any_of(all.begin(), all.end(), [](const auto& s) { return s.second.size() >= kLeastBins; });
  if (!enough) return std::nullopt;
  const Range time_s{0, seconds(run.nominal.end - RealTime{})};
  const std::vector<Nominal::Device>& devices = run.nominal.devices;
  internal::Svg svg(kWidth, kHead + kBlock * static_cast<double>(devices.size()), "Error against run time");
  internal::draw_legend(svg, {kColumns.front().left, 44}, run, internal::in_drawing_order(run));
  for (std::size_t d = 0; d < devices.size(); ++d) {
    for (const Column& column : kColumns) {
      draw_signal(svg, run, signal_of(run, all, devices[d].name + "." + column.kind), time_s, column,
                  kHead + kBlock * static_cast<double>(d));
    }
  }
  return std::move(svg).finish();
}

}  // namespace evenstep
