// The maps of others that are offered for comparison. Each is checked against a second way to compute the same formula.
#include "catch.h"
#include "evenstep/remap/delay_locked_map.h"
#include "evenstep/remap/regression_map.h"
#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

struct Stepped {
  RealTime begin, end;
};

/// R(n) of each step of a schedule; INT64_MIN where there is none.
std::vector<std::int64_t> reads(SlotMap& map, const Schedule& schedule) {
  std::vector<std::int64_t> out;
  std::int64_t n = 0;
  for (const Segment& segment : schedule) {
    map.boundary(n, segment.begin);
    for (const StepTimes& step : segment.steps) {
      const Slot slot = map.read(n, step.begin);
      map.emission(n, step.end);
      out.push_back(slot.kind == SlotKind::mapped ? slot.read.ns : INT64_MIN);
      ++n;
    }
  }
  return out;
}

}  // namespace

TEST_CASE("jack_dll: with a constant number of steps it is the published loop, to 2 ns after 300 segments of 10 % jitter") {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Draw draw(seed);
    const Schedule schedule = jittered(draw, 0.1, 300);
    DelayLockedMap map({}, {}, 1.5);
    const std::vector<std::int64_t> slots = reads(map, schedule);
    // In seconds, and with the names of the paper.
    const auto at = [&](std::size_t k) { return static_cast<double>(schedule[k].begin.ns) * 1e-9; };
    double e2 = at(1) - at(0), t0 = at(1), t1 = t0 + e2;
    const double w = 2 * std::numbers::pi * 1.5 * e2;
    std::size_t n = schedule[0].steps.size();
    for (std::size_t k = 1; k < schedule.size(); ++k) {
      if (k > 1) {
        const double e = at(k) - t1;
        t0 = t1;
        t1 += std::sqrt(2.0) * w * e + e2;
        e2 += w * w * e;
      }
      const std::size_t steps = schedule[k].steps.size();
      for (std::size_t i = 0; i < steps; ++i, ++n) {
        const double slot_s = t0 + static_cast<double>(i) * (t1 - t0) / static_cast<double>(steps);
        INFO("segment " << k << ", step " << i);
        REQUIRE(std::abs(static_cast<double>(slots[n]) - slot_s * 1e9) <= 2);
      }
    }
  }
}

TEST_CASE("jack_dll: slots are strictly monotone with steps that come and go and hangs, in 2,000 random schedules") {
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    Draw draw(seed);
    DelayLockedMap map({}, {}, 0.05 + 20 * draw.unit());
    RealTime now;
    std::int64_t n = 0, last = INT64_MIN;
    for (int k = 0; k < 40; ++k) {
      map.boundary(n, now);
      for (std::int64_t i = draw.between(0, 20); i > 0; --i, ++n) {
        now = now + Duration{draw.between(1, draw.between(0, 30) == 0 ? 3'000'000'000 : 3'000'000)};
        const Slot slot = map.read(n, now);
        map.emission(n, now);
        if (slot.kind != SlotKind::mapped) continue;
        REQUIRE(slot.read.ns > last);
        last = slot.read.ns;
      }
      now = now + Duration{draw.between(0, 20'000'000)};
    }
  }
}

TEST_CASE("lsl_dejitter: it is the weighted least squares line through all steps so far, at 200 random schedules") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Draw draw(seed);
    const Schedule schedule = jittered(draw, 0.1, 12);
    const double forgetting_Hz = 0.01 + 20 * draw.unit(), keep = 1 - forgetting_Hz / 450;
    RegressionMap map({450, 1}, {}, {}, forgetting_Hz);
    const std::vector<std::int64_t> slots = reads(map, schedule);
    std::vector<double> begins;
    for (const Segment& segment : schedule) {
      for (const StepTimes& step : segment.steps) begins.push_back(static_cast<double>(step.begin.ns));
    }
    std::int64_t highest = INT64_MIN;
    for (std::size_t n = 0; n < begins.size(); ++n) {
      // The line a + b u through (u, begin - last begin) with u = 0 at step n, weights keep^(n - m), and the prior as a
      // point of almost no weight.
      long double s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0, weight = 1;
      for (std::size_t back = 0; back <= n; ++back, weight *= keep) {
        const long double u = -static_cast<long double>(back), y = begins[n - back] - begins[n];
        s0 += weight, s1 += weight * u, s2 += weight * u * u, y0 += weight * y, y1 += weight * u * y;
      }
      if (slots[n] == INT64_MIN) continue;
      const long double line = begins[n] + (s2 * y0 - s1 * y1) / (s0 * s2 - s1 * s1);
      highest = std::max(highest, static_cast<std::int64_t>(std::floor(line)));
      INFO("step " << n);
      REQUIRE(std::abs(slots[n] - highest) <= 2);
    }
  }
}

TEST_CASE("other maps: of the paper's timing, which repeats, both make even slots") {
  const Schedule schedule = Periodic{}.schedule(1500);
  DelayLockedMap locked({}, {}, 0.125);
  RegressionMap line({450, 1}, {}, {}, 2);
  const std::vector<std::int64_t> of_locked = reads(locked, schedule), of_line = reads(line, schedule);
  for (std::size_t n = of_locked.size() - 450; n < of_locked.size(); ++n) {
    // Segments begin at whole ns, so slots of the loop are off by rounding only. The line sees the steps and bends along.
    CHECK(std::abs(of_locked[n] - of_locked[n - 1] - 2'222'222) <= 2);
    CHECK(std::abs(of_line[n] - of_line[n - 1] - 2'222'222) <= 100'000);
  }
}
