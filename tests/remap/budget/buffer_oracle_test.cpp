#include "evenstep/remap/buffer_oracle.h"

#include "../schedules.h"
#include "catch.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// The bracket is piecewise linear in tau. Its corners are the slopes between two ends or two begins: all of them are tried.
std::int64_t brute_force(const std::vector<StepTimes>& steps) {
  std::int64_t best = INT64_MAX;
  for (std::size_t a = 0; a < steps.size(); ++a) {
    for (std::size_t b = a + 1; b < steps.size(); ++b) {
      const auto run = static_cast<std::int64_t>(b - a);
      best = std::min(best, bracket(steps, (steps[b].end - steps[a].end).ns, run));
      best = std::min(best, bracket(steps, (steps[b].begin - steps[a].begin).ns, run));
    }
  }
  return best;
}

/// The bracket is convex, so the interval can be narrowed by thirds; in units of 2^-20 ns.
std::int64_t ternary_search(const std::vector<StepTimes>& steps) {
  constexpr std::int64_t kUnit = 1 << 20;
  std::int64_t low = 0, high = 200'000'000 * kUnit;
  while (high - low > 2) {
    const std::int64_t a = low + (high - low) / 3, b = high - (high - low) / 3;
    // Compared without the ceiling, as numerators over a common denominator.
    const auto value = [&](std::int64_t tau) {
      __int128 most = -(static_cast<__int128>(1) << 120), least = -most;
      for (std::size_t n = 0; n < steps.size(); ++n) {
        const __int128 slots = static_cast<__int128>(n) * tau;
        most = std::max(most, static_cast<__int128>(steps[n].end.ns) * kUnit - slots);
        least = std::min(least, static_cast<__int128>(steps[n].begin.ns) * kUnit - slots);
      }
      return most - least;
    };
    if (value(a) <= value(b))
      high = b;
    else
      low = a;
  }
  return bracket(steps, (low + high) / 2, kUnit);
}

}  // namespace

TEST_CASE("the best line of none and of one step") {
  CHECK(best_line({}).latency.ns == 0);
  const StepTimes one{RealTime{5}, RealTime{12}};
  CHECK(best_line(std::span(&one, 1)).latency.ns == 7);
  CHECK(best_line(std::span(&one, 1)).slot_ns == 0);
}

TEST_CASE("the best line is the least bracket over all slopes: 1000 small traces, exactly") {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Draw draw(seed);
    std::vector<StepTimes> steps = flat(random_schedule(draw, 3));
    if (steps.size() > 30) steps.resize(30);
    if (steps.size() < 2) continue;
    const BestLine line = best_line(steps);
    INFO("seed " << seed);
    REQUIRE(line.latency.ns == brute_force(steps));
    for (const StepTimes& step : steps) REQUIRE(line.latency >= step.end - step.begin);
  }
}

TEST_CASE("the best line agrees with a ternary search over the slot: 60 traces of hundreds of steps") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Draw draw(seed + 99);
    const std::vector<StepTimes> steps = flat(random_schedule(draw, 20));
    if (steps.size() < 2) continue;
    const std::int64_t found = ternary_search(steps);
    REQUIRE(found >= best_line(steps).latency.ns);
    REQUIRE(found <= best_line(steps).latency.ns + 1);  // 2^-20 ns of slot times the number of steps
  }
}

TEST_CASE("the best line of a part is no worse than that of the whole") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Draw draw(seed);
    const std::vector<StepTimes> steps = flat(jittered(draw, 0.1, 20));
    const auto from = static_cast<std::size_t>(draw.between(0, 200));
    const auto count = static_cast<std::size_t>(draw.between(0, static_cast<std::int64_t>(steps.size() - from)));
    REQUIRE(best_line(std::span(steps).subspan(from, count)).latency <= best_line(steps).latency);
  }
}

TEST_CASE("on periodic timing the best line is s + Z(1 - 1/N) with the slot of the segment, and the maps reach it") {
  const std::vector<StepTimes> steps = flat(Periodic{}.schedule(120));
  const BestLine line = best_line(steps);
  CHECK(std::abs(line.latency.ns - 11'842'222) <= 2);  // floors of begins and ends: 1 ns each
  CHECK(line.slot_ns == Approx(1e9 / 450).epsilon(1e-9));
  const SamplingGrid grid{{1000, 1}, {}};
  const auto sized = mapped_steps(place(PhaseLockedMap({}, {}), Periodic{}.schedule(120)));
  const Duration reached = least_latency_any_phase(sized, std::span(&grid, 1), Emission::hold).latency;
  CHECK(reached.ns >= line.latency.ns + 999'999 - 1);  // the floor of a slot can win 1 ns over a real line
  CHECK(reached.ns <= line.latency.ns + 999'999 + 3);
}

TEST_CASE("the best line of three million steps", "[million]") {
  Draw draw(3);
  const std::vector<StepTimes> steps = flat(jittered(draw, 0.1, 200'000));
  const BestLine line = best_line(steps);
  const auto tau = std::llround(line.slot_ns * 1e6);
  // The slope was found up to its rounding to 1e-6 ns, which over 3e6 steps makes some ns. No slope nearby is better.
  CHECK(std::abs(bracket(steps, tau, 1'000'000) - line.latency.ns) <= 4);
  CHECK(bracket(steps, tau + 1000, 1'000'000) >= line.latency.ns);
  CHECK(bracket(steps, tau - 1000, 1'000'000) >= line.latency.ns);
}
