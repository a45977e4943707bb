// No clock may drift: each instant is the floor of an exact rational, however many instants came before. The expected
// instants are counted up in whole numbers with a carried remainder, which is not how tick_time computes them.

#include "rig.h"

namespace evenstep::test {
namespace {

/// 0, period, 2 period, ..., each floored to ns, for a period of den * 1e9 / num ns. In 128 bits, with no division after the
/// first.
class CountedInstants {
 public:
  explicit CountedInstants(Rate rate)
      : num_(rate.num),
        whole_(static_cast<__int128>(rate.den) * 1'000'000'000 / rate.num),
        rest_(static_cast<__int128>(rate.den) * 1'000'000'000 % rate.num) {}
  RealTime next() {
    const RealTime instant{static_cast<std::int64_t>(at_)};
    at_ += whole_;
    carried_ += rest_;
    if (carried_ >= num_) {
      carried_ -= num_;
      ++at_;
    }
    return instant;
  }

 private:
  __int128 num_, whole_, rest_;
  __int128 at_ = 0, carried_ = 0;
};

struct Seen {
  std::int64_t ticks = 0;
  std::int64_t wrong = 0;
  RealTime last;
};

Task ticks(Scheduler& scheduler, const Clock& clock, Rate rate, std::int64_t count, Seen& seen) {
  CountedInstants expected(rate);
  for (std::int64_t k = 0; k < count; ++k) {
    const Arrival arrival = co_await scheduler.until(tick_time(rate, k), Lane::device, "tick");
    seen.last = expected.next();
    ++seen.ticks;
    seen.wrong += arrival.scheduled != seen.last || arrival.actual != seen.last || scheduler.now() != seen.last ||
                  clock.now() != seen.last;
  }
}

// 1 ms; 2.2 ms recurring; a period of 977e9 / 1000003 ns, whose remainder needs all of 1000003 ticks to come round.
constexpr Rate kRates[] = {{1'000, 1}, {450, 1}, {1'000'003, 977}};

TEST_CASE("10^7 ticks of three lanes on a virtual clock fall on the floors of the exact instants", "[sweep]") {
  constexpr std::int64_t count = 10'000'000;
  VirtualRig rig({.keep_events = false});
  std::vector<Seen> seen(std::size(kRates));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    rig.scheduler.spawn(ticks(rig.scheduler, rig.clock, kRates[i], count, seen[i]));
  }
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK(rig.scheduler.event_count() == count * static_cast<std::int64_t>(seen.size()));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    CAPTURE(kRates[i].num, kRates[i].den);
    CHECK(seen[i].ticks == count);
    CHECK(seen[i].wrong == 0);
    const __int128 exact = static_cast<__int128>(count - 1) * kRates[i].den * 1'000'000'000 / kRates[i].num;
    CHECK(seen[i].last.ns == static_cast<std::int64_t>(exact));
  }
  CHECK(rig.scheduler.events().capacity() == 0);  // memory does not grow with the run
}

}  // namespace
}  // namespace evenstep::test
