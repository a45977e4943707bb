// The generator is deterministic, so these tests always pass or always fail. Bounds are 5 standard errors of the statistic,
// or 6 where thousands of values are looked at. A good generator misses them for one seed in a million, a bad one for every
// seed.

#include "evenstep/scheduler/random.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.h"
#include "evenstep/scheduler/philox.h"
#include "evenstep/time/digest.h"

using namespace evenstep;

namespace {

constexpr std::uint64_t kDraws = 1'000'000;

/// (chi-square - degrees of freedom) / its standard deviation, for equally likely cells.
double chi_square_deviation(const std::vector<std::uint64_t>& counts, std::uint64_t draws) {
  const double expected = static_cast<double>(draws) / static_cast<double>(counts.size());
  double chi_square = 0;
  for (const std::uint64_t count : counts) chi_square += std::pow(static_cast<double>(count) - expected, 2) / expected;
  const double freedom = static_cast<double>(counts.size() - 1);
  return (chi_square - freedom) / std::sqrt(2 * freedom);
}

/// The mean product of two standardised sequences, in standard errors that it has for independent ones.
template <class First, class Second>
double correlation_deviation(std::uint64_t draws, First first, Second second) {
  double sum = 0;
  for (std::uint64_t n = 0; n < draws; ++n) sum += first(n) * second(n);
  return sum / std::sqrt(static_cast<double>(draws));
}

auto standardised_uniform(const RandomStream& stream, std::uint64_t shift = 0) {
  return [stream, shift](std::uint64_t n) { return (stream.uniform(n + shift) - 0.5) * std::sqrt(12.0); };
}

/// For each pair of an input bit and an output bit, flipping one should flip the other with probability 1/2. This is the
/// largest deviation from that, in standard errors.
template <class Word, class FlippedWord>
double avalanche_deviation(int samples, Word word, FlippedWord flipped_word) {
  double worst = 0;
  for (int input = 0; input < 64; ++input) {
    std::vector<int> flips(64);
    for (int sample = 0; sample < samples; ++sample) {
      const std::uint64_t difference = word(sample) ^ flipped_word(sample, std::uint64_t{1} << input);
      for (int output = 0; output < 64; ++output) flips[output] += (difference >> output) & 1;
    }
    for (const int count : flips) worst = std::max(worst, std::abs(count - samples / 2.0) / (std::sqrt(samples) / 2));
  }
  return worst;
}

}  // namespace

TEST_CASE("philox4x32 gives the numbers of its authors' known-answer tests") {
  using internal::philox4x32;
  using internal::PhiloxBlock;
  // Random123, tests/kat_vectors, "philox4x32 10": all zeros, all ones, the digits of pi.
  CHECK(philox4x32({0, 0, 0, 0}, {0, 0}) == PhiloxBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  constexpr std::uint32_t kOnes = 0xffffffff;
  CHECK(philox4x32({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}) ==
        PhiloxBlock{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        PhiloxBlock{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("every one of the 64 bits is set in half of the draws") {
  const RandomStream stream(1, "bits");
  std::vector<std::int64_t> ones(64);
  for (std::uint64_t n = 0; n < kDraws; ++n) {
    const std::uint64_t word = stream.bits(n);
    for (int bit = 0; bit < 64; ++bit) ones[bit] += (word >> bit) & 1;
  }
  for (int bit = 0; bit < 64; ++bit) {
    INFO("bit " << bit);
    CHECK(std::abs(ones[bit] - 500'000.0) < 5 * 500);  // sqrt(10^6) / 2 = 500
  }
}

TEST_CASE("flipping one bit of the draw's number or of the seed flips every output bit half of the time") {
  const RandomStream stream(1, "avalanche");
  const auto by_number = avalanche_deviation(
      2'000, [&](int sample) { return stream.bits(sample); },
      [&](int sample, std::uint64_t flip) { return stream.bits(sample ^ flip); });
  const auto by_seed = avalanche_deviation(
      2'000, [](int sample) { return RandomStream(sample, "avalanche").bits(7); },
      [](int sample, std::uint64_t flip) { return RandomStream(sample ^ flip, "avalanche").bits(7); });
  CHECK(by_number < 6);
  CHECK(by_seed < 6);
}

TEST_CASE("neighbouring draws, seeds and names are not correlated") {
  const RandomStream stream(1, "timing.step");
  for (const std::uint64_t shift : {1, 2, 3, 4, 8, 15, 16, 64, 1'000, 1 << 20}) {
    INFO("shift " << shift);
    CHECK(std::abs(correlation_deviation(kDraws / 4, standardised_uniform(stream), standardised_uniform(stream, shift))) <
          5);
  }
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    INFO("seeds " << seed << " and " << seed + 1);
    const RandomStream first(seed, "timing.step"), second(seed + 1, "timing.step");
    CHECK(std::abs(correlation_deviation(kDraws / 10, standardised_uniform(first), standardised_uniform(second))) < 5);
  }
  for (const char* name : {"", "timing.ste", "timing.step2", "timing.stepp", "timing.visualization", "pets.gnimit"}) {
    INFO("name " << name);
    const RandomStream other(1, name);
    CHECK(std::abs(correlation_deviation(kDraws / 10, standardised_uniform(stream), standardised_uniform(other))) < 5);
  }
}

TEST_CASE("2 million draws of 20 seeds and 5 names are all different words", "[sweep]") {
  // Birthday bound for 64-bit words: 2e6^2 / 2^65 = 1e-7.
  std::vector<std::uint64_t> words;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const char* name : {"a", "b", "ab", "ba", ""}) {
      const RandomStream stream(seed, name);
      for (std::uint64_t n = 0; n < 20'000; ++n) words.push_back(stream.bits(n));
    }
  }
  std::sort(words.begin(), words.end());
  CHECK(std::adjacent_find(words.begin(), words.end()) == words.end());
}

TEST_CASE("uniform has the mean, the variance and the evenness of a uniform variable, and stays inside (0, 1)") {
  const RandomStream stream(1, "uniform");
  double sum = 0, sum_of_squares = 0, smallest = 1, largest = 0;
  std::vector<std::uint64_t> cells(1'024);
  for (std::uint64_t n = 0; n < kDraws; ++n) {
    const double u = stream.uniform(n);
    sum += u;
    sum_of_squares += (u - 0.5) * (u - 0.5);
    smallest = std::min(smallest, u);
    largest = std::max(largest, u);
    ++cells[static_cast<std::size_t>(u * 1'024)];
  }
  CHECK(std::abs(sum / kDraws - 0.5) < 5 * std::sqrt(1.0 / 12 / kDraws));
  CHECK(std::abs(sum_of_squares / kDraws - 1.0 / 12) <
        5 * std::sqrt(1.0 / 180 / kDraws));  // Var[(u - 1/2)^2] = 1/80 - 1/144
  CHECK(std::abs(chi_square_deviation(cells, kDraws)) < 5);
  CHECK(smallest > 0);
  CHECK(largest < 1);
}

TEST_CASE("below is even over every bound and reaches no further") {
  for (const std::uint64_t bound : {2, 3, 5, 7, 10, 15, 64, 1'000}) {
    INFO("bound " << bound);
    const RandomStream stream(bound, "below");
    std::vector<std::uint64_t> counts(bound);
    for (std::uint64_t n = 0; n < kDraws / 10; ++n) ++counts.at(stream.below(n, bound));
    const double expected = static_cast<double>(kDraws) / 10 / static_cast<double>(bound);
    for (const std::uint64_t count : counts)
      CHECK(std::abs(static_cast<double>(count) - expected) < 6 * std::sqrt(expected));
  }
  const RandomStream stream(1, "below");
  int outside = 0;
  for (std::uint64_t n = 0; n < 10'000; ++n) {
    for (const std::uint64_t bound : {std::uint64_t{1}, (std::uint64_t{1} << 63) + 1, UINT64_MAX})
      outside += stream.below(n, bound) >= bound;
  }
  CHECK(outside == 0);
}

TEST_CASE("standard_normal has the first four moments of the normal distribution") {
  const RandomStream stream(1, "normal");
  double moments[5] = {};
  for (std::uint64_t n = 0; n < kDraws; ++n) {
    const double z = stream.standard_normal(n);
    double power = 1;
    for (int order = 1; order <= 4; ++order) moments[order] += power *= z;
  }
  for (double& moment : moments) moment /= kDraws;
  // Var[z^k] = E[z^2k] - E[z^k]^2: 1, 3 - 1, 15, 105 - 9.
  CHECK(std::abs(moments[1]) < 5 * std::sqrt(1.0 / kDraws));
  CHECK(std::abs(moments[2] - 1) < 5 * std::sqrt(2.0 / kDraws));
  CHECK(std::abs(moments[3]) < 5 * std::sqrt(15.0 / kDraws));
  CHECK(std::abs(moments[4] - 3) < 5 * std::sqrt(96.0 / kDraws));
}

TEST_CASE("standard_normal follows the normal distribution everywhere (Kolmogorov-Smirnov), tails included", "[sweep]") {
  const RandomStream stream(1, "normal");
  std::vector<double> values(kDraws);
  for (std::uint64_t n = 0; n < kDraws; ++n) values[n] = stream.standard_normal(n);
  std::sort(values.begin(), values.end());
  double distance = 0;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const double cumulative = 0.5 * std::erfc(-values[i] / std::sqrt(2.0));
    distance = std::max({distance, (i + 1.0) / kDraws - cumulative, cumulative - static_cast<double>(i) / kDraws});
  }
  CHECK(distance < 1.95 / std::sqrt(kDraws));  // exceeded with probability 2 exp(-2 * 1.95^2) = 0.001

  for (const double limit : {2.0, 3.0, 4.0}) {
    INFO("beyond " << limit);
    const double expected = kDraws * std::erfc(limit / std::sqrt(2.0));
    const auto outside = std::count_if(values.begin(), values.end(), [limit](double z) { return std::abs(z) > limit; });
    CHECK(std::abs(static_cast<double>(outside) - expected) < 5 * std::sqrt(expected));
  }
}

TEST_CASE("the normal and the uniform value of one draw are independent, and so are neighbouring normals") {
  const RandomStream stream(1, "normal");
  const auto normal = [&](std::uint64_t n) { return stream.standard_normal(n); };
  const auto next_normal = [&](std::uint64_t n) { return stream.standard_normal(n + 1); };
  const auto square = [&](std::uint64_t n) { return (std::pow(stream.standard_normal(n), 2) - 1) / std::sqrt(2.0); };
  const auto next_square = [&](std::uint64_t n) { return square(n + 1); };
  CHECK(std::abs(correlation_deviation(kDraws / 4, normal, standardised_uniform(stream))) < 5);
  CHECK(std::abs(correlation_deviation(kDraws / 4, square, standardised_uniform(stream))) < 5);
  CHECK(std::abs(correlation_deviation(kDraws / 4, normal, next_normal)) < 5);
  CHECK(std::abs(correlation_deviation(kDraws / 4, square, next_square)) < 5);
}

TEST_CASE("draw n is the same in whatever order the draws are made, and from a second stream of the same key") {
  const RandomStream stream(42, "order"), twin(42, "order");
  std::vector<std::uint64_t> forwards;
  for (std::uint64_t n = 0; n < 1'000; ++n) forwards.push_back(stream.bits(n));
  int different = 0;
  for (std::uint64_t i = 0; i < 1'000; ++i) {
    const std::uint64_t n = i * 377 % 1'000;  // 377 and 1000 have no common factor: every n once
    twin.standard_normal(i);
    different += twin.bits(n) != forwards[n];
  }
  CHECK(different == 0);
}

// Every recorded trace hash with a jittered timing depends on these numbers. If this constant changes, those hashes change.
TEST_CASE("the streams have the values they always had") {
  std::uint64_t digest = 0;
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{1}, UINT64_MAX}) {
    for (const char* name : {"timing.step", "timing.visualization", "timing.step_count"}) {
      const RandomStream stream(seed, name);
      for (std::uint64_t n = 0; n < 10'000; ++n) {
        digest = mix(mix(mix(digest, stream.bits(n)), stream.uniform(n)), stream.standard_normal(n));
        digest =
            mix(mix(digest, stream.below(n, 15)), static_cast<std::uint64_t>(log_normal(stream, n, {1'482'222}, 0.1).ns));
      }
    }
  }
  CHECK(digest == 0xd4f07edff67b5d27ULL);
}
