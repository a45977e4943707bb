// Latency against velocity jump: what any path needs, what each map needs.
#include <algorithm>
#include <cmath>

#include "evenstep/reports/size_record.h"
#include "writers/figures/svg.h"

namespace evenstep {
namespace {

using internal::Axis;
using internal::Panel;
using internal::Point;
using internal::Range;
using internal::Stroke;
using internal::Svg;

constexpr double kWidth = 760, kHeight = 460;
constexpr internal::Box kPlot{80, 50, 560, 400};
constexpr double kLegend = 580;       // left edge
constexpr double kLeastJump = 0.001;  // the jump of a line, which is 0, and any smaller jump are shown here

double at_jump(double jump) { return std::log10(std::max(jump, kLeastJump)); }
double at_latency(Duration latency) { return std::log10(std::max(seconds(latency), 1e-6) * 1e3); }

/// Whole decades around some values.
Range decades(const std::vector<double>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return {std::floor(*least), std::max(std::ceil(*most + 0.01), std::floor(*least) + 1)};
}

}  // namespace

std::string size_svg(const SizeRecord& record) {
  const SizeBounds& bounds = record.linear ? *record.linear : record.held;
  if (bounds.paths.empty()) return "";
  std::vector<double> jumps{at_jump(0)}, latencies{at_latency(bounds.best_line.latency)};
  for (const SizePath& path : bounds.paths) {
    jumps.push_back(at_jump(path.jump));
    latencies.push_back(at_latency(path.latency));
  }
  std::vector<double> all_jumps = jumps, all = latencies;
  all.push_back(at_latency(bounds.pause));
  for (const SizeStrategy& strategy : record.strategies) {
    all_jumps.push_back(at_jump(strategy.velocity_jump));
    all.push_back(at_latency(strategy.any_phase.latency));
  }
  Svg svg(kWidth, kHeight, "Least latency against velocity jump");
  const Range x = decades(all_jumps), y = decades(all);
  Panel panel(svg, kPlot, Axis{x, "velocity jump (0.001: none)", "step", true}, Axis{y, "latency", "ms", true});
  panel.draw_axes(true, true);
  panel.curve(jumps, latencies, {internal::colour::kBlack, 2});
  const double pause = at_latency(bounds.pause);
  panel.curve({x.low, x.high}, {pause, pause}, {internal::colour::kGrey, 1.5, "6 4"});
  double row = 70;
  const auto legend = [&](const std::string& text, const Stroke& stroke, bool dot) {
    if (dot)
      svg.dot({kLegend + 12, row - 4}, 5, stroke.colour);
    else
      svg.line({kLegend, row - 4}, {kLegend + 24, row - 4}, stroke);
    svg.text({kLegend + 32, row}, text);
    row += 22;
  };
  legend("any path", {internal::colour::kBlack, 2}, false);
  legend("pause bound", {internal::colour::kGrey, 1.5, "6 4"}, false);
  constexpr const char* kColours[]{internal::colour::kSkyBlue, internal::colour::kVermilion, internal::colour::kGreen,
                                   internal::colour::kGrey};
  for (std::size_t i = 0; i < record.strategies.size(); ++i) {
    const SizeStrategy& strategy = record.strategies[i];
    const char* colour = kColours[std::min(i, std::size(kColours) - 1)];
    svg.dot(panel.at(at_jump(strategy.velocity_jump), at_latency(strategy.any_phase.latency)), 5, colour);
    legend(strategy.name, {colour}, true);
  }
  return std::move(svg).finish();
}

}  // namespace evenstep
