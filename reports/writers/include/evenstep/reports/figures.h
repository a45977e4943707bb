#pragma once
/// The paper's figures drawn from the data of a run, as SVG: axes with units, a legend, a colour-blind palette plus dashes.
/// Curves are thinned out to the pixels that can be drawn.

#include <optional>
#include <span>
#include <string>

#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep {

/// Figure 1 a: motion of the interaction in simulation time (one curve per strategy), for one device: position along its
/// main axis, and below it the distance from the fitted line in steps. About six segments around the middle of the judged
/// span; where one of `results` fails on this signal, around the worst place of the first such result, which is marked.
std::string figure_1a_svg(const RunRecord& run, const std::string& device, std::span<const ExpectationResult> results = {});
/// Figure 1 b: force in real time at the device's ticks, and below it its distance from the fitted line.
std::string figure_1b_svg(const RunRecord& run, const std::string& device, std::span<const ExpectationResult> results = {});
/// Figures 2 to 4 for one segment of `strategy`: samples of the hand, slots, real steps, emission times, and the lines that
/// join each step to its slot (3 c) and its force to its emission (4 d). The segment is the one in the middle of those
/// judged, or the one of the worst place of the first of `results` that fails for this strategy and device.
std::string figure_2to4_svg(const RunRecord& run, const std::string& strategy, const std::string& device,
                            std::span<const ExpectationResult> results = {});

/// Error over the time of the run, from bins(), for every device and strategy: largest deviation, RMS of another error where
/// it is known, velocity jump (logarithmic) and underruns so far; interaction on the left, force on the right. Above them
/// stands how the errors grow, as `metrics` say. Empty if no signal has ten bins, because there would be little to see.
std::optional<std::string> error_over_time_svg(const RunRecord& run, const Metrics& metrics);

/// An adaptive latency, and the latency that the steps needed, over the time of the run: one panel for each strategy whose
/// latency adapts. Empty if there is none.
std::optional<std::string> latency_over_time_svg(const RunRecord& run);

}  // namespace evenstep
