#pragma once
/// The springs of a device that plays effects, in N/m, for drivers and simulated devices alike. `Options` contain the
/// travel, the full scale, and the slope if it is known.

#include <algorithm>
#include <limits>

namespace evenstep::internal {

/// The slope of the largest coefficient at full gain: as given, or the full scale over half the travel.
template <class Options>
double full_slope_N_per_m(const Options& options, int axis) {
  return options.full_slope_N_per_m ? (*options.full_slope_N_per_m)[axis]
                                    : *options.full_scale_N / (options.travel_m[axis] / 2);
}

/// The stiffest spring that a device can render by itself on every used axis among the first `axes`.
template <class Options>
double steepest_spring_N_per_m(const Options& options, int axes) {
  double least_N_per_m = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < axes; ++axis) {
    if (options.travel_m[axis] > 0)
      least_N_per_m = std::min(least_N_per_m, full_slope_N_per_m(options, axis) * options.gain);
  }
  return least_N_per_m;
}

/// The slope of the largest coefficient in a simulated device's own unit: full scales per half travel.
template <class Options>
double full_steepness(const Options& options, int axis) {
  if (!options.full_slope_N_per_m) return 1;
  return (*options.full_slope_N_per_m)[axis] * (options.travel_m[axis] / 2) / options.full_scale_N;
}

}  // namespace evenstep::internal
