#include <algorithm>
#include <array>
#include <cmath>

#include "evenstep/reports/figures.h"
#include "evenstep/reports/measures.h"
#include "src/fits/line_fit.h"
#include "src/judged.h"
#include "writers/figures/failure_marks.h"
#include "writers/figures/strategy_looks.h"
#include "writers/figures/svg.h"

namespace evenstep {
namespace {

using internal::Axis;
using internal::Range;

// For a legend of one line; further lines move the panels down.
constexpr double kWidth = 900, kHeight = 600, kLegend = 44;
constexpr internal::Box kUpper{86, 62, 880, 310}, kLower{86, 346, 880, 550};
internal::Box lowered(internal::Box box, double by) {
  box.top += by;
  box.bottom += by;
  return box;
}
constexpr std::int64_t kSegmentsShown = 6;

/// One strategy's signal over the shown span.
struct Curve {
  std::string strategy;
  bool reference = false;
  std::vector<double> t_s;
  std::vector<Vec3> value;
  std::vector<Vec3> residual;
};

struct Span {
  RealTime from, to;
  bool holds(RealTime t) const { return t >= from && t < to; }
};
Span shown_span(const Nominal& nominal, const ExpectationResult* failed) {
  const RealTime middle =
      failed ? failed->worst->at : nominal.judged_from + Duration{(nominal.end - nominal.judged_from).ns / 2};
  const Duration half{nominal.segment.ns * kSegmentsShown / 2};
  return {std::max(middle - half, nominal.judged_from), std::min(middle + half, nominal.end)};
}

/// The axis along which the curves reach farthest.
std::size_t main_axis(const std::vector<Curve>& curves) {
  std::array<double, 3> extent{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = INFINITY, high = -INFINITY;
    for (const Curve& curve : curves) {
      for (const Vec3& value : curve.value) {
        low = std::min(low, value[axis]);
        high = std::max(high, value[axis]);
      }
    }
    extent[axis] = high - low;
  }
  return static_cast<std::size_t>(std::max_element(extent.begin(), extent.end()) - extent.begin());
}

std::vector<double> along(const std::vector<Vec3>& values, std::size_t axis, double unit = 1) {
  std::vector<double> result;
  for (const Vec3& value : values) result.push_back(value[axis] / unit);
  return result;
}

struct Panels {
  std::string title, x_name, y_name, unit;
  std::optional<double> step;  ///< the unit of the lower panel
};

Range range_of(const std::vector<Curve>& curves, std::size_t axis, double unit, bool residual) {
  std::vector<double> all;
  for (const Curve& curve : curves) {
    const std::vector<double> values = along(residual ? curve.residual : curve.value, axis, unit);
    all.insert(all.end(), values.begin(), values.end());
  }
  return Range::around(all, 0.08);
}

std::string draw(const RunRecord& run, std::vector<Curve> curves, const Panels& panels,
                 const std::vector<internal::Mark>& marks) {
  std::erase_if(curves, [](const Curve& curve) { return curve.value.size() < 3; });
  std::stable_partition(curves.begin(), curves.end(), [](const Curve& curve) { return curve.reference; });
  std::vector<std::string> names;
  for (const Curve& curve : curves) names.push_back(curve.strategy);
  const double drop = internal::legend_drop(kUpper.left, kUpper.right, names);
  const internal::Box upper_box = lowered(kUpper, drop), lower_box = lowered(kLower, drop);
  internal::Svg svg(kWidth, kHeight + drop, panels.title);
  if (curves.empty()) {
    svg.text({kWidth / 2, kHeight / 2}, "nothing was judged in this run", internal::Svg::Anchor::middle, 14);
    return std::move(svg).finish();
  }
  std::vector<double> times;
  for (Curve& curve : curves) {
    curve.residual = internal::line_residual(curve.t_s, curve.value);
    times.insert(times.end(), curve.t_s.begin(), curve.t_s.end());
  }
  const std::size_t axis = main_axis(curves);
  const double unit = panels.step.value_or(1);
  const Axis time{Range::around(times, 0), panels.x_name, "s"};
  internal::Panel upper(svg, upper_box, time, {range_of(curves, axis, 1, false), panels.y_name, panels.unit});
  internal::Panel lower(svg, lower_box, time,
                        {range_of(curves, axis, unit, true), "off the fitted line", panels.step ? "step" : panels.unit});
  upper.draw_axes(false, false);
  lower.draw_axes(true, true);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    upper.curve(curves[i].t_s, along(curves[i].value, axis), internal::look_of(run, curves[i].strategy));
    lower.curve(curves[i].t_s, along(curves[i].residual, axis, unit), internal::look_of(run, curves[i].strategy));
  }
  for (const internal::Mark& mark : marks)
    internal::draw_mark(svg, upper.x_at(mark.at), {kUpper.left, upper_box.top, kUpper.right, lower_box.bottom},
                        (upper_box.bottom + lower_box.top) / 2 + 4, mark.text);
  internal::draw_legend(svg, {kUpper.left, kLegend}, kUpper.right, run, names);
  return std::move(svg).finish();
}

const DeviceRecord* find(const StrategyRecord& strategy, const std::string& device) {
  const auto found = std::find_if(strategy.devices.begin(), strategy.devices.end(),
                                  [&](const DeviceRecord& d) { return d.name == device; });
  return found == strategy.devices.end() ? nullptr : &*found;
}

/// The first and the worst place of a failure, if they are in the picture; `x_of` gives a place's value on the axis.
template <class XOf>
std::vector<internal::Mark> marks_of(const ExpectationResult* failed, const Span& span, XOf x_of) {
  std::vector<internal::Mark> marks;
  if (!failed) return marks;
  const bool one = failed->first->at == failed->worst->at;
  if (!one && span.holds(failed->first->at)) marks.push_back({x_of(*failed->first), "first failure"});
  if (span.holds(failed->worst->at)) marks.push_back({x_of(*failed->worst), one ? "failure" : "worst failure"});
  return marks;
}

/// The simulation time of the step at which an expectation on the interaction fails.
double simulated_at(const RunRecord& run, const ExpectationResult& failed, const FailurePlace& place) {
  for (const StrategyRecord& strategy : run.strategies) {
    if (failed.signal.ends_with('.' + strategy.name))
      return internal::simulation_time_s(strategy, static_cast<std::size_t>(place.index), run.nominal.slot_s);
  }
  return seconds(place.at);
}

}  // namespace

std::string figure_1a_svg(const RunRecord& run, const std::string& device, std::span<const ExpectationResult> results) {
  const ExpectationResult* const failed = internal::failed_on(results, device, "interaction");
  const Span span = shown_span(run.nominal, failed);
  std::vector<Curve> curves;
  for (const StrategyRecord& strategy : run.strategies) {
    Curve curve{strategy.name, strategy.reference, {}, {}, {}};
    const DeviceRecord* record = find(strategy, device);
    for (const std::size_t n : internal::judged_steps(strategy, run.nominal)) {
      if (!record || !span.holds(strategy.steps[n].begin)) continue;
      curve.t_s.push_back(internal::simulation_time_s(strategy, n, run.nominal.slot_s));
      curve.value.push_back(record->steps.at(n).position_m);
    }
    curves.push_back(std::move(curve));
  }
  return draw(run, std::move(curves),
              {"Motion of the interaction in simulation time: " + device, "simulation time", "position", "m",
               step_unit(run.nominal, device + ".interaction.any")},
              marks_of(failed, span, [&](const FailurePlace& place) { return simulated_at(run, *failed, place); }));
}

std::string figure_1b_svg(const RunRecord& run, const std::string& device, std::span<const ExpectationResult> results) {
  const ExpectationResult* const failed = internal::failed_on(results, device, "force");
  const Span span = shown_span(run.nominal, failed);
  std::vector<Curve> curves;
  for (const StrategyRecord& strategy : run.strategies) {
    Curve curve{strategy.name, strategy.reference, {}, {}, {}};
    if (const DeviceRecord* record = find(strategy, device)) {
      for (const std::size_t k : internal::judged_ticks(*record, run.nominal)) {
        const TickRow& tick = record->ticks[k];
        if (!span.holds(tick.at)) continue;
        curve.t_s.push_back(seconds(internal::sent_at(tick)));
        curve.value.push_back(tick.force_N);
      }
    }
    curves.push_back(std::move(curve));
  }
  return draw(run, std::move(curves),
              {"Force in real time at the device's ticks: " + device, "real time", "force", "N",
               step_unit(run.nominal, device + ".force.any")},
              marks_of(failed, span, [](const FailurePlace& place) { return seconds(place.at); }));
}

}  // namespace evenstep
