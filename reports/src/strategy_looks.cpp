#include "src/strategy_looks.h"

#include <algorithm>
#include <array>

namespace evenstep::internal {
namespace {

struct Look {
  const char* strategy;
  Stroke stroke;
};
constexpr std::array kLooks = std::to_array<Look>({{"ideal", {"#c4c4c4", 7, "", 1}},
                                                   {"direct", {colour::kVermilion, 1.6, "", 1}},
                                                   {"paper", {colour::kSkyBlue, 3.4, "14 6", 1}},
                                                   {"phase_locked", {colour::kBlack, 1.6, "2 4", 1}},
                                                   {"predict", {colour::kPurple, 2, "12 4 2 4", 1}},
                                                   {"filtered", {colour::kOrange, 2, "6 3", 1}},
                                                   {"variable_step", {colour::kBlue, 2, "1 3", 1}}});
constexpr std::array kOtherLooks = std::to_array<Stroke>({{colour::kGreen, 2, "9 4", 1}, {colour::kGrey, 2, "4 4", 1}});

}  // namespace

Stroke look_of(const std::string& strategy, std::size_t index) {
  for (const Look& look : kLooks) {
    if (strategy == look.strategy) return look.stroke;
  }
  return kOtherLooks[index % kOtherLooks.size()];
}

void ideal_first(std::vector<std::string>& strategies) {
  std::stable_partition(strategies.begin(), strategies.end(), [](const std::string& name) { return name == "ideal"; });
}

void draw_legend(Svg& svg, Point at, const std::vector<std::string>& strategies) {
  for (std::size_t i = 0; i < strategies.size(); ++i) {
    svg.line(at, {at.x + 34, at.y}, look_of(strategies[i], i));
    svg.text({at.x + 40, at.y + 4}, strategies[i]);
    at.x += 62 + 7.6 * static_cast<double>(strategies[i].size());
  }
}

}  // namespace evenstep::internal
