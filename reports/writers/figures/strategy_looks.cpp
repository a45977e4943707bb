#include "writers/figures/strategy_looks.h"

#include <algorithm>
#include <array>

namespace evenstep::internal {
namespace {

/// A line of 34 px, a gap, and the name: at 12 px no letter of a strategy's name is wider than 7.6 px on average.
double name_end(double x, const std::string& strategy) { return x + 40 + 7.6 * static_cast<double>(strategy.size()); }
constexpr double kBetweenEntries_px = 22;

/// Where each entry begins, line by line. A name that is wider than the legend has a line of its own.
std::vector<Point> places(Point at, double right, const std::vector<std::string>& strategies) {
  std::vector<Point> all;
  Point next = at;
  for (const std::string& strategy : strategies) {
    if (next.x > at.x && name_end(next.x, strategy) > right) next = {at.x, next.y + kLegendLine_px};
    all.push_back(next);
    next.x = name_end(next.x, strategy) + kBetweenEntries_px;
  }
  return all;
}

constexpr std::array kOtherLooks = std::to_array<Stroke>({{colour::kGreen, 2, "9 4", 1}, {colour::kGrey, 2, "4 4", 1}});

}  // namespace

Stroke look_of(const RunRecord& run, const std::string& strategy) {
  const auto named = [&](const StrategyRecord& record) { return record.name == strategy; };
  const auto found = std::find_if(run.strategies.begin(), run.strategies.end(), named);
  const auto index = static_cast<std::size_t>(found - run.strategies.begin());
  if (found == run.strategies.end() || found->look.colour.empty()) return kOtherLooks[index % kOtherLooks.size()];
  return {found->look.colour.c_str(), found->look.width, found->look.dash.c_str(), 1};
}

std::vector<std::string> in_drawing_order(const RunRecord& run) {
  std::vector<std::string> names;
  for (const bool reference : {true, false}) {
    for (const StrategyRecord& strategy : run.strategies) {
      if (strategy.reference == reference) names.push_back(strategy.name);
    }
  }
  return names;
}

void draw_legend(Svg& svg, Point at, double right, const RunRecord& run, const std::vector<std::string>& strategies) {
  const std::vector<Point> begins = places(at, right, strategies);
  for (std::size_t i = 0; i < strategies.size(); ++i) {
    const auto [x, y] = begins[i];
    svg.line({x, y}, {x + 34, y}, look_of(run, strategies[i]));
    svg.text({x + 40, y + 4}, strategies[i]);
  }
}

double legend_drop(double left, double right, const std::vector<std::string>& strategies) {
  return strategies.empty() ? 0 : places({left, 0}, right, strategies).back().y;
}

}  // namespace evenstep::internal
