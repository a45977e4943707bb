#pragma once
/// A counter-based random stream keyed by (seed, component name). Draw n belongs to step n and does not depend on the order
/// of drawing, so a draw in one component never shifts the draws of another. Distributions use only arithmetic that
/// IEEE 754 defines exactly (evenstep/time/reproducible_math.h), because std::*_distribution and libm give different results
/// with different libraries.
///
/// The generator is Philox4x32-10 (philox.h). `bits`, `uniform` and `below` of the same n use the same 64 bits;
/// `standard_normal` of that n has bits of its own.

#include <cstdint>
#include <string_view>

#include "evenstep/time/time.h"

namespace evenstep {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view component);
  std::uint64_t bits(std::uint64_t n) const;  ///< 64 uniform bits of draw n
  double uniform(std::uint64_t n) const;      ///< in (0, 1): an odd multiple of 2^-53, so never 0 or 1
  /// Uniform in [0, bound), bound > 0; its bias is at most 2^-64 * bound.
  std::uint64_t below(std::uint64_t n, std::uint64_t bound) const;
  double standard_normal(std::uint64_t n) const;  ///< Box-Muller; |z| < 8.6

 private:
  std::uint64_t key_;
};

/// A log-normal draw with the given mean: E[X] = mean, sd[X] / E[X] = variation (a coefficient of variation, "10 %" = 0.1).
/// X = mean * exp(s z - s^2 / 2), s^2 = log(1 + variation^2). Rounded to ns, at least 1 ns, at most 2^62 ns.
/// variation = 0 gives mean.
Duration log_normal(const RandomStream& stream, std::uint64_t n, Duration mean, double variation);

}  // namespace evenstep
