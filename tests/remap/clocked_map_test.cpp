// The map for loops that know their own simulation time.
#include "evenstep/remap/maps/clocked_map.h"

#include <vector>

#include "catch.h"
#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

struct Loop {
  Rate step_rate;
  Schedule frames;
  std::vector<SimTime> simulated;  // t(n)
};

/// A game's loop: frames of any length, each with the steps that are due, now and then a long one. `max_steps` 0: no limit.
Loop random_loop(Draw& draw, int max_steps) {
  Loop loop{{draw.between(10, 2'000), draw.between(1, 3)}, {}, {}};
  const std::int64_t size_ns = instant_ns(loop.step_rate, 1);
  const std::int64_t frame_ns = draw.between(1'000'000, 40'000'000), step_ns = draw.between(1'000, 1 + size_ns / 2);
  const bool steps_first = draw.between(0, 1) == 0;
  RealTime now{draw.between(-1'000'000'000, 1'000'000'000)};
  const RealTime start = now;
  std::int64_t done = 0;
  for (std::int64_t k = 0; k < 30; ++k) {
    Segment frame{now, {}};
    std::int64_t due = first_tick_at_or_after(loop.step_rate, now + Duration{1}, start) - 1 - done;
    if (max_steps > 0 && due > max_steps) {
      done += due - max_steps;
      due = max_steps;
    }
    if (!steps_first) now = now + Duration{frame_ns / 2};
    for (std::int64_t i = 0; i < due; ++i) {
      const RealTime end = now + Duration{draw.between(step_ns / 2, step_ns)};
      frame.steps.push_back({now, end, k, static_cast<std::int32_t>(i)});
      loop.simulated.push_back(sim_time(loop.step_rate, done++));
      now = end;
    }
    now = now + Duration{draw.between(frame_ns / 2, frame_ns)};
    if (draw.between(0, 9) == 0) now = now + Duration{draw.between(0, 200'000'000)};
    loop.frames.push_back(frame);
  }
  return loop;
}

std::vector<Placed> play(SlotMap& map, const Loop& loop) {
  std::vector<Placed> placed;
  for (const Segment& frame : loop.frames) {
    map.boundary(static_cast<std::int64_t>(placed.size()), frame.begin);
    for (const StepTimes& step : frame.steps) {
      const auto n = static_cast<std::int64_t>(placed.size());
      map.simulated(loop.simulated[placed.size()]);
      const Slot slot = map.read(n, step.begin);
      placed.push_back({step, slot, map.emission(n, step.end)});
    }
  }
  return placed;
}

std::vector<Placed> play(const Clocked& clock, const Loop& loop) {
  ClockedMap map(clock, {}, Duration{});
  return play(map, loop);
}

/// The largest change of the distance from one slot to the next.
std::int64_t largest_jump_ns(const std::vector<Placed>& placed) {
  std::int64_t most = 0;
  for (std::size_t n = 2; n < placed.size(); ++n)
    most = std::max(most, std::abs((placed[n].slot.read - placed[n - 1].slot.read).ns -
                                   (placed[n - 1].slot.read - placed[n - 2].slot.read).ns));
  return most;
}

}  // namespace

TEST_CASE("while nothing is dropped, slots of clocked are even to 1 ns whatever the frames do, in 100 000 loops",
          "[sweep]") {
  for (std::uint64_t seed = 0; seed < 100'000; ++seed) {
    Draw draw(seed);
    const Loop loop = random_loop(draw, 0);
    const std::vector<Placed> placed = play({.step_rate = loop.step_rate, .most = {1}}, loop);
    for (std::size_t n = 0; n < placed.size(); ++n) {
      REQUIRE(placed[n].slot.kind == SlotKind::mapped);
      REQUIRE((placed[n].slot.read - placed[0].real.begin).ns == sim_time(loop.step_rate, static_cast<std::int64_t>(n)).ns);
    }
    REQUIRE(largest_jump_ns(placed) <= 1);
  }
}

TEST_CASE("dropped time moves the slots of clocked by at most what is stated per step, and no further, in 100 000 loops",
          "[sweep]") {
  std::int64_t dropping = 0;
  for (std::uint64_t seed = 0; seed < 100'000; ++seed) {
    Draw draw(seed);
    const Loop loop = random_loop(draw, static_cast<int>(draw.between(1, 6)));
    const std::int64_t size_ns = instant_ns(loop.step_rate, 1);
    const Duration most{draw.between(1, size_ns * 9 / 10)};
    const std::vector<Placed> slewing = play({loop.step_rate, most}, loop),
                              jumping = play({.step_rate = loop.step_rate}, loop);
    for (std::size_t n = 0; n < slewing.size(); ++n) {
      const std::int64_t target_ns = loop.simulated[n].ns - loop.simulated[0].ns;
      // Where n dt and t(n) are rounded down separately, 1 ns may be in one and not yet in the other.
      REQUIRE(std::abs((jumping[n].slot.read - jumping[0].real.begin).ns - target_ns) <= 1);
      const std::int64_t behind_ns = target_ns - (slewing[n].slot.read - slewing[0].real.begin).ns;
      REQUIRE(behind_ns >= -1);
      if (n == 0) continue;
      const std::int64_t before_ns =
          loop.simulated[n - 1].ns - loop.simulated[0].ns - (slewing[n - 1].slot.read - slewing[0].real.begin).ns;
      const std::int64_t dropped_ns = loop.simulated[n].ns - loop.simulated[n - 1].ns - size_ns;
      dropping += dropped_ns > 1;
      // It has followed by `most`, or is there.
      REQUIRE((std::abs(before_ns + std::max<std::int64_t>(dropped_ns, 0) - most.ns - behind_ns) <= 2 || behind_ns <= 1));
      REQUIRE(slewing[n].slot.read > slewing[n - 1].slot.read);
    }
    REQUIRE(largest_jump_ns(slewing) <= most.ns + 1);
  }
  CHECK(dropping > 10'000);
}

TEST_CASE("with the least lead and latency of clocked nothing is missing or late, with 1 ns less one is, in 10 000 loops",
          "[sweep]") {
  for (std::uint64_t seed = 0; seed < 10'000; ++seed) {
    Draw draw(seed);
    const Loop loop = random_loop(draw, static_cast<int>(draw.between(0, 4)));
    const Duration most{draw.between(1, instant_ns(loop.step_rate, 1) / 2)};
    const std::vector<MappedStep> steps = mapped_steps(play({loop.step_rate, most}, loop));
    if (steps.empty()) continue;
    const SamplingGrid device{{1'000, 1}, RealTime{-2'000'000'000}};
    const Emission emission = draw.between(0, 1) == 0 ? Emission::hold : Emission::linear;
    const LatencyBudget least = least_latency_this_phase(steps, {&device, 1}, emission);
    REQUIRE(count_interaction_underruns(steps, device, least.lead) == 0);
    REQUIRE(count_interaction_underruns(steps, device, least.lead - Duration{1}) > 0);
    REQUIRE(count_late_forces(steps, least.lead, least.latency, emission) == 0);
    REQUIRE(count_late_forces(steps, least.lead, least.latency - Duration{1}, emission) > 0);
  }
}

TEST_CASE("a step whose t is not told to clocked follows the one before by a step size") {
  ClockedMap map({{100, 1}, Duration{10'000'000}}, {}, Duration{});
  std::vector<std::int64_t> slots_ms;
  const std::optional<SimTime> told[] = {SimTime{7'000'000}, {}, SimTime{37'000'000}, {}, {}};
  for (std::int64_t n = 0; n < 5; ++n) {
    if (told[n]) map.simulated(*told[n]);
    slots_ms.push_back(map.read(n, RealTime{3'000'000}).read.ns / 1'000'000);
    map.emission(n, RealTime{4'000'000});
  }
  CHECK(slots_ms == std::vector<std::int64_t>{3, 13, 33, 43, 53});
}

TEST_CASE("a loop's time that goes back moves the slots of clocked back by at most what is stated, and they never turn") {
  ClockedMap map({{100, 1}, Duration{4'000'000}}, {}, Duration{});
  std::vector<std::int64_t> slots_ms;
  for (std::int64_t n = 0; n < 6; ++n) {
    map.simulated(SimTime{(n < 2 ? n : n - 1) * 10'000'000});  // step 2 is the second one at 10 ms
    slots_ms.push_back(map.read(n, RealTime{0}).read.ns / 1'000'000);
    map.emission(n, RealTime{0});
  }
  CHECK(slots_ms == std::vector<std::int64_t>{0, 10, 16, 22, 30, 40});
}

TEST_CASE("a lead and a latency shift the reads and the emissions of clocked by as much") {
  Draw draw(1);
  const Loop loop = random_loop(draw, 0);
  ClockedMap plain({.step_rate = loop.step_rate}, {}, Duration{}),
      shifted({.step_rate = loop.step_rate}, {7}, Duration{1'000});
  const std::vector<Placed> a = play(plain, loop), b = play(shifted, loop);
  for (std::size_t n = 0; n < a.size(); ++n) {
    CHECK(b[n].slot.read == a[n].slot.read - Duration{7});
    CHECK(b[n].emission == b[n].slot.read + Duration{1'000});
  }
}
