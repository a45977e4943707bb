
#include "catch.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

Interval between(std::int64_t begin_ns, std::int64_t end_ns) { return {{begin_ns}, {end_ns}}; }

}  // namespace

TEST_CASE("a replay plays the segments given, as they are, and then ends for good") {
  auto recorded = play({.steps = {14, 15, 16}, .visualization_variation = 0.3, .step_variation = 0.3}, 200);
  // What real recordings hold: gaps, a dropped visualization, a segment without a step, one that runs beside the steps.
  recorded[3].visualization.reset();
  recorded[4].steps.clear();
  recorded[5].steps.front().begin = recorded[5].steps.front().begin + Duration{75'000};
  recorded[6].visualization->end = recorded[6].end;

  const auto timing = make_replayed_timing(recorded);
  std::vector<SegmentTiming> played;
  SegmentTiming segment;
  while (timing->next(segment)) played.push_back(segment);
  CHECK(played.size() == recorded.size());
  CHECK(digest_of(played) == digest_of(recorded));
  CHECK(played[6].overlaps());

  for (int i = 0; i < 3; ++i) {
    CHECK_FALSE(timing->next(segment));
    CHECK(digest_of({segment}) == digest_of({recorded.back()}));
  }
}

TEST_CASE("an empty recording ends at once") {
  SegmentTiming segment{.index = 5};
  CHECK_FALSE(make_replayed_timing({})->next(segment));
  CHECK(segment.index == 5);
}

TEST_CASE("a segment overlaps where its visualization and a step have more than an instant in common") {
  struct Row {
    const char* description;
    std::optional<Interval> visualization;
    std::vector<Interval> steps;
    bool overlaps;
  };
  const std::vector<Row> rows = {
      {"one after the other", between(0, 10), {between(10, 20), between(20, 30)}, false},
      {"the other way round", between(20, 30), {between(0, 10), between(10, 20)}, false},
      {"between two steps", between(10, 20), {between(0, 10), between(20, 30)}, false},
      {"with gaps", between(0, 10), {between(12, 20)}, false},
      {"the first step begins 1 ns too early", between(0, 10), {between(9, 20)}, true},
      {"the last step ends 1 ns too late", between(20, 30), {between(0, 10), between(10, 21)}, true},
      {"a step inside", between(0, 30), {between(10, 20)}, true},
      {"inside a step", between(10, 20), {between(0, 30)}, true},
      {"the same interval", between(0, 10), {between(0, 10)}, true},
      {"a step of no length inside", between(0, 10), {between(5, 5)}, false},
      {"a visualization of no length inside a step", between(5, 5), {between(0, 10)}, false},
      {"only the last of many", between(30, 40), {between(0, 10), between(10, 20), between(20, 31)}, true},
      {"no visualization", std::nullopt, {between(0, 10)}, false},
      {"no step", between(0, 10), {}, false},
  };
  for (const Row& row : rows) {
    INFO(row.description);
    SegmentTiming segment;
    segment.visualization = row.visualization;
    segment.steps = row.steps;
    CHECK(segment.overlaps() == row.overlaps);
  }
}

TEST_CASE("every placement of two short intervals: overlaps() agrees with counting common nanoseconds") {
  int wrong = 0, placements = 0;
  for (std::int64_t a = 0; a <= 6; ++a)
    for (std::int64_t b = a; b <= 6; ++b)
      for (std::int64_t c = 0; c <= 6; ++c)
        for (std::int64_t d = c; d <= 6; ++d) {
          SegmentTiming segment;
          segment.visualization = between(a, b);
          segment.steps = {between(c, d)};
          int common = 0;
          for (std::int64_t ns = 0; ns < 6; ++ns) common += a <= ns && ns < b && c <= ns && ns < d;
          wrong += segment.overlaps() != (common > 0);
          ++placements;
        }
  CHECK(placements == 28 * 28);
  CHECK(wrong == 0);
}
