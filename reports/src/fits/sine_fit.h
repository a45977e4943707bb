#pragma once
/// Frequency response at one frequency: the least-squares sine of a signal whose sine motion is known.

#include <span>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// How a signal follows u(t) = (1 - cos(2 pi f (t - begin))) / 2. Values that cannot be determined are NaN.
struct SineFit {
  double travel = 0;      ///< peak to peak of the fitted sine, in the signal's unit; gain = this / the expected travel
  double delay_s = 0;     ///< of the fitted sine relative to u, in (-1 / 2f, 1 / 2f]: a phase does not show whole periods
  double distortion = 0;  ///< RMS of the residual / RMS of the fitted sine
};

/// Fits a + b cos + c sin of 2 pi f (t - begin) to the component of `x` along `direction` (of any length except 0). The
/// period need not divide the span; an exact sine is found exactly. All values are NaN for less than one period (a drift
/// could not be told from the sine) and if the samples cannot show the frequency (two or fewer per period).
/// Its intermediate columns are kept with the rows of `beside`.
SineFit fit_sine(std::span<const double> t_s, std::span<const Vec3> x, const Vec3& direction, double frequency_Hz,
                 double begin_s, const RowAllocator<double>& beside = {});

}  // namespace evenstep::internal
