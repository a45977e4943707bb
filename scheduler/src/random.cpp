#include "evenstep/scheduler/random.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "evenstep/scheduler/philox.h"
#include "evenstep/time/digest.h"
#include "evenstep/time/reproducible_math.h"

namespace evenstep {
namespace {

struct TwoWords {
  std::uint64_t first, second;
};

/// Block `series` of draw n. Blocks of one n with different `series` are independent.
TwoWords block(std::uint64_t key, std::uint64_t n, std::uint32_t series) {
  const auto low = [](std::uint64_t word) { return static_cast<std::uint32_t>(word); };
  const auto high = [](std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32); };
  const internal::PhiloxBlock out = internal::philox4x32({low(n), high(n), series, 0}, {low(key), high(key)});
  return {out[0] | static_cast<std::uint64_t>(out[1]) << 32, out[2] | static_cast<std::uint64_t>(out[3]) << 32};
}

/// The middle of one of 2^52 equal cells of (0, 1). With 2^53 cells the last middle would round to 1.
double open_unit_interval(std::uint64_t bits) { return (static_cast<double>(bits >> 12) + 0.5) * 0x1p-52; }

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view component) : key_(mix(name_digest(component), seed)) {}

std::uint64_t RandomStream::bits(std::uint64_t n) const { return block(key_, n, 0).first; }

double RandomStream::uniform(std::uint64_t n) const { return open_unit_interval(bits(n)); }

std::uint64_t RandomStream::below(std::uint64_t n, std::uint64_t bound) const {
  assert(bound > 0);
  return static_cast<std::uint64_t>((static_cast<unsigned __int128>(bits(n)) * bound) >> 64);
}

double RandomStream::standard_normal(std::uint64_t n) const {
  constexpr double kTwoPi = 0x1.921fb54442d18p+2;
  const TwoWords words = block(key_, n, 1);
  const double radius = std::sqrt(-2.0 * reproducible::log(open_unit_interval(words.first)));
  return radius * reproducible::cos(kTwoPi * open_unit_interval(words.second));
}

Duration log_normal(const RandomStream& stream, std::uint64_t n, Duration mean, double variation) {
  assert(mean.ns > 0 && variation >= 0);
  if (variation == 0) return mean;
  const double variance = reproducible::log(1.0 + variation * variation);
  const double exponent = std::sqrt(variance) * stream.standard_normal(n) - 0.5 * variance;
  const double ns = static_cast<double>(mean.ns) * reproducible::exp(exponent);
  return {static_cast<std::int64_t>(std::clamp(ns + 0.5, 1.0, 0x1p62))};
}

}  // namespace evenstep
