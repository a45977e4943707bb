#include "evenstep/remap/buffer_oracle.h"

#include "../schedules.h"
#include "catch.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

Duration longest_step(const std::vector<StepTimes>& steps) {
  Duration longest;
  for (const StepTimes& step : steps) longest = std::max(longest, step.end - step.begin);
  return longest;
}

/// Sign of (b.ns - a.ns) / (b.n - a.n) - (d.ns - c.ns) / (d.n - c.n), exactly.
struct At {
  std::int64_t n, ns;
};
int compare(At a, At b, At c, At d) {
  const __int128 left = static_cast<__int128>(b.ns - a.ns) * (d.n - c.n);
  const __int128 right = static_cast<__int128>(d.ns - c.ns) * (b.n - a.n);
  return left < right ? -1 : left > right;
}

/// The conditions of Karush, Kuhn and Tucker for the least sum of any convex function of the slopes. They are sufficient
/// for a convex function on a convex set. The string is inside the tube. It is straight except where it touches the tube;
/// it is slower after touching the lower bound and faster after touching the upper one. With free ends the first and the
/// last slope are tau*.
void check_optimal(const std::vector<StepTimes>& steps, Duration latency, Duration sampling, const TautString& string) {
  const auto low = [&](std::size_t n) { return (steps[n].end - latency).ns; };
  const auto high = [&](std::size_t n) { return (steps[n].begin - sampling).ns; };
  REQUIRE(string.reads.size() == steps.size());
  for (std::size_t n = 0; n < steps.size(); ++n) {
    REQUIRE(string.reads[n].ns >= low(n));
    REQUIRE(string.reads[n].ns <= high(n));
    if (n > 0) REQUIRE(string.reads[n] >= string.reads[n - 1]);
  }
  std::vector<At> bends;
  for (const std::size_t n : string.bends) bends.push_back({static_cast<std::int64_t>(n), string.reads[n].ns});
  for (std::size_t i = 1; i < bends.size(); ++i) {
    for (std::int64_t n = bends[i - 1].n; n < bends[i].n; ++n) {  // straight in between, up to the floor
      const std::int64_t line =
          bends[i - 1].ns + floor_mul_div(n - bends[i - 1].n, bends[i].ns - bends[i - 1].ns, bends[i].n - bends[i - 1].n);
      REQUIRE(string.reads[static_cast<std::size_t>(n)].ns == line);
    }
  }
  const BestLine best = best_line(steps);
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const auto n = static_cast<std::size_t>(bends[i].n);
    double turn = 0;  // slope after - slope before
    if (i > 0 && i + 1 < bends.size()) {
      turn = compare(bends[i], bends[i + 1], bends[i - 1], bends[i]);
    } else {  // one side is tau*, which is known as a double only
      const auto slope = [&](std::size_t a) {
        return static_cast<double>(bends[a + 1].ns - bends[a].ns) / static_cast<double>(bends[a + 1].n - bends[a].n);
      };
      turn = (i + 1 < bends.size() ? slope(i) : best.slot_ns) - (i > 0 ? slope(i - 1) : best.slot_ns);
    }
    REQUIRE(turn != 0);
    REQUIRE(bends[i].ns == (turn < 0 ? low(n) : high(n)));
  }
  if (bends.empty()) return;
  for (const std::size_t n : {std::size_t{0}, steps.size() - 1}) {  // the free ends
    const At bend = n == 0 ? bends.front() : bends.back();
    const auto steps_on = static_cast<double>(static_cast<std::int64_t>(n) - bend.n);
    const double line = static_cast<double>(bend.ns) + best.slot_ns * steps_on;
    REQUIRE(std::abs(static_cast<double>(string.reads[n].ns) - line) <= 1 + 1e-6);
  }
}

}  // namespace

TEST_CASE("the taut string of none, of one and of two steps") {
  CHECK(taut_string({}, {10}, {0}).reads.empty());
  CHECK_FALSE(taut_string({}, {10}, {0}).infeasible_step);
  const std::vector<StepTimes> one{{RealTime{5}, RealTime{12}}};
  CHECK(taut_string(one, {6}, {0}).infeasible_step == 0U);
  CHECK(taut_string(one, {7}, {0}).reads[0].ns == 5);
  CHECK(taut_string(one, {11}, {0}).reads[0].ns == 3);  // the middle of [1, 5]
  CHECK(taut_string(one, {11}, {4}).reads[0].ns == 1);
  CHECK(taut_string(one, {11}, {5}).infeasible_step == 0U);
  const std::vector<StepTimes> two{{RealTime{0}, RealTime{10}}, {RealTime{20}, RealTime{35}}};
  CHECK(taut_string(two, {14}, {0}).infeasible_step == 1U);
  CHECK(taut_string(two, {15}, {0}).reads[1].ns == 20);  // [20, 20]
  CHECK(taut_string(two, {15}, {0}).bends.empty());
}

TEST_CASE("the taut string meets the conditions of the optimum, from the least latency to L*, 2000 random traces") {
  std::int64_t bent = 0, straight = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Draw draw(seed + 31);
    const std::vector<StepTimes> steps = flat(random_schedule(draw, draw.between(1, 8)));
    if (steps.size() < 2) continue;
    const Duration sampling{draw.between(0, 2'000'000)};
    const Duration least = longest_step(steps) + sampling, enough = best_line(steps).latency + sampling;
    INFO("seed " << seed);
    const TautString infeasible = taut_string(steps, least - Duration{1}, sampling);
    REQUIRE(infeasible.infeasible_step);
    REQUIRE(infeasible.reads.empty());
    REQUIRE(steps[*infeasible.infeasible_step].end - steps[*infeasible.infeasible_step].begin == longest_step(steps));
    const Duration between{draw.between(least.ns, enough.ns)}, above{draw.between(0, 10'000'000)};
    for (const Duration latency : {least, between, enough - Duration{1}, enough, enough + above}) {
      if (latency < least) continue;
      const TautString string = taut_string(steps, latency, sampling);
      REQUIRE_FALSE(string.infeasible_step);
      REQUIRE(string.bends.empty() == (latency >= enough));
      check_optimal(steps, latency, sampling, string);
      ++(string.bends.empty() ? straight : bent);
    }
  }
  CHECK(bent > 3000);
  CHECK(straight > 3000);
}

TEST_CASE("a tube of no width anywhere is the path itself, and a bend is where it turns") {
  // R(n) = S_n - 1 = E_n - 11, as steps take 10, L = 11 and d = 1.
  std::vector<StepTimes> steps;
  for (std::int64_t n = 0; n < 30; ++n) steps.push_back({RealTime{100 * n + n % 3}, RealTime{100 * n + n % 3 + 10}});
  const TautString string = taut_string(steps, {11}, {1});
  for (std::size_t n = 0; n < 30; ++n) REQUIRE(string.reads[n].ns == steps[n].begin.ns - 1);
}

TEST_CASE("the taut string of a million steps with 10 % jitter at a latency far below L*", "[million]") {
  Draw draw(8);
  const std::vector<StepTimes> steps = flat(jittered(draw, 0.1, 67'000));
  const Duration latency{20'000'000};
  REQUIRE(best_line(steps).latency > latency);
  const TautString string = taut_string(steps, latency, {999'999});
  check_optimal(steps, latency, {999'999}, string);
  CHECK(string.bends.size() > 100);
}
