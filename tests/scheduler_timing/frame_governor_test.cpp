// The governor of visualizations: what it may draw in a pause, that it loses and changes no step, and that it does not know
// the future.
#include "evenstep/scheduler/frame_governor.h"
#include "governor_schedules.h"

using namespace evenstep;
using namespace evenstep::governor_schedules;

TEST_CASE("a governor that is asked for nothing gives any schedule back as it was", "[governor]") {
  std::int64_t different = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    std::vector<SegmentTiming> same = governed(source, {}, any_grid(seed));
    std::vector<SegmentTiming> expected;
    for (const SegmentTiming& segment : source) {
      if (segment.visualization || !segment.steps.empty()) expected.push_back(segment);
    }
    for (std::size_t k = 0; k < expected.size(); ++k) expected[k].index = static_cast<std::int64_t>(k);
    different += digest_of(same) != digest_of(expected);
  }
  CHECK(different == 0);
}

TEST_CASE("a governor loses, changes and overlaps no step of any schedule", "[governor]") {
  std::int64_t wrong = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    const auto after = governed(source, any_governor(seed), any_grid(seed));
    wrong += step_durations(after) != step_durations(source) || out_of_order(after) > 0;
  }
  CHECK(wrong == 0);
}

TEST_CASE("where a drawing can be cut off no pause of any schedule is over the budget", "[governor]") {
  std::int64_t over = 0, kept_over = 0, reached = 0, unaccounted = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    FrameGovernor governor = any_governor(seed);
    governor.over_budget = OverBudget::merge;
    const auto after = governed(source, governor, any_grid(seed));
    if (!governor.budget) continue;
    over += longest_pause(after) > *governor.budget;
    for (const SegmentTiming& segment : after) {
      const bool pause_first =
          segment.visualization && !segment.steps.empty() && segment.visualization->begin < segment.steps.front().begin;
      // Gaps of the source, at most 1 us each, do not belong to the pause.
      kept_over += pause_first && segment.steps.front().begin - segment.begin > *governor.budget + Duration{1000};
    }
    reached += longest_pause(after) == *governor.budget;
    // Each drawing of the source is finished, merged into the one before, or unfinished at the end.
    const std::int64_t open = drawings(source) - finished(after) - left_out(after);
    unaccounted += open != 0 && open != 1;
  }
  CHECK(over == 0);
  CHECK(kept_over == 0);
  CHECK(reached > evenstep::testing::cases(600));  // otherwise the budgets were never tight
  CHECK(unaccounted == 0);
}

TEST_CASE("a drawing in parts takes as long as it did in one, and no part more than its share", "[governor]") {
  std::int64_t wrong = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    const auto source = any_schedule(seed);
    FrameGovernor governor;
    governor.split = 1 + static_cast<int>(seed % 7);
    const auto after = governed(source, governor, any_grid(seed));
    wrong += drawn_ns(after) != drawn_ns(source) || finished(after) != drawings(source) || left_out(after) != 0;
    wrong += longest_pause(after).ns > (longest_pause(source).ns + governor.split - 1) / governor.split;
  }
  CHECK(wrong == 0);
}

TEST_CASE("a governor that knows how long drawings take makes none that is over its budget", "[governor]") {
  std::int64_t wrong = 0, left = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    FrameGovernor governor = any_governor(seed);
    if (governor.over_budget == OverBudget::merge || !governor.budget) continue;
    governor.forecast = 0;
    const auto source = any_schedule(seed);
    const auto after = governed(source, governor, any_grid(seed));
    wrong += longest_pause(after) > *governor.budget || left_out(after) + finished(after) != drawings(source);
    left += left_out(after);
  }
  CHECK(wrong == 0);
  CHECK(left > evenstep::testing::cases(5000));
}

TEST_CASE("a governor leaves out no more drawings in a row than it looks back", "[governor]") {
  std::int64_t wrong = 0, most_seen = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    FrameGovernor governor = any_governor(seed);
    if (governor.over_budget == OverBudget::merge || governor.forecast == 0) continue;
    std::int64_t in_a_row = 0;
    for (const SegmentTiming& segment : governed(any_schedule(seed), governor, any_grid(seed))) {
      if (segment.visualization) in_a_row = 0;
      if (segment.drawing.left_out) ++in_a_row;
      wrong += in_a_row > governor.forecast;
      most_seen = std::max(most_seen, in_a_row);
    }
  }
  CHECK(wrong == 0);
  CHECK(most_seen == 3);  // any_governor looks back by 3 at most
}

TEST_CASE("what a governor did so far does not depend on what comes", "[governor]") {
  std::int64_t wrong = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(kSchedules); ++seed) {
    FrameGovernor governor = any_governor(seed);
    governor.forecast = std::max(governor.forecast, 1);
    std::vector<SegmentTiming> source = any_schedule(seed), other = source;
    const std::size_t from = 20;
    for (std::size_t k = from; k < other.size(); ++k) {  // from there on everything takes three times as long
      SegmentTiming& segment = other[k];
      const RealTime origin = other[from].begin;
      const auto stretch = [&](Interval& i) { i = {origin + (i.begin - origin) * 3, origin + (i.end - origin) * 3}; };
      if (segment.visualization) stretch(*segment.visualization);
      for (Interval& step : segment.steps) stretch(step);
      if (k > from) segment.begin = origin + (segment.begin - origin) * 3;
      segment.end = origin + (segment.end - origin) * 3;
    }
    const auto a = governed(source, governor, any_grid(seed)), b = governed(other, governor, any_grid(seed));
    source.resize(from);
    const std::size_t same = governed(source, governor, any_grid(seed)).size();
    for (std::size_t k = 0; k < same; ++k) wrong += digest_of({a.at(k)}) != digest_of({b.at(k)});
  }
  CHECK(wrong == 0);
}

TEST_CASE("the rest of a drawing over its budget takes the place of the next ones", "[governor]") {
  FrameGovernor governor;
  governor.budget = Duration{10 * kMs};
  const auto after = governed(free_running({4, 25, 4, 4, 4}), governor);
  CHECK(pauses_ms(after) == std::vector<std::int64_t>{4, 10, 10, 5, 4});
  CHECK(left_out(after) == 2);
  CHECK(finished(after) == 3);
  CHECK(after[3].steps.front().begin - after[3].begin == Duration{10 * kMs});  // 5 ms of rest instead of the usual 14.5 ms
  CHECK(after.back().end == RealTime{(4 + 10 + 10 + 10 + 4 + 20) * kMs});
}

TEST_CASE("a drawing that is skipped lets the steps follow at once, one that is held keeps their place", "[governor]") {
  FrameGovernor governor{.budget = Duration{10 * kMs}, .over_budget = OverBudget::skip, .forecast = 0};
  const auto source = free_running({4, 25, 4, 25, 6});
  const auto skipped = governed(source, governor);
  CHECK(pauses_ms(skipped) == std::vector<std::int64_t>{4, 0, 4, 0, 6});
  CHECK(skipped[1].steps.front().begin == skipped[1].begin);
  governor.over_budget = OverBudget::hold;
  const auto held = governed(source, governor);
  CHECK(pauses_ms(held) == pauses_ms(skipped));
  for (const std::size_t k : {1, 3}) CHECK(held[k].steps.front().begin - held[k].begin == Duration{4 * kMs});
}

TEST_CASE("a held pause is as long as the mean of the last eight parts that were drawn, and no older one", "[governor]") {
  const FrameGovernor governor{.budget = Duration{10 * kMs}, .over_budget = OverBudget::hold, .forecast = 0};
  const auto held = governed(free_running({9, 2, 2, 2, 2, 2, 4, 4, 4, 25, 4}), governor);
  CHECK(held[9].steps.front().begin - held[9].begin == Duration{(5 * 2 + 3 * 4) * kMs / 8});
}

TEST_CASE("a forecast is late by one drawing, and tries again after as many as it looks back", "[governor]") {
  FrameGovernor governor{.budget = Duration{10 * kMs}, .over_budget = OverBudget::skip, .forecast = 2};
  const auto after = governed(free_running({4, 25, 25, 25, 25, 4, 4, 4, 4}), governor);
  CHECK(pauses_ms(after) == std::vector<std::int64_t>{4, 25, 0, 0, 25, 0, 0, 4, 4});
}

TEST_CASE("drawings that really run are budgeted by what they took", "[governor]") {
  const auto source = free_running({4, 4, 4, 4, 4, 4});
  SegmentTiming segment;
  SECTION("a forecast believes the clock") {
    const auto timing = make_governed_timing(
        make_replayed_timing(source), {.budget = Duration{10 * kMs}, .over_budget = OverBudget::skip, .forecast = 1}, {});
    REQUIRE(timing->next(segment));
    timing->visualized(Duration{30 * kMs}, true);
    REQUIRE(timing->next(segment));
    CHECK(segment.drawing.left_out);
  }
  SECTION("a drawing that is not finished goes on") {
    const auto timing = make_governed_timing(make_replayed_timing(source), {.budget = Duration{10 * kMs}}, {});
    REQUIRE(timing->next(segment));
    CHECK(segment.drawing.at_most == Duration{10 * kMs});
    timing->visualized(Duration{10 * kMs}, false);
    REQUIRE(timing->next(segment));
    CHECK(segment.drawing.left_out);
    CHECK(segment.visualization);
    timing->visualized(Duration{3 * kMs}, true);
    REQUIRE(timing->next(segment));
    CHECK_FALSE(segment.drawing.left_out);
  }
}

TEST_CASE("a source on a grid shares out its idle time between the parts", "[governor]") {
  std::vector<SegmentTiming> source;
  for (int k = 0; k < 5; ++k) {
    const RealTime at{k * 40 * kMs};
    SegmentTiming segment{k, at, Interval{at, at + Duration{8 * kMs}}, {}, at + Duration{10 * kMs}};
    for (int i = 0; i < 2; ++i) segment.steps.push_back({at + Duration{(8 + i) * kMs}, at + Duration{(9 + i) * kMs}});
    source.push_back(segment);
  }
  CHECK(grid_period(source) == Duration{40 * kMs});
  FrameGovernor governor;
  governor.split = 2;
  const auto after = governed(source, governor, grid_period(source));
  REQUIRE(after.size() == 10);
  for (std::size_t k = 0; k < 10; ++k) {
    CHECK(after[k].begin == RealTime{static_cast<std::int64_t>(k) * 20 * kMs});
    CHECK(after[k].steps.front().begin - after[k].begin == Duration{4 * kMs});
  }
}

TEST_CASE("paced segments begin on their grid or when the one before is over", "[governor]") {
  FrameGovernor governor;
  governor.pace = Duration{20 * kMs};
  const auto after = governed(free_running({4, 25, 4, 4, 4}), governor);
  std::vector<std::int64_t> begins;
  for (const SegmentTiming& segment : after) begins.push_back(segment.begin.ns / kMs);
  CHECK(begins == std::vector<std::int64_t>{0, 20, 49, 60, 80});
}
