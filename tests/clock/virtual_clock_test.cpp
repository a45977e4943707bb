#include "evenstep/clock/virtual_clock.h"

#include "catch.h"
#include "evenstep/time/digest.h"

using namespace evenstep;

TEST_CASE("a virtual clock starts at 0 and stands still until it is told to wait") {
  VirtualClock clock;
  CHECK(clock.is_virtual());
  for (int i = 0; i < 1'000; ++i) CHECK(clock.now() == RealTime{0});
}

TEST_CASE("a virtual wait jumps exactly to its deadline, 10^6 times") {
  VirtualClock clock;
  RealTime expected{0};
  int wrong = 0;
  for (std::uint64_t i = 0; i < 1'000'000; ++i) {
    expected = expected + Duration{static_cast<std::int64_t>(spread(i) >> (20 + i % 44))};  // 0 ns to 2^44 ns = 4.9 h
    wrong += clock.wait_until(expected) != Wake::deadline || clock.now() != expected;
  }
  CHECK(wrong == 0);
}

TEST_CASE("a deadline in the past or at now() moves a virtual clock by nothing") {
  VirtualClock clock;
  clock.wait_until(RealTime{1'000});
  for (const std::int64_t ns : {1'000LL, 999LL, 0LL, -1LL, -1'000'000'000LL}) {
    CHECK(clock.wait_until(RealTime{ns}) == Wake::deadline);
    CHECK(clock.now() == RealTime{1'000});
  }
}

TEST_CASE("a notified virtual wait moves nothing") {
  VirtualClock clock;
  clock.wait_until(RealTime{1'000});
  clock.notify();
  CHECK(clock.wait_until(RealTime{2'000}) == Wake::notified);
  CHECK(clock.now() == RealTime{1'000});
}

TEST_CASE("a virtual wait for kNever that nothing can end returns notified and moves nothing") {
  VirtualClock clock;
  clock.wait_until(RealTime{1'000});
  CHECK(clock.wait_until(kNever) == Wake::notified);
  CHECK(clock.now() == RealTime{1'000});
  CHECK(clock.wait_until(RealTime{kNever.ns - 1}) == Wake::deadline);  // the last instant there is
  CHECK(clock.now() == RealTime{kNever.ns - 1});
}
