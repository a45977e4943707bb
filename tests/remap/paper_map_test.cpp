#include "evenstep/remap/paper_map.h"

#include "catch.h"
#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

TEST_CASE("the segment estimate starts at the first length and then moves by weight times the error") {
  for (int percent = 1; percent <= 100; ++percent) {
    const double weight = percent / 100.0;
    SegmentEstimator estimator(weight);
    CHECK_FALSE(estimator.length_ns());
    double expected = 30e6;
    estimator.segment({30'000'000});
    CHECK(*estimator.length_ns() == expected);
    for (const std::int64_t length : {40'000'000, 20'000'000, 33'333'333, 0}) {
      estimator.segment({length});
      expected = (1 - weight) * expected + weight * static_cast<double>(length);
      CHECK(*estimator.length_ns() == Approx(expected).epsilon(1e-14).margin(1e-6));  // the same sum in another order
    }
  }
}

TEST_CASE("a weight that is not above 0 and at most 1 stops on an assertion") {
  CHECK(asserts([] { SegmentEstimator{0.0}; }));
  CHECK(asserts([] { SegmentEstimator{1.0001}; }));
  CHECK_FALSE(asserts([] { SegmentEstimator{1.0}; }));
}

TEST_CASE("paper splits the estimate into as many slots as the segment before had steps, from the measured boundary") {
  PaperMap map({}, {}, 0.5, StepCount::last);
  map.boundary(0, RealTime{1000});
  for (std::int64_t n = 0; n < 4; ++n) {
    CHECK(map.read(n, {}).kind == SlotKind::acquiring);
    map.emission(n, {});
  }
  map.boundary(4, RealTime{1400});         // T^ = 400, N^ = 4
  for (std::int64_t n = 4; n < 10; ++n) {  // six steps: slots past N^ continue at the same pace
    CHECK(map.read(n, {}).read.ns == 1400 + 100 * (n - 4));
    map.emission(n, {});
  }
  map.boundary(10, RealTime{2000});  // T = 600: T^ = 500, N^ = 6
  for (std::int64_t n = 10; n < 16; ++n) {
    CHECK(map.read(n, {}).read.ns == 2000 + 500 * (n - 10) / 6);
    map.emission(n, {});
  }
}

TEST_CASE("paper averages the step count in the weights of the length, unless it is told to take the last one") {
  PaperMap map({}, {}, 0.5);
  map.boundary(0, RealTime{0});
  std::int64_t n = 0;
  for (; n < 4; ++n) {
    map.read(n, {});
    map.emission(n, {});
  }
  map.boundary(n, RealTime{400});  // T^ = 400, N^ = 4
  for (; n < 12; ++n) {
    CHECK(map.read(n, {}).read.ns == 400 + 100 * (n - 4));
    map.emission(n, {});
  }
  map.boundary(n, RealTime{1000});  // T = 600, N = 8: T^ = 500, N^ = 6
  for (; n < 15; ++n) {
    CHECK(map.read(n, {}).read.ns == 1000 + 500 * (n - 12) / 6);
    map.emission(n, {});
  }
}

TEST_CASE("where N varies the averaged count needs a fraction of the latency and of the jump of the last one, 50 seeds") {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Draw draw(seed);
    Schedule schedule;
    RealTime now{};
    for (std::int64_t k = 0; k < 300; ++k) {  // 8 to 60 steps of 1.5 ms without a pause
      Segment segment{now, {}};
      for (std::int64_t i = draw.between(8, 60); i > 0; --i) {
        segment.steps.push_back({now, now + Duration{1'500'000}, k, 0});
        now = now + Duration{1'500'000};
      }
      schedule.push_back(segment);
    }
    const std::vector<Placed> average = place(PaperMap({}, {}, 0.1), schedule);
    const std::vector<Placed> last = place(PaperMap({}, {}, 0.1, StepCount::last), schedule);
    CHECK(velocity_jump(average, 1000, 1.5e6) < 0.5 * velocity_jump(last, 1000, 1.5e6));
  }
}

TEST_CASE("a segment without steps re-anchors paper and keeps its estimate") {
  PaperMap map({}, {}, 0.5);
  map.boundary(0, RealTime{0});
  map.boundary(0, RealTime{50});  // no step yet: still acquiring
  CHECK(map.read(0, {}).kind == SlotKind::acquiring);
  map.emission(0, {});
  map.boundary(1, RealTime{150});  // T^ = 100, N^ = 1
  map.boundary(1, RealTime{5000});
  CHECK(map.read(1, {}).read.ns == 5000);
  map.emission(1, {});
  CHECK(map.read(2, {}).read.ns == 5100);
}

TEST_CASE("the jump of paper at every boundary is T_k - T^_k, to the nanosecond, on 2000 random schedules") {
  // A copy that is not told the boundary goes on along the old line. Its difference from the map is the jump.
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Draw draw(seed);
    const auto steps = draw.between(1, 40);
    const double weight = 0.01 * static_cast<double>(draw.between(1, 100));
    PaperMap map({}, {}, weight);
    double estimate_ns = 0;
    std::int64_t n = 0;
    RealTime begin{draw.between(0, 1'000'000'000)};
    map.boundary(0, begin);
    for (int k = 0; k < 20; ++k) {
      for (std::int64_t i = 0; i < steps; ++i, ++n) {
        map.read(n, {});
        map.emission(n, {});
      }
      const Duration length{draw.between(1'000'000, 60'000'000)};
      begin = begin + length;
      PaperMap untold = map;
      map.boundary(n, begin);
      PaperMap told = map;
      if (k > 0) {
        const std::int64_t jump = (told.read(n, {}).read - untold.read(n, {}).read).ns;
        // The old line ends at floor(T^): one rounding of N (T^ / N).
        REQUIRE(std::abs(static_cast<double>(jump) - (static_cast<double>(length.ns) - std::floor(estimate_ns))) <= 1);
      }
      const double length_ns = static_cast<double>(length.ns);
      estimate_ns = k == 0 ? length_ns : estimate_ns + weight * (length_ns - estimate_ns);
    }
  }
}

TEST_CASE("under a drift of r per segment the jump of paper settles at r / weight") {
  for (const double weight : {0.1, 0.3, 1.0}) {
    for (const std::int64_t drift : {-1000, 5'000, 111'111}) {
      PaperMap map({}, {}, weight);
      RealTime begin{};
      Duration length{100'000'000};
      std::int64_t jump = 0;
      for (std::int64_t n = 0; n < 300; ++n) {  // one step per segment; 0.9^300 of the start is below 1 ns
        map.boundary(n, begin);
        PaperMap untold = map;
        map.read(n, {});
        map.emission(n, {});
        untold.read(n, {});
        untold.emission(n, {});
        begin = begin + length;
        length += Duration{drift};
        if (n > 0) {
          const RealTime old = untold.read(n + 1, {}).read;
          jump = (begin - old).ns;
        }
      }
      CHECK(std::abs(static_cast<double>(jump) - static_cast<double>(drift) / weight) <= 2);  // two floors
    }
  }
}

TEST_CASE("paper stays within 2 ns of the exact line for 100,000 periodic segments") {
  // B_k is floored (1 ns), T^ is within 1 ns of T, the slot is floored (1 ns): the sum stays below 3 ns, one-sided 2 ns.
  PaperMap map({}, {}, 0.1);
  std::int64_t n = 0, worst = 0;
  for (std::int64_t k = 0; k < 100'000; ++k) {
    map.boundary(n, tick_time({30, 1}, k));
    for (int i = 0; i < 15; ++i, ++n) {
      const Slot slot = map.read(n, {});
      map.emission(n, {});
      if (slot.kind == SlotKind::mapped) worst = std::max(worst, std::abs(slot.read.ns * 450 - n * 1'000'000'000));
    }
  }
  CHECK(worst <= 2 * 450);
  CHECK(worst > 0);
}
