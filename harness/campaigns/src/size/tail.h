#pragma once
/// What is rarer than a recording is long: a tail fitted to the largest values (peaks over threshold).
///
/// Above a high enough level u, values of nearly any distribution exceed it by a generalised Pareto law (Pickands, Ann.
/// Stat. 3, 1975): P(X > u + y) = z (1 + s y / w)^(-1/s), with z the share above u, w the scale and s the shape. s < 0:
/// there is a largest value; s = 0: exponential; s >= 1: not even a mean. The value that a share p exceeds is
///   u + w/s ((z/p)^s - 1).
/// Its upper bound is the largest one within the region of (z, w, s) whose log-likelihood is less than t^2/2 below the
/// maximum, t the quantile of Student's t at the confidence with m/D - 2 degrees of freedom: the profile likelihood bound
/// (Coles, An Introduction to Statistical Modeling of Extreme Values, 2001, 4.3.3), with t for chi because m is small. The m
/// values above u are not independent: the log-likelihood is divided by D of "above u" (trust.h), which keeps all of them in
/// the fit instead of one a cluster (Fawcett and Walshaw, Water Resour. Res. 48, 2012).
///
/// u is the level of the lowest of some candidates whose exceedances fit: Cramer and von Mises' W^2 over D below its 90 %
/// point for a fitted generalised Pareto law. The first candidate has min(n / 10, n^(2/3)) values above it, the others
/// seven tenths each, while m / D >= 30.

#include <cstdint>
#include <optional>
#include <span>

namespace evenstep::internal {

struct Tail {
  double level = 0;                  ///< u
  std::int64_t exceedances = 0;      ///< m
  double alike = 1;                  ///< D
  double shape = 0, scale = 1;       ///< s and w, most likely
  double shape_at_most = 0;          ///< largest in the region; at kHeaviest it is not bounded
  double estimate = 0, at_most = 0;  ///< of the value that a share p exceeds: most likely, and its upper bound
};
inline constexpr double kHeaviest = 1;           ///< with such a shape a recording bounds nothing
inline constexpr double kLeastExceedances = 30;  ///< m / D

/// Empty: no candidate fits, or there are too few values for one (fewer than 300 D).
std::optional<Tail> tail_of(std::span<const double> values, double share, double confidence);

}  // namespace evenstep::internal
