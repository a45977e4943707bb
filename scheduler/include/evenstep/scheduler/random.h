#pragma once
/// A counter-based random stream keyed by (seed, component name): draw n belongs to step n, not to the order of drawing,
/// so a draw in one component never shifts another's. Distributions use IEEE-exact arithmetic only
/// (evenstep/time/reproducible_math.h): std::*_distribution and libm are not reproducible across libraries.
///
/// The generator is Philox4x32-10 (philox.h). `bits`, `uniform` and `below` of one n are views of the same 64 bits;
/// `standard_normal` of that n has bits of its own.

#include <cstdint>
#include <string_view>

#include "evenstep/time/time.h"

namespace evenstep {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view component);
  std::uint64_t bits(std::uint64_t n) const;               ///< 64 uniform bits of draw n
  double uniform(std::uint64_t n) const;                   ///< (0, 1): odd multiples of 2^-53, so never 0, never 1
  /// Uniform in [0, bound), bound > 0, no modulo bias beyond 2^-64 * bound.
  std::uint64_t below(std::uint64_t n, std::uint64_t bound) const;
  double standard_normal(std::uint64_t n) const;           ///< Box-Muller; |z| < 8.6

 private:
  std::uint64_t key_;
};

/// Mean-preserving log-normal: E[X] = mean, sd[X] / E[X] = variation (a coefficient of variation, "10 %" = 0.1).
/// X = mean * exp(s z - s^2 / 2), s^2 = log(1 + variation^2). Rounded to ns, at least 1 ns, at most 2^62 ns.
/// variation = 0 gives mean.
Duration log_normal(const RandomStream& stream, std::uint64_t n, Duration mean, double variation);

}  // namespace evenstep
