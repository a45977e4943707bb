#pragma once
/// Measures of straightness, taken in each of several parts of a series and never across two of them.

#include <span>

#include "evenstep/reports/measures.h"
#include "src/fits/line_fit.h"

namespace evenstep::internal {

/// NaN if no piece has three samples.
double velocity_jump(std::span<const Vec3> x, std::span<const Window> pieces);
/// Over the windows with three samples; NaN if there is none.
Deviation deviation(std::span<const double> t, std::span<const Vec3> x, std::span<const Window> windows);
double band_rms(std::span<const double> t, std::span<const Vec3> x, std::span<const Window> windows, double low_Hz,
                double high_Hz);

}  // namespace evenstep::internal
