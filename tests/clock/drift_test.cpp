// A virtual clock that is given 10^7 exact instants is exactly at each of them, because it adds nothing up itself.
#include "catch.h"
#include "evenstep/clock/virtual_clock.h"

using namespace evenstep;

TEST_CASE("a virtual clock stands on every one of 10^7 exact instants of an awkward rate") {
  constexpr Rate kRate{1'000'003, 977};
  VirtualClock clock;
  std::int64_t wrong = 0;
  // floor(k 977e9 / 1000003), counted up with a carried remainder.
  constexpr std::int64_t kWhole = 977'000'000'000 / 1'000'003, kRest = 977'000'000'000 % 1'000'003;
  std::int64_t at = 0, carried = 0;
  for (std::int64_t k = 0; k < 10'000'000; ++k) {
    wrong += clock.wait_until(tick_time(kRate, k)) != Wake::deadline || clock.now() != RealTime{at};
    at += kWhole;
    carried += kRest;
    if (carried >= kRate.num) {
      carried -= kRate.num;
      ++at;
    }
  }
  CHECK(wrong == 0);
}
