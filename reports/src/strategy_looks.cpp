#include "src/strategy_looks.h"

#include <algorithm>
#include <array>

namespace evenstep::internal {
namespace {

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

void draw_legend(Svg& svg, Point at, const RunRecord& run, const std::vector<std::string>& strategies) {
  for (const std::string& strategy : strategies) {
    svg.line(at, {at.x + 34, at.y}, look_of(run, strategy));
    svg.text({at.x + 40, at.y + 4}, strategy);
    at.x += 62 + 7.6 * static_cast<double>(strategy.size());
  }
}

}  // namespace evenstep::internal
