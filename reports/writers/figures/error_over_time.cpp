#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "evenstep/reports/figures.h"
#include "evenstep/reports/measures.h"
#include "writers/figures/strategy_looks.h"
#include "writers/figures/svg.h"

namespace evenstep {
namespace {

using internal::Axis;
using internal::Range;

constexpr std::size_t kLeastBins = 10;
constexpr double kMargin = 0.05;  // share of the span below the lowest value, so that broad curves stay inside
constexpr double kDecades = 9;    // the most that are shown: below a billionth of the largest error there is only rounding

// Per device a block in two columns (interaction, force): the name, a line for each strategy on how its errors grow, and the
// panels (deviation, another error if there is one, jump, underruns).
constexpr double kWidth = 1100, kHead = 74, kPanelHeight = 140, kPanelDistance = 160, kLine = 14;
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
  const BinnedError* error = nullptr;  ///< the error drawn beside the deviation; null if no bin has one
  std::vector<std::pair<std::string, std::vector<BinRow>>> strategies;
};

/// A force's distance from the ideal twin's force says more than its distance from the undelayed force, which contains the
/// latency.
const BinnedError* shown_error(const std::vector<std::pair<std::string, std::vector<BinRow>>>& strategies) {
  const BinnedError* shown = nullptr;
  for (const BinnedError& error : std::span(kBinnedErrors).subspan(1)) {
    for (const auto& [strategy, rows] : strategies) {
      if (std::any_of(rows.begin(), rows.end(), [&](const BinRow& row) { return error.rms(row).has_value(); }))
        shown = &error;
    }
  }
  return shown;
}

Signal signal_of(const RunRecord& run, const std::map<std::string, std::vector<BinRow>>& all, const std::string& name) {
  const std::optional<double> step = step_unit(run.nominal, name + ".any");
  Signal signal{name, step ? "step" : base_unit(name + ".any", "deviation_max"), step.value_or(1), nullptr, {}};
  for (const std::string& strategy : internal::in_drawing_order(run)) {
    const auto found = all.find(name + "." + strategy);
    if (found != all.end()) signal.strategies.emplace_back(strategy, found->second);
  }
  signal.error = shown_error(signal.strategies);
  return signal;
}

/// "from ideal": short enough to fit beside a panel
std::string short_name(std::string_view error) {
  return error == "deviation_from_ideal" ? "from ideal" : std::string(error);
}

/// The value of a bin is drawn in its middle; a missing bin interrupts the curve.
template <class Value>
std::vector<Curve> error_curves(const Signal& signal, Value value_of) {
  std::vector<Curve> curves;
  for (const auto& [strategy, rows] : signal.strategies) {
    Curve& curve = curves.emplace_back(Curve{strategy, {}, {}});
    for (std::size_t b = 0; b < rows.size(); ++b) {
      const double width_s = rows[b].to_s - rows[b].from_s;
      if (b > 0 && rows[b].from_s - rows[b - 1].to_s > width_s / 2) {
        curve.t_s.push_back(rows[b].from_s);
        curve.value.push_back(NAN);
      }
      curve.t_s.push_back((rows[b].from_s + rows[b].to_s) / 2);
      const std::optional<double> value = value_of(rows[b]);
      curve.value.push_back(value ? *value / signal.unit_size : NAN);
    }
  }
  return curves;
}

/// The underruns up to the end of each bin; 0 at the begin of the first.
std::vector<Curve> underrun_curves(const Signal& signal) {
  std::vector<Curve> curves;
  for (const auto& [strategy, rows] : signal.strategies) {
    Curve& curve = curves.emplace_back(Curve{strategy, {}, {}});
    if (rows.empty()) continue;
    curve.t_s.push_back(rows.front().from_s);
    curve.value.push_back(0);
    for (const BinRow& row : rows) {
      curve.t_s.push_back(row.to_s);
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

/// "direct: deviation bounded (0), error linear (0.9 to 1.1)"
std::string growth_line(const Signal& signal, const std::string& strategy, const Metrics& metrics) {
  std::string line;
  for (const auto& [error, interval] : growths_of(metrics, signal.name + "." + strategy)) {
    const bool drawn = error == kBinnedErrors.front().name || (signal.error && error == signal.error->name);
    if (!drawn) continue;
    line += fmt::format("{} {} {}", line.empty() ? strategy + ":" : ",", short_name(error), growth_text(interval));
  }
  return line;
}

void draw_signal(internal::Svg& svg, const RunRecord& run, const Metrics& metrics, const Signal& signal, const Range& time_s,
                 const Column& column, double top) {
  svg.text({column.left, top + 12}, signal.name, internal::Svg::Anchor::start, 13, true);
  double y = top + 12;
  for (const auto& [strategy, rows] : signal.strategies) {
    y += kLine;
    svg.text({column.left, y}, growth_line(signal, strategy, metrics), internal::Svg::Anchor::start, 11);
  }
  y += 10;
  const auto panel = [&](const std::vector<Curve>& curves, const Axis& axis, bool last) {
    internal::Panel drawn(svg, {column.left, y, column.right, y + kPanelHeight}, {time_s, "run time", "s"}, axis);
    drawn.draw_axes(last, last);
    for (std::size_t i = 0; i < curves.size(); ++i)
      drawn.curve(curves[i].t_s, curves[i].value, internal::look_of(run, curves[i].strategy));
    y += kPanelDistance;
  };
  const auto errors = [&](const char* name, auto value_of) {
    std::vector<Curve> curves = error_curves(signal, value_of);
    const Axis axis{to_decades(curves), name, signal.unit, true};
    panel(curves, axis, false);
  };
  errors("deviation max", [](const BinRow& row) { return std::optional(row.deviation_max); });
  if (signal.error) errors(fmt::format("{} RMS", short_name(signal.error->name)).c_str(), signal.error->rms);
  errors("velocity jump", [](const BinRow& row) { return std::optional(row.velocity_jump); });
  const std::vector<Curve> underruns = underrun_curves(signal);
  panel(underruns, {count_range(underruns), "underruns so far", "count"}, true);
}

}  // namespace

std::optional<std::string> error_over_time_svg(const RunRecord& run, const Metrics& metrics) {
  const auto all = bins(run);
  const bool enough = std::any_of(all.begin(), all.end(), [](const auto& s) { return s.second.size() >= kLeastBins; });
  if (!enough) return std::nullopt;
  const Range time_s{0, seconds(run.nominal.end - RealTime{})};
  std::vector<std::pair<const Column*, Signal>> signals;
  for (const Nominal::Device& device : run.nominal.devices) {
    for (const Column& column : kColumns)
      signals.emplace_back(&column, signal_of(run, all, device.name + "." + column.kind));
  }
  const bool any_error =
      std::any_of(signals.begin(), signals.end(), [](const auto& s) { return s.second.error != nullptr; });
  const double block = 60 + kLine * static_cast<double>(run.strategies.size()) + kPanelDistance * (any_error ? 4 : 3);
  const std::vector<std::string> names = internal::in_drawing_order(run);
  const double left = kColumns.front().left, right = kColumns.back().right;
  const double drop = internal::legend_drop(left, right, names), head = kHead + drop;
  internal::Svg svg(kWidth, head + block * static_cast<double>(run.nominal.devices.size()), "Error against run time");
  internal::draw_legend(svg, {left, 44}, right, run, names);
  svg.text({left, 64 + drop}, "growth of the RMS like t^p, in brackets the p that are possible (95 %)",
           internal::Svg::Anchor::start, 11);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    draw_signal(svg, run, metrics, signals[i].second, time_s, *signals[i].first,
                head + block * static_cast<double>(i / kColumns.size()));
  }
  return std::move(svg).finish();
}

}  // namespace evenstep
