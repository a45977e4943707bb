// evenstep size --step-size: whether the steps of a recording follow a clock of their own.
#include "catch.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/scheduler/step_timing.h"

using namespace evenstep;

namespace {

constexpr std::int64_t kMillisecond = 1'000'000;

/// Ten seconds of a game's loop; `keep`: with t(n).
std::vector<SegmentTiming> game(std::optional<int> max_steps, bool keep) {
  ProgrammedTiming timing{.segment = {60, 1},
                          .visualization = {4 * kMillisecond},
                          .steps = {1},
                          .step = Duration{kMillisecond / 2},
                          .order = SegmentOrder::steps_first,
                          .paced = true,
                          .accumulator = Accumulator{.step_rate = {90, 1}, .max_steps = max_steps}};
  if (max_steps) timing.hitch = Hitch{{2'000 * kMillisecond}, {95 * kMillisecond}};
  const auto frames = make_programmed_timing(timing);
  std::vector<SegmentTiming> segments(600);
  for (SegmentTiming& segment : segments) {
    REQUIRE(frames->next(segment));
    if (!keep) segment.simulated.clear();
  }
  return segments;
}

const SizeStrategy* clocked(const SizeRecord& record) {
  for (const SizeStrategy& strategy : record.strategies)
    if (strategy.name == "clocked") return &strategy;
  return nullptr;
}

}  // namespace

TEST_CASE("size says that the steps of a game's loop follow their clock, and gives clocked the latency it has with t(n)") {
  SizeOptions options;
  options.step_size = Rate{90, 1};
  const SizeRecord guessed = size_segments(game({}, false), "x", options), told = size_segments(game({}, true), "x", {});
  for (const SizeRecord* record : {&guessed, &told}) {
    REQUIRE(record->clock);
    CHECK(record->clock->follows);
    CHECK(record->clock->dropped == 0);
    CHECK(record->clock->range_steps < 1);
    CHECK(record->clock->pace.simulated_per_real() == Approx(1).margin(0.01));
    REQUIRE(clocked(*record));
    CHECK(clocked(*record)->velocity_jump < 1e-6);
  }
  CHECK(std::abs((clocked(guessed)->any_phase.latency - clocked(told)->any_phase.latency).ns) <= 2);
  CHECK_FALSE(size_segments(game({}, false), "x", {}).clock);
}

TEST_CASE("size finds the steps that a loop dropped, and clocked has the slots it has with t(n) to within two steps") {
  SizeOptions options;
  options.step_size = Rate{90, 1};
  const SizeRecord guessed = size_segments(game(3, false), "x", options), told = size_segments(game(3, true), "x", {});
  REQUIRE(guessed.clock);
  CHECK(guessed.clock->follows);
  CHECK(guessed.clock->drops == 5);  // hitches of 95 ms at 2, 4, 6, 8 and 10 s: 9 to 11 steps are due after each, and 3 run
  CHECK((guessed.clock->dropped >= 5 * 5 && guessed.clock->dropped <= 5 * 8));
  REQUIRE(clocked(guessed));
  CHECK(std::abs((clocked(guessed)->any_phase.latency - clocked(told)->any_phase.latency).ns) <= 2 * 11 * kMillisecond + 2);
}

TEST_CASE("size says of another step size, and of a loop that runs freely, that the steps follow no such clock") {
  SizeOptions options;
  for (const Rate wrong : {Rate{60, 1}, Rate{100, 1}, Rate{900, 1}}) {
    options.step_size = wrong;
    const SizeRecord record = size_segments(game({}, false), "x", options);
    REQUIRE(record.clock);
    CHECK_FALSE(record.clock->follows);
    CHECK(record.clock->pace.simulated_per_real() ==
          Approx(90.0 * static_cast<double>(wrong.den) / wrong.num).epsilon(0.01));
    CHECK(clocked(record) == nullptr);
  }
}
