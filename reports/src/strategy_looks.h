#pragma once
/// How each strategy is drawn in every figure that shows several.

#include <cstddef>
#include <string>
#include <vector>

#include "src/svg.h"

namespace evenstep::internal {

/// Curves that lie on each other must all be seen: broad and pale below, thin and dark on top. `index` tells apart
/// strategies that have no look of their own.
Stroke look_of(const std::string& strategy, std::size_t index);

/// `ideal` first (below), the others in their order.
void ideal_first(std::vector<std::string>& strategies);

/// One line from `at` on: room for the eight strategies of the design.
void draw_legend(Svg& svg, Point at, const std::vector<std::string>& strategies);

}  // namespace evenstep::internal
