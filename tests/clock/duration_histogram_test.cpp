#include "evenstep/time/duration_histogram.h"

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include "catch.h"

using namespace evenstep;

TEST_CASE("an empty histogram answers zero") {
  const DurationHistogram none;
  CHECK(none.count() == 0);
  CHECK(none.smallest() == Duration{0});
  CHECK(none.largest() == Duration{0});
  for (const int permille : {0, 500, 1000}) CHECK(none.quantile(permille) == Duration{0});
}

TEST_CASE("quantiles are never below the exact ones and at most a 32nd above in 200 random histograms") {
  std::mt19937_64 random(1);
  for (int round = 0; round < 200; ++round) {
    DurationHistogram histogram;
    std::vector<std::int64_t> all;
    const int count = 1 + static_cast<int>(random() % 300);
    for (int i = 0; i < count; ++i) {
      all.push_back(static_cast<std::int64_t>(random() >> (1 + random() % 62)));  // every octave
      histogram.add(Duration{all.back()});
    }
    std::sort(all.begin(), all.end());
    REQUIRE(histogram.count() == count);
    REQUIRE(histogram.smallest().ns == all.front());
    REQUIRE(histogram.largest().ns == all.back());
    for (int permille = 0; permille <= 1000; permille += 1 + round % 7) {
      const int rank = std::max(1, (count * permille + 999) / 1000);
      const std::int64_t exact = all[static_cast<std::size_t>(rank - 1)];
      const std::int64_t got = histogram.quantile(permille).ns;
      REQUIRE(got >= exact);
      REQUIRE(got - exact <= exact / 32);
    }
    REQUIRE(histogram.quantile(1000).ns == all.back());
  }
}

TEST_CASE("durations below 64 ns are kept exactly") {
  for (std::int64_t ns = 0; ns < 64; ++ns) {
    DurationHistogram histogram;
    histogram.add(Duration{ns});
    histogram.add(Duration{1'000'000});
    CHECK(histogram.quantile(500) == Duration{ns});
  }
}

TEST_CASE("the longest duration there is has a bin, and a negative one counts as zero") {
  DurationHistogram histogram;
  histogram.add(Duration{std::numeric_limits<std::int64_t>::max()});
  CHECK(histogram.quantile(1000).ns == std::numeric_limits<std::int64_t>::max());
  histogram.add(Duration{-5});
  CHECK(histogram.quantile(500) == Duration{0});
}
