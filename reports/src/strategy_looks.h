#pragma once
/// How strategies are drawn in every figure that shows several.

#include <string>
#include <vector>

#include "evenstep/reports/run_record.h"
#include "src/svg.h"

namespace evenstep::internal {

/// The strategy's own look, or one that tells it apart from its neighbours.
Stroke look_of(const RunRecord& run, const std::string& strategy);

/// Names in the order of drawing: the reference first (below), the others as they come.
std::vector<std::string> in_drawing_order(const RunRecord& run);

/// One line from `at` on, with room for the eight strategies of the format.
void draw_legend(Svg& svg, Point at, const RunRecord& run, const std::vector<std::string>& strategies);

}  // namespace evenstep::internal
