// Loops with a fixed time step: how many steps each frame runs, and when.
#include "evenstep/scheduler/random.h"
#include "timing_checks.h"

namespace evenstep {
namespace {

/// A game at 60 frames a second: steps of 0.5 ms, drawings of 4 ms.
ProgrammedTiming game(Rate refresh, Rate steps) {
  return {.segment = refresh,
          .visualization = {4 * ms},
          .steps = {1},
          .step = Duration{ms / 2},
          .order = SegmentOrder::steps_first,
          .paced = true,
          .accumulator = Accumulator{.step_rate = steps}};
}

std::vector<std::size_t> counts(const std::vector<SegmentTiming>& frames) {
  std::vector<std::size_t> out;
  for (const SegmentTiming& frame : frames) out.push_back(frame.steps.size());
  return out;
}

TEST_CASE("frames of 60 Hz with steps of 90 Hz run one and two steps by turns, with 30 Hz none and one") {
  CHECK(counts(play(game({60, 1}, {90, 1}), 7)) == std::vector<std::size_t>{0, 1, 2, 1, 2, 1, 2});
  CHECK(counts(play(game({60, 1}, {30, 1}), 7)) == std::vector<std::size_t>{0, 0, 1, 0, 1, 0, 1});
  CHECK(counts(play(game({60, 1}, {60, 1}), 4)) == std::vector<std::size_t>{0, 1, 1, 1});
}

TEST_CASE("a frame has its steps and then its drawing, or the drawing first, and waits for the next refresh") {
  ProgrammedTiming timing = game({50, 1}, {100, 1});
  const SegmentTiming steps_first = play(timing, 3)[2];
  CHECK(steps_first.begin == RealTime{40 * ms});
  CHECK(steps_first.end == RealTime{60 * ms});
  REQUIRE(steps_first.steps.size() == 2);
  CHECK(steps_first.steps[1].end == RealTime{41 * ms});
  CHECK(steps_first.visualization->begin == RealTime{41 * ms});
  timing.order = SegmentOrder::visualization_first;
  const SegmentTiming drawing_first = play(timing, 3)[2];
  CHECK(drawing_first.visualization->begin == RealTime{40 * ms});
  CHECK(drawing_first.steps[0].begin == RealTime{44 * ms});
}

TEST_CASE("a frame whose work is too long for a refresh begins at the one after, and has more steps") {
  ProgrammedTiming timing = game({50, 1}, {100, 1});
  timing.hitch = Hitch{{100 * ms}, {30 * ms}};
  const std::vector<SegmentTiming> frames = play(timing, 8);
  CHECK(frames[5].begin == RealTime{100 * ms});
  CHECK(frames[6].begin == RealTime{140 * ms});
  CHECK(counts(frames) == std::vector<std::size_t>{0, 2, 2, 2, 2, 2, 4, 2});
}

TEST_CASE("of more steps than max_steps the oldest are dropped: t passes over them, and the steps that run are the newest") {
  ProgrammedTiming timing = game({50, 1}, {100, 1});
  timing.hitch = Hitch{{100 * ms}, {90 * ms}};
  timing.accumulator->max_steps = 3;
  const std::vector<SegmentTiming> frames = play(timing, 8);
  REQUIRE(frames[6].begin == RealTime{200 * ms});
  REQUIRE(counts(frames) == std::vector<std::size_t>{0, 2, 2, 2, 2, 2, 3, 3});
  CHECK(frames[5].simulated == std::vector<SimTime>{{80 * ms}, {90 * ms}});
  CHECK(frames[6].simulated == std::vector<SimTime>{{170 * ms}, {180 * ms}, {190 * ms}});
}

TEST_CASE("without a refresh to wait for a frame begins when the work of the one before has ended") {
  ProgrammedTiming timing = game({60, 1}, {100, 1});
  timing.paced = false;
  const std::vector<SegmentTiming> frames = play(timing, 1000);
  CHECK(disorder(frames) == 0);
  for (const SegmentTiming& frame : frames) CHECK(idle(frame).ns == 0);
  // V / (1 - s / dt) = 4 / 0.95 ms.
  CHECK(static_cast<double>(frames.back().begin.ns) / 999 == Approx(mean_timing(timing).segment_ns).epsilon(0.001));
}

TEST_CASE("refresh_jitter delays frames by all times up to it, and no frame is passed over") {
  ProgrammedTiming timing = game({60, 1}, {90, 1});
  timing.accumulator->refresh_jitter = {100};
  std::vector<int> seen(101);
  for (const SegmentTiming& frame : play(timing, 20'000)) {
    const std::int64_t late = (frame.begin - tick_time({60, 1}, frame.index)).ns;
    REQUIRE((late >= 0 && late <= 100));
    ++seen[static_cast<std::size_t>(late)];
  }
  // 198 expected, standard deviation 14.
  for (const int count : seen) CHECK((count > 120 && count < 290));
}

/// How often N is another one than in the frame before.
std::int64_t changes(const std::vector<SegmentTiming>& frames) {
  std::int64_t count = 0;
  for (std::size_t k = 1; k < frames.size(); ++k) count += frames[k].steps.size() != frames[k - 1].steps.size();
  return count;
}

TEST_CASE("jitter_fix keeps N at one where steps are as frequent as frames, and jitter alone would make it 0, 1 and 2") {
  // Steps come due later and later after the refresh, by 0.8 ms at the end, which is amid the jitter.
  ProgrammedTiming timing = game({60, 1}, {59'999, 1'000});
  timing.accumulator->refresh_jitter = {2 * ms};
  CHECK(changes(play(timing, 3'000)) > 500);
  timing.accumulator->jitter_fix = {8 * ms};
  CHECK(changes(play(timing, 3'000)) <= 3);
}

TEST_CASE("no frame is ahead of what is due by more than jitter_fix, nor behind by more than it and a step, in 10 000 loops",
          "[sweep]") {
  for (std::uint64_t seed = 0; seed < 10'000; ++seed) {
    const RandomStream random(seed, "loops");
    const auto draw = [&](std::uint64_t n, std::int64_t least, std::int64_t most) {
      return least + static_cast<std::int64_t>(random.below(n, static_cast<std::uint64_t>(most - least + 1)));
    };
    ProgrammedTiming timing = game({draw(0, 20, 200), 1}, {draw(1, 10, 600), draw(2, 1, 3)});
    timing.seed = seed;
    timing.paced = draw(3, 0, 2) > 0;
    timing.order = draw(4, 0, 1) == 0 ? SegmentOrder::steps_first : SegmentOrder::visualization_first;
    timing.step = Duration{draw(5, 1'000, 1'400'000)};
    timing.step_variation = 0.1;
    timing.visualization_variation = 0.3;
    if (draw(6, 0, 1) == 0) timing.hitch = Hitch{{draw(7, 100, 300) * ms}, {draw(8, 20, 90) * ms}};
    Accumulator& loop = *timing.accumulator;
    const Duration size{instant_ns(loop.step_rate, 1)};
    loop.jitter_fix = draw(9, 0, 1) == 0 ? Duration{0} : Duration{draw(10, 0, size.ns)};
    if (draw(11, 0, 1) == 0) loop.max_steps = static_cast<int>(draw(12, 1, 12));
    if (timing.paced) loop.refresh_jitter = {draw(13, 0, 2 * ms)};
    const std::vector<SegmentTiming> frames = play(timing, 60);
    REQUIRE(disorder(frames) == 0);
    SimTime next{0};  // the earliest that the next step can stand for
    for (const SegmentTiming& frame : frames) {
      REQUIRE(frame.simulated.size() == frame.steps.size());
      REQUIRE((!loop.max_steps || frame.steps.size() <= static_cast<std::size_t>(*loop.max_steps)));
      for (std::size_t i = 0; i < frame.steps.size(); ++i) {
        const SimTime at = frame.simulated[i];
        // Sizes are floors of exact multiples, so they may differ by 1 ns.
        if (i > 0) REQUIRE(at.ns <= next.ns + 1);
        REQUIRE(at.ns >= next.ns);
        if (at.ns > next.ns + 1) REQUIRE(frame.steps.size() == static_cast<std::size_t>(loop.max_steps.value_or(-1)));
        REQUIRE(at.ns + size.ns <= frame.begin.ns + loop.jitter_fix.ns + 1);
        next = {at.ns + size.ns};
      }
      REQUIRE(frame.begin.ns - next.ns <= size.ns + loop.jitter_fix.ns + 1);
    }
  }
}

TEST_CASE(
    "the same seed gives the same frames, and adding jitter_fix leaves the lengths of steps and drawings as they were") {
  ProgrammedTiming timing = game({60, 1}, {90, 1});
  timing.step_variation = timing.visualization_variation = 0.2;
  timing.seed = 7;
  const std::vector<SegmentTiming> once = play(timing, 200), again = play(timing, 200);
  for (std::size_t k = 0; k < once.size(); ++k) CHECK(once[k].begin == again[k].begin);
  timing.accumulator->jitter_fix = {5 * ms};
  const std::vector<SegmentTiming> fixed = play(timing, 200);
  for (std::size_t k = 0; k < once.size(); ++k) CHECK(length(*once[k].visualization) == length(*fixed[k].visualization));
}

}  // namespace
}  // namespace evenstep
