#pragma once
/// Directions of effects, in turns.

#include <algorithm>
#include <cmath>

#include "evenstep/time/reproducible_math.h"

namespace evenstep::internal {

/// The sine of an angle in turns, exact at quarter turns.
inline double sin_of_turn(double turns) {
  constexpr double kPi = 3.14159265358979323846;
  const double within = turns - std::floor(turns);
  const double half = within < 0.5 ? within : within - 0.5;
  const double value = reproducible::sin(kPi * 2 * std::min(half, 0.5 - half));
  return within < 0.5 ? value : -value;
}

}  // namespace evenstep::internal
