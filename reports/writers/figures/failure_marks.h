#pragma once
/// Where an expectation fails, in the figures.

#include <span>
#include <string>

#include "evenstep/reports/verdict.h"
#include "writers/figures/svg.h"

namespace evenstep::internal {

/// The first result that fails on the signal `kind` of this device ("interaction", "force"), or on its buffers, at a known
/// place; null if there is none. Its `first` and `worst` have values.
const ExpectationResult* failed_on(std::span<const ExpectationResult> results, const std::string& device,
                                   const std::string& kind);

/// A place on the time axis.
struct Mark {
  double at = 0;
  std::string text;
};
/// A line across the picture at `x`, with its text beside it at `text_y`.
void draw_mark(Svg& svg, double x, const Box& box, double text_y, const std::string& text);

}  // namespace evenstep::internal
