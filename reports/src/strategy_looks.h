#pragma once
/// How each strategy is drawn in figures that show several strategies.

#include <cstddef>
#include <string>
#include <vector>

#include "src/svg.h"

namespace evenstep::internal {

/// Curves that coincide must all be visible, so they are broad and pale below, thin and dark on top. `index` distinguishes
/// strategies that have no style of their own.
Stroke look_of(const std::string& strategy, std::size_t index);

/// Puts `ideal` first, so that it is drawn below the others, which keep their order.
void ideal_first(std::vector<std::string>& strategies);

/// Draws the legend as one line from `at` on, with room for eight strategies.
void draw_legend(Svg& svg, Point at, const std::vector<std::string>& strategies);

}  // namespace evenstep::internal
