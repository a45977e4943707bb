// The pool of needs gives the same latencies as a list of all needs, but takes memory only for the underruns that are
// allowed.
#include <fstream>

#include "catch.h"
#include "evenstep/scheduler/random.h"
#include "src/size/rate.h"

using namespace evenstep;
using namespace evenstep::internal;

TEST_CASE("A pool of the deciding needs gives the latencies of all needs for every number of underruns", "[sweep]") {
  const RandomStream stream(3, "need.pool");
  std::uint64_t draw = 0;
  std::vector<SegmentNeed> all;
  for (int i = 0; i < 300'000; ++i) {  // more than the pool keeps at once; only a few values, so that many are equal
    const auto range = i % 3 == 0 ? 50U : 50'000U;
    all.push_back({{static_cast<std::int64_t>(stream.bits(draw++) % range)},
                   {static_cast<std::int64_t>(stream.bits(draw++) % range)}});
  }
  for (const std::int64_t allowed : {0, 1, 2, 7, 100, 3000}) {
    NeedPool pool(allowed);
    for (const SegmentNeed& need : all) pool.add(need);
    const std::vector<SegmentNeed> kept = pool.take();
    CHECK(std::ssize(kept) <= 2 * (allowed + 1));
    for (const std::int64_t fewer : {std::int64_t{0}, allowed / 2, allowed}) {
      const RateLatency whole = least_latency_with_underruns(all, fewer), pooled = least_latency_with_underruns(kept, fewer);
      CHECK(pooled.latency == whole.latency);
      CHECK(pooled.lead == whole.lead);
      CHECK(pooled.underruns == whole.underruns);
    }
  }
}

TEST_CASE("The underruns that a rate allows are counted without the error of the product") {
  CHECK(allowed_underruns(0.1, 30) == 3);
  CHECK(allowed_underruns(0.29, 100) == 29);  // the product is 28.999999999999996
  CHECK(allowed_underruns(0.001, 999) == 0);
  CHECK(allowed_underruns(0.001, 1000) == 1);
}
