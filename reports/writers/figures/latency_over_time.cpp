#include <algorithm>

#include "evenstep/reports/figures.h"
#include "writers/figures/svg.h"

namespace evenstep {
namespace {

using internal::Axis;
using internal::Range;

constexpr double kWidth = 1100, kHead = 64, kPanelHeight = 220, kPanelDistance = 290;
constexpr internal::Stroke kNeed{internal::colour::kSkyBlue, 0.8, ""};
constexpr internal::Stroke kLatency{internal::colour::kVermilion, 2, ""};

struct Curves {
  std::vector<double> t_s, need_s, latency_s;
};

Curves curves_of(const StrategyRecord& strategy) {
  Curves curves;
  for (const StepRow& step : strategy.steps) {
    if (!step.mapped) continue;
    curves.t_s.push_back(seconds(step.begin));
    curves.need_s.push_back(seconds(step.end - step.read));
    curves.latency_s.push_back(seconds(step.emission - step.read));
  }
  return curves;
}

Range range_of(const Curves& curves) {
  Range range{0, 1e-3};
  for (const double need_s : curves.need_s) range.high = std::max(range.high, need_s);
  for (const double latency_s : curves.latency_s) range.high = std::max(range.high, latency_s);
  range.high *= 1.05;
  return range;
}

}  // namespace

std::optional<std::string> latency_over_time_svg(const RunRecord& run) {
  std::vector<const StrategyRecord*> adapting;
  for (const StrategyRecord& strategy : run.strategies) {
    if (strategy.latency.adapts) adapting.push_back(&strategy);
  }
  if (adapting.empty()) return std::nullopt;
  internal::Svg svg(kWidth, kHead + kPanelDistance * static_cast<double>(adapting.size()), "Latency against run time");
  svg.line({86, 50}, {116, 50}, kLatency);
  svg.text({122, 54}, "L(n) = F(n) - R(n), as scheduled");
  svg.line({366, 50}, {396, 50}, kNeed);
  svg.text({402, 54}, "E(n) - R(n), as needed: above the latency a force is late");
  double top = kHead + 24;
  for (const StrategyRecord* strategy : adapting) {
    const Curves curves = curves_of(*strategy);
    svg.text({86, top - 8}, strategy->name, internal::Svg::Anchor::start, 13, true);
    internal::Panel panel(svg, {86, top, kWidth - 14, top + kPanelHeight}, {{0, seconds(run.nominal.end)}, "run time", "s"},
                          {range_of(curves), "latency", "s"});
    panel.draw_axes(true, true);
    panel.curve(curves.t_s, curves.need_s, kNeed);
    panel.curve(curves.t_s, curves.latency_s, kLatency);
    top += kPanelDistance;
  }
  return std::move(svg).finish();
}

}  // namespace evenstep
