#include <cmath>

#include "catch.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

constexpr int kSegments = 20'000;
constexpr Duration kMeanStep{1'482'222};  // (1/30 s - 11.1 ms) / 15 to the nearest ns

ProgrammedTiming jittered(double variation, std::uint64_t seed = 1) {
  return {.visualization_variation = variation, .step_variation = variation, .seed = seed};
}

struct NamedRun {
  const char* description;
  ProgrammedTiming timing;
};

std::vector<NamedRun> free_running() {
  std::vector<NamedRun> all = {
      {"10 %", jittered(0.1)},
      {"1 %", jittered(0.01)},
      {"the visualization alone varies", {.visualization_variation = 0.1}},
      {"the steps alone vary", {.step_variation = 0.1}},
      {"several N", {.steps = {14, 15, 16}}},
      {"several N and 10 %", {.steps = {14, 15, 16}, .visualization_variation = 0.1, .step_variation = 0.1}},
      {"a fixed mean step", {.step = Duration{1'300'000}, .step_variation = 0.2}},
      {"no visualization", {.visualization = {0}, .step_variation = 0.1}},
      {"some segments without a step", {.steps = {0, 15}, .step_variation = 0.1}},
      {"no step at all", {.steps = {0}, .visualization_variation = 0.1}},
      {"steps that last 1 ns", {.steps = {3}, .step = Duration{1}, .visualization_variation = 0.1, .step_variation = 1.0}},
  };
  for (std::size_t i = 0, count = all.size(); i < count; ++i) {
    all.push_back(all[i]);
    all.back().timing.order = SegmentOrder::steps_first;
  }
  return all;
}

struct Moments {
  double mean, deviation;
};
Moments moments(const std::vector<Duration>& durations) {
  double sum = 0, sum_of_squares = 0;
  for (const Duration duration : durations) sum += static_cast<double>(duration.ns);
  const double mean = sum / static_cast<double>(durations.size());
  for (const Duration duration : durations) sum_of_squares += std::pow(static_cast<double>(duration.ns) - mean, 2);
  return {mean, std::sqrt(sum_of_squares / static_cast<double>(durations.size()))};
}

bool all_equal(const std::vector<Duration>& durations, Duration expected) {
  return !durations.empty() &&
         std::all_of(durations.begin(), durations.end(), [expected](Duration each) { return each == expected; });
}

/// Checks mean and deviation to 5 standard errors. The factor 1.1 is there because at 20 % the deviation of a log-normal
/// distribution is that much less certain than that of a normal one.
void check_log_normal(const std::vector<Duration>& durations, Duration mean, double variation) {
  const auto [measured_mean, measured_deviation] = moments(durations);
  const double expected = static_cast<double>(mean.ns), count = static_cast<double>(durations.size());
  CHECK(std::abs(measured_mean - expected) < 5 * variation * expected / std::sqrt(count));
  CHECK(std::abs(measured_deviation / (variation * expected) - 1) < 5 * 1.1 / std::sqrt(2 * count));
}

}  // namespace

TEST_CASE("a free-running schedule has no idle time and each part begins where the one before ended") {
  for (const auto& [description, programmed] : free_running()) {
    INFO(description << (programmed.order == SegmentOrder::steps_first ? ", steps first" : ", visualization first"));
    const auto segments = play(programmed, 1'000);
    CHECK(disorder(segments) == 0);
    std::int64_t wrong = 0;
    for (const SegmentTiming& segment : segments) {
      wrong += idle(segment) != Duration{0};
      wrong += segment.visualization.has_value() != (programmed.visualization.ns > 0);
      if (!segment.visualization) continue;
      wrong += programmed.order == SegmentOrder::steps_first ? segment.visualization->end != segment.end
                                                             : segment.visualization->begin != segment.begin;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("jitter keeps the means of visualization and step, and varies both by what was asked for") {
  for (const double variation : {0.01, 0.1, 0.2}) {
    INFO("variation " << variation);
    const auto segments = play(jittered(variation), kSegments);
    check_log_normal(visualization_durations(segments), {11'100'000}, variation);
    check_log_normal(step_durations(segments), kMeanStep, variation);
  }
}

TEST_CASE("with jitter the segments last 1/30 s on average") {
  const auto segments = play(jittered(0.1), kSegments);
  // The standard deviations of V and of 15 steps, added in quadrature, make that of a segment. The mean step is rounded by
  // less than half a ns.
  const double deviation = 0.1 * std::sqrt(11'100'000.0 * 11'100'000.0 + 15 * 1'482'222.0 * 1'482'222.0);
  const double measured = static_cast<double>(segments.back().end.ns) / kSegments;
  CHECK(std::abs(measured - 1e9 / 30) < 5 * deviation / std::sqrt(kSegments) + 15 * 0.5);
}

TEST_CASE("several N are drawn evenly, one per segment, and the mean step fills the mean segment") {
  const auto segments = play({.steps = {14, 15, 16, 20}}, kSegments);
  std::int64_t counts[21] = {};
  for (const SegmentTiming& segment : segments) ++counts[segment.steps.size()];
  for (const int n : {14, 15, 16, 20}) {
    INFO("N " << n);
    CHECK(std::abs(counts[n] - kSegments / 4.0) < 5 * std::sqrt(kSegments / 4.0 * 0.75));  // binomial
  }
  CHECK(counts[14] + counts[15] + counts[16] + counts[20] == kSegments);

  // (T - V) / mean(N) = 22 233 333.33 / 16.25 = 1 368 205.1 ns; the visualization does not vary.
  CHECK(all_equal(step_durations(segments), {1'368'205}));
  CHECK(all_equal(visualization_durations(segments), {11'100'000}));

  // 22 233 333.33 / 12 = 1 852 777.8 ns is rounded to the nearest ns, not down.
  CHECK(all_equal(step_durations(play({.steps = {11, 12, 13}}, 1'000)), {1'852'778}));
}

TEST_CASE("a list that holds one N twice is a list: free-running") {
  const auto segments = play({.steps = {15, 15}}, 1'000);
  // 15 x 1 482 222 + 11 100 000. The 3.33 ns that a rounded segment lacks add up, because segments are appended.
  CHECK(segments.back().end.ns == 1'000LL * 33'333'330);
}

TEST_CASE("a duration that does not vary is exact beside one that does") {
  CHECK(all_equal(step_durations(play({.visualization_variation = 0.1}, 1'000)), kMeanStep));
  CHECK(all_equal(visualization_durations(play({.step_variation = 0.1}, 1'000)), {11'100'000}));
}

TEST_CASE("the same seed gives the same timing, however calls of several sources interleave, another seed another") {
  for (const auto& [description, programmed] : free_running()) {
    INFO(description);
    const std::uint64_t alone = digest_of(play(programmed, 300));

    const auto first = make_programmed_timing(programmed), second = make_programmed_timing(programmed);
    std::vector<SegmentTiming> of_first(300), of_second(300);
    std::size_t i = 0, j = 0;
    while (i < 300 || j < 300) {
      const bool first_is_next = j == 300 || (i < 300 && (spread(i + 7 * j) & 1));
      if (first_is_next) {
        first->next(of_first[i++]);
      } else {
        second->next(of_second[j++]);
      }
    }
    CHECK(digest_of(of_first) == alone);
    CHECK(digest_of(of_second) == alone);

    ProgrammedTiming other = programmed;
    other.seed = 2;
    CHECK(digest_of(play(other, 300)) != alone);
  }
}

TEST_CASE("draws belong to the step and the segment, not to the order of drawing: a change elsewhere shifts none") {
  const auto reference = play(jittered(0.1), 1'000);

  SECTION("steps first: the same durations in another order") {
    ProgrammedTiming steps_first = jittered(0.1);
    steps_first.order = SegmentOrder::steps_first;
    const auto segments = play(steps_first, 1'000);
    CHECK(step_durations(segments) == step_durations(reference));
    CHECK(visualization_durations(segments) == visualization_durations(reference));
  }
  SECTION("no variation of the visualization: the same steps") {
    CHECK(step_durations(play({.step_variation = 0.1}, 1'000)) == step_durations(reference));
  }
  SECTION("no variation of the steps: the same visualizations") {
    CHECK(visualization_durations(play({.visualization_variation = 0.1}, 1'000)) == visualization_durations(reference));
  }
  SECTION("no visualization: the same steps, where their mean is the same") {
    ProgrammedTiming without = jittered(0.1);
    without.visualization = {0};
    without.step = kMeanStep;
    CHECK(step_durations(play(without, 1'000)) == step_durations(reference));
  }
  SECTION("another N: the same visualizations, and step n is step n whatever segment it falls in") {
    ProgrammedTiming fewer = jittered(0.1);
    fewer.steps = {5};
    fewer.step = kMeanStep;
    const auto segments = play(fewer, 3'000);
    CHECK(step_durations(segments) == step_durations(reference));
    auto visualizations = visualization_durations(segments);
    visualizations.resize(1'000);
    CHECK(visualizations == visualization_durations(reference));
  }
  SECTION("variation: the same N") {
    const auto even = play({.steps = {14, 15, 16}}, 1'000);
    const auto varied = play({.steps = {14, 15, 16}, .visualization_variation = 0.1, .step_variation = 0.1}, 1'000);
    for (std::size_t k = 0; k < even.size(); ++k) REQUIRE(even[k].steps.size() == varied[k].steps.size());
  }
}

// Recorded trace hashes depend on these instants. If this constant changes, those hashes change.
TEST_CASE("jittered timing has the instants it always had") {
  CHECK(digest_of(play({.steps = {14, 15, 16}, .visualization_variation = 0.1, .step_variation = 0.1, .seed = 7}, 10'000)) ==
        0xcab473ea582baa1eULL);
}
