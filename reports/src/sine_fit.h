#pragma once
/// Frequency response at one frequency: the least-squares sine of a signal whose sine motion is known.

#include <span>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// How a signal follows u(t) = (1 - cos(2 pi f (t - begin))) / 2. NaN where it cannot be told.
struct SineFit {
  double travel = 0;      ///< peak to peak of the fitted sine, in the signal's unit: the gain is this over the one expected
  double delay_s = 0;     ///< of the fitted sine behind u, in (-1 / 2f, 1 / 2f]: a phase knows no whole periods
  double distortion = 0;  ///< RMS of what the fit leaves / RMS of the fitted sine
};

/// Fits a + b cos + c sin of 2 pi f (t - begin) to the component of `x` along `direction` (any length but 0; against it
/// counts as negative). The period need not divide the span; an exact sine is found exactly. All NaN below one period (a
/// drift could not be told from the sine) and where the samples do not show the frequency (two or fewer per period).
SineFit fit_sine(std::span<const double> t_s, std::span<const Vec3> x, const Vec3& direction, double frequency_Hz,
                 double begin_s);

}  // namespace evenstep::internal
