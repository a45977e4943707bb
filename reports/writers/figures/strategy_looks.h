#pragma once
/// How strategies are drawn in every figure that shows several.

#include <string>
#include <vector>

#include "evenstep/reports/run_record.h"
#include "writers/figures/svg.h"

namespace evenstep::internal {

/// The strategy's own look, or else one that tells it apart from its neighbours.
Stroke look_of(const RunRecord& run, const std::string& strategy);

/// Names in the order of drawing: the reference first, so that it lies below, the others as they come.
std::vector<std::string> in_drawing_order(const RunRecord& run);

/// A legend between two x, in as many lines as it takes, from the line at `at.y` down.
constexpr double kLegendLine_px = 18;
void draw_legend(Svg& svg, Point at, double right, const RunRecord& run, const std::vector<std::string>& strategies);
/// How much lower the legend's last line is than its first; 0 for a legend of one line.
double legend_drop(double left, double right, const std::vector<std::string>& strategies);

}  // namespace evenstep::internal
