// What each model draws, compared with its distribution; and that no model shifts the draws of another. Tolerances are 5
// standard errors: if the seed were drawn anew, each number would give one false alarm in 2 million.
#include <cmath>

#include "cases.h"
#include "catch.h"
#include "evenstep/scheduler/random.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

ProgrammedTiming jittered() { return {.step = Duration{1'500'000}, .visualization_variation = 0.1, .step_variation = 0.1}; }

/// with - without, element by element.
std::vector<std::int64_t> differences(const std::vector<Duration>& with, const std::vector<Duration>& without) {
  REQUIRE(with.size() == without.size());
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < with.size(); ++i) out.push_back((with[i] - without[i]).ns);
  return out;
}

std::int64_t count_positive(const std::vector<std::int64_t>& values) {
  return std::count_if(values.begin(), values.end(), [](std::int64_t value) { return value > 0; });
}

/// Checks that |successes - n p| is within 5 standard errors of a binomial count.
void check_binomial(std::int64_t successes, double n, double p) {
  INFO(successes << " of " << n << " at p = " << p);
  CHECK(std::abs(static_cast<double>(successes) - n * p) < 5 * std::sqrt(n * p * (1 - p)));
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// A mean and its standard error, from the means of 50 batches. Values may be correlated within a batch, but hardly between
/// batches.
struct Estimate {
  double mean, error;
};
Estimate batch_means(const std::vector<double>& values) {
  const std::size_t size = values.size() / 50;
  std::vector<double> means;
  for (std::size_t b = 0; b < 50; ++b) {
    means.push_back(
        mean_of({values.begin() + static_cast<long>(b * size), values.begin() + static_cast<long>((b + 1) * size)}));
  }
  const double mean = mean_of(means);
  double variance = 0;
  for (const double one : means) variance += (one - mean) * (one - mean) / 49;
  return {mean, std::sqrt(variance / 50)};
}

}  // namespace

TEST_CASE("spikes: a step of length d is hit with probability 1 - exp(-rate d), and then costs that much more", "[sweep]") {
  for (const std::int64_t step_ns : {ms / 2, 3 * ms / 2, 20 * ms}) {
    INFO("step " << step_ns);
    ProgrammedTiming timing{.step = Duration{step_ns}, .spikes = Spikes{20, {4 * ms}}};
    const auto durations = step_durations(play(timing, 20'000));
    std::int64_t hits = 0;
    for (const Duration duration : durations) {
      REQUIRE((duration.ns == step_ns || duration.ns == step_ns + 4 * ms));
      hits += duration.ns > step_ns;
    }
    check_binomial(hits, static_cast<double>(durations.size()), 1 - std::exp(-20e-9 * static_cast<double>(step_ns)));
  }
}

TEST_CASE("spikes hit no visualization, and a rate beyond every bound hits each step once") {
  ProgrammedTiming timing = jittered();
  const auto without = play(timing, 1'000);
  timing.spikes = Spikes{1e9, {4 * ms}};
  const auto with = play(timing, 1'000);
  CHECK(visualization_durations(with) == visualization_durations(without));
  for (const std::int64_t added : differences(step_durations(with), step_durations(without))) REQUIRE(added == 4 * ms);
}

TEST_CASE("pre-emption hits steps and visualizations alike, by their lengths") {
  ProgrammedTiming timing{.step = Duration{1'500'000}};
  timing.steps = {15, 15};
  const auto without = play(timing, 20'000);
  timing.preemption = Preemption{10, {3 * ms}, {40 * ms}, 1.5};
  const auto with = play(timing, 20'000);
  check_binomial(count_positive(differences(step_durations(with), step_durations(without))), 300'000, 1 - std::exp(-0.015));
  check_binomial(count_positive(differences(visualization_durations(with), visualization_durations(without))), 20'000,
                 1 - std::exp(-0.111));
}

TEST_CASE("the cost of a pre-emption is Pareto between its bounds: Kolmogorov distance of 50 000 draws, three tails",
          "[sweep]") {
  for (const double tail : {0.5, 1.0, 1.5, 4.0}) {
    INFO("tail " << tail);
    ProgrammedTiming timing{.visualization = {0}, .steps = {1}, .step = Duration{1 * ms}};
    timing.preemption = Preemption{1e9, {3 * ms}, {40 * ms}, tail};
    std::vector<double> costs;
    for (const Duration duration : step_durations(play(timing, 50'000)))
      costs.push_back(static_cast<double>(duration.ns - 1 * ms));
    std::sort(costs.begin(), costs.end());
    CHECK(costs.front() >= 3 * ms);
    CHECK(costs.back() <= 40 * ms);
    double distance = 0;
    const double n = static_cast<double>(costs.size()), q = std::pow(3.0 / 40, tail);
    for (std::size_t i = 0; i < costs.size(); ++i) {
      const double cdf = (1 - std::pow(3 * ms / costs[i], tail)) / (1 - q);
      distance =
          std::max({distance, std::abs(cdf - static_cast<double>(i) / n), std::abs(cdf - static_cast<double>(i + 1) / n)});
    }
    // P(sqrt(n) D > 2.2) = 2 exp(-2 * 2.2^2) = 1.3e-4.
    CHECK(distance < 2.2 / std::sqrt(n));

    // The mean in closed form, compared to within 5 standard errors of the sample.
    double variance = 0;
    const double mean = mean_of(costs);
    for (const double cost : costs) variance += (cost - mean) * (cost - mean) / n;
    const double expected = mean_timing(timing).step_ns - 1 * ms;
    CHECK(std::abs(mean - expected) < 5 * std::sqrt(variance / n));
  }
}

TEST_CASE("a pre-emption whose bounds are one time costs that time") {
  ProgrammedTiming timing{.visualization = {0}, .steps = {1}, .step = Duration{1 * ms}};
  timing.preemption = Preemption{1e9, {3 * ms}, {3 * ms}, 1.5};
  for (const Duration duration : step_durations(play(timing, 1'000))) REQUIRE(duration.ns == 4 * ms);
  CHECK(mean_timing(timing).step_ns == 4 * ms);
}

TEST_CASE("regimes: two lengths of the visualization, a factor apart, mean V, lag-1 correlation 1 - 2 / mean length",
          "[sweep]") {
  for (const double mean_length : {1.25, 2.0, 8.0, 50.0}) {
    INFO("mean length " << mean_length);
    const Regimes regimes{1.6, mean_length};
    const int n = 50'000;
    const auto durations = visualization_durations(play({.visualization = {13 * ms}, .regimes = regimes}, n));
    std::int64_t slow = 0, changes = 0;
    for (std::size_t k = 0; k < durations.size(); ++k) {
      // 2 V / 2.6 = 10 ms and 16 ms.
      REQUIRE((durations[k].ns == 10 * ms || durations[k].ns == 16 * ms));
      slow += durations[k].ns == 16 * ms;
      changes += k > 0 && durations[k] != durations[k - 1];
    }
    // For two values that are equally likely, the lag-1 correlation is 1 - 2 P(change).
    check_binomial(changes, n - 1, 1 / mean_length);
    // The number of slow segments is a correlated count. Its variance is (1 + rho) / (1 - rho) = mean_length - 1 times that
    // of a binomial count.
    CHECK(std::abs(static_cast<double>(slow) - n / 2.0) < 5 * std::sqrt(n / 4.0 * (mean_length - 1)));
  }
}

TEST_CASE("regimes of unequal shares: each level as often as asked, for as long as asked, and the mean stays V", "[sweep]") {
  for (const double share : {0.1, 0.3, 0.8}) {
    for (const double mean_length : {6.0, 20.0}) {
      INFO("share " << share << " mean length " << mean_length);
      const int n = 50'000;
      const auto durations =
          visualization_durations(play({.visualization = {13 * ms}, .regimes = Regimes{1.6, mean_length, share}}, n));
      const std::int64_t low_ns = std::min_element(durations.begin(), durations.end())->ns;
      std::int64_t slow = 0, to_slow = 0, to_fast = 0;
      for (std::size_t k = 0; k < durations.size(); ++k) {
        const bool is_slow = durations[k].ns != low_ns;
        slow += is_slow;
        if (k == 0 || durations[k] == durations[k - 1]) continue;
        ++(is_slow ? to_slow : to_fast);
      }
      CHECK(static_cast<double>(low_ns) == Approx(13e6 / (1 - share + share * 1.6)).epsilon(1e-6));
      check_binomial(to_slow, n - slow, 1 / (2 * (1 - share) * mean_length));
      check_binomial(to_fast, slow, 1 / (2 * share * mean_length));
      // The variance of a correlated count is (1 + rho) / (1 - rho) times that of a binomial count.
      const double rho = 1 - 1 / (2 * share * mean_length) - 1 / (2 * (1 - share) * mean_length);
      const double deviation = std::sqrt(n * share * (1 - share) * (1 + rho) / (1 - rho));
      CHECK(std::abs(static_cast<double>(slow) - n * share) < 5 * deviation);
    }
  }
}

TEST_CASE("regimes begin in either one by a fair draw of the seed, and mean length 1 alternates") {
  std::int64_t slow_at_first = 0;
  for (std::uint64_t seed = 0; seed < 2'000; ++seed) {
    const auto segments = play({.visualization = {13 * ms}, .regimes = Regimes{1.6, 1e6}, .seed = seed}, 1);
    slow_at_first += length(*segments[0].visualization).ns == 16 * ms;
  }
  check_binomial(slow_at_first, 2'000, 0.5);
  const auto alternating = visualization_durations(play({.regimes = Regimes{2, 1}}, 100));
  for (std::size_t k = 1; k < alternating.size(); ++k) CHECK(alternating[k] != alternating[k - 1]);
}

TEST_CASE("dropped and merged visualizations come as often as asked, and each segment by itself", "[sweep]") {
  const auto segments =
      play({.visualization_variation = 0.1, .dropped_visualization = 0.1, .merged_visualization = 0.2}, 50'000);
  const auto plain = play({.visualization_variation = 0.1}, 50'000);
  std::int64_t dropped = 0, merged = 0, dropped_twice = 0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const bool none = !segments[k].visualization;
    dropped += none;
    dropped_twice += none && k > 0 && !segments[k - 1].visualization;
    if (none) continue;
    const std::int64_t once = length(*plain[k].visualization).ns, drawn = length(*segments[k].visualization).ns;
    REQUIRE((drawn == once || drawn == 2 * once));
    merged += drawn == 2 * once;
  }
  check_binomial(dropped, 50'000, 0.1);
  check_binomial(merged, 50'000, 0.2);
  check_binomial(dropped_twice, 49'999, 0.01);
}

TEST_CASE("uniform jitter lies within its share of the mean, each length as likely: Kolmogorov distance of 50 000 draws",
          "[sweep]") {
  for (const double width : {0.01, 0.3, 1.0}) {
    ProgrammedTiming timing{.visualization_variation = width, .step_variation = width};
    timing.visualization_law = timing.step_law = JitterLaw::uniform;
    timing.step = Duration{1'500'000};
    const auto segments = play(timing, 50'000);
    std::vector<double> lengths;
    for (const SegmentTiming& segment : segments) {
      lengths.push_back(static_cast<double>(length(*segment.visualization).ns));
      // Rounding adds half a nanosecond. At a width of 100 % at least 1 ns remains.
      CHECK(std::abs(lengths.back() - 11.1e6) <= width * 11.1e6 + 0.5);
    }
    std::sort(lengths.begin(), lengths.end());
    double distance = 0;
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      const double below = (lengths[i] / 11.1e6 - 1 + width) / (2 * width), rank = static_cast<double>(i) / 50'000;
      distance = std::max({distance, below - rank, rank + 1 / 50'000.0 - below});
    }
    INFO("width " << width);
    CHECK(distance < 2.2 / std::sqrt(50'000));  // P = 1.3e-4
    const std::vector<Duration> steps = step_durations(segments);
    const auto [least, most] = std::minmax_element(steps.begin(), steps.end());
    CHECK(static_cast<double>(least->ns) == Approx(1.5e6 * (1 - width)).margin(1.5e6 * width * 1e-4 + 1));
    CHECK(static_cast<double>(most->ns) == Approx(1.5e6 * (1 + width)).margin(1.5e6 * width * 1e-4 + 1));
  }
}

TEST_CASE("a hitch is the first visualization at or after each multiple of its period, and no other") {
  ProgrammedTiming timing{.step = Duration{1'500'000}, .step_variation = 0.1};
  timing.hitch = Hitch{{500 * ms}, {30 * ms}};
  RealTime before{-1};
  std::int64_t hitches = 0;
  const auto segments = play(timing, 2'000);
  for (const SegmentTiming& segment : segments) {
    const std::int64_t multiple = segment.begin.ns / (500 * ms) * 500 * ms;
    const bool expected = multiple > 0 && multiple > before.ns;
    CHECK(length(*segment.visualization).ns == (expected ? 30 * ms : 11'100'000));
    hitches += expected;
    before = segment.begin;
  }
  CHECK(hitches == segments.back().begin.ns / (500 * ms));
}

TEST_CASE("a period shorter than a segment makes every visualization but the first a hitch") {
  ProgrammedTiming timing{.step = Duration{1'500'000}};
  timing.hitch = Hitch{{25 * ms}, {20 * ms}};
  const auto segments = play(timing, 100);
  CHECK(length(*segments[0].visualization).ns == 11'100'000);
  for (std::size_t k = 1; k < segments.size(); ++k) CHECK(length(*segments[k].visualization).ns == 20 * ms);
}

TEST_CASE("on a grid a hitch takes place in its segment, and the grid is reached again") {
  ProgrammedTiming timing{.step = Duration{1'000'000}, .paced = true};
  timing.hitch = Hitch{{1'000 * ms}, {40 * ms}};
  const auto segments = play(timing, 300);
  std::int64_t late = 0;
  for (const SegmentTiming& segment : segments) late += segment.begin > tick_time({30, 1}, segment.index);
  // A hitch makes 40 + 15 ms of a segment of 33.3 ms, of which 7.2 ms are usually idle. So the next segments are 21.7 ms
  // late, then 14.4 and 7.2 ms. Hitches are in segments 30, 60, ..., 270.
  CHECK(late == 9 * 3);
}

TEST_CASE("no model shifts another's draws: with all others added, each still does what it does alone") {
  const int n = 3'000;
  const auto bare = play(jittered(), n);
  const auto with = [&](auto add) {
    ProgrammedTiming timing = jittered();
    add(timing);
    return play(timing, n);
  };
  const auto spiked = with([](ProgrammedTiming& t) { t.spikes = Spikes{20, {4 * ms}}; });
  const auto hit = with([](ProgrammedTiming& t) { t.preemption = Preemption{20, {3 * ms}, {40 * ms}, 1.5}; });
  const auto both = with([](ProgrammedTiming& t) {
    t.spikes = Spikes{20, {4 * ms}};
    t.preemption = Preemption{20, {3 * ms}, {40 * ms}, 1.5};
    t.regimes = Regimes{1.6, 8};
    t.dropped_visualization = 0.02;
    t.steps = {15, 15};
  });
  const auto bare_steps = step_durations(bare);
  const auto spikes = differences(step_durations(spiked), bare_steps), hits = differences(step_durations(hit), bare_steps);
  const auto all = differences(step_durations(both), bare_steps);
  CHECK(count_positive(spikes) > 1'000);
  CHECK(count_positive(hits) > 1'000);
  for (std::size_t i = 0; i < all.size(); ++i) REQUIRE(all[i] == spikes[i] + hits[i]);

  const auto late = differences(visualization_durations(hit), visualization_durations(bare));
  CHECK(count_positive(late) > 400);
  for (const std::int64_t added : late) REQUIRE((added == 0 || (added >= 3 * ms && added <= 40 * ms)));
  // Spikes and pre-emption of a step are independent: both hit it with the product of their probabilities (3 % each).
  std::int64_t twice = 0;
  for (std::size_t i = 0; i < all.size(); ++i) twice += spikes[i] > 0 && hits[i] > 0;
  check_binomial(twice, static_cast<double>(all.size()), std::pow(1 - std::exp(-0.03), 2));
}

TEST_CASE("regimes, drift and the first step scale the log-normal draw that was there before") {
  ProgrammedTiming timing = jittered();
  const auto bare = play(timing, 2'000);
  timing.regimes = Regimes{1.6, 8};
  timing.drift_per_s = 0.01;
  timing.first_step = 0.3;
  const auto varied = play(timing, 2'000);
  for (std::size_t k = 0; k < bare.size(); ++k) {
    const double drift = 1 + 0.01 * seconds(varied[k].begin);
    const double ratio = static_cast<double>(length(*varied[k].visualization).ns) /
                         static_cast<double>(length(*bare[k].visualization).ns) / drift;
    // The mean in a regime and a duration are each rounded by up to half a ns, of 8 ms.
    REQUIRE((std::abs(ratio - 2 / 2.6) < 2e-7 || std::abs(ratio - 3.2 / 2.6) < 2e-7));
    for (std::size_t i = 0; i < 15; ++i) {
      const double expected = static_cast<double>(length(bare[k].steps[i]).ns) * drift * (i == 0 ? 1.3 : 1);
      REQUIRE(std::abs(static_cast<double>(length(varied[k].steps[i]).ns) - expected) <= 0.51);
    }
  }
}

TEST_CASE("the means that are stated are the means that are played", "[sweep]") {
  ProgrammedTiming all = jittered();
  all.first_step = 0.4;
  all.spikes = Spikes{10, {4 * ms}};
  all.preemption = Preemption{5, {3 * ms}, {40 * ms}, 1.5};
  all.regimes = Regimes{1.6, 8};
  all.dropped_visualization = 0.05;
  all.merged_visualization = 0.1;
  all.hitch = Hitch{{300 * ms}, {25 * ms}};
  std::vector<ProgrammedTiming> timings(7, jittered());
  timings[0].first_step = 0.4;
  timings[1].spikes = Spikes{10, {4 * ms}};
  timings[2].preemption = Preemption{5, {3 * ms}, {40 * ms}, 1.5};
  timings[3].regimes = Regimes{1.6, 8};
  timings[4].dropped_visualization = 0.05;
  timings[4].first_step = 0.4;
  timings[5].merged_visualization = 0.1;
  timings[6].steps = {3, 9};
  timings.push_back(timings[2]);
  timings.back().merged_visualization = 1;
  timings.push_back(all);
  timings.push_back(jittered());
  timings.back().visualization_law = timings.back().step_law = JitterLaw::uniform;
  timings.back().hitch = Hitch{{200 * ms}, {31 * ms}};
  for (std::size_t i = 0; i < timings.size(); ++i) {
    INFO("timing " << i);
    std::vector<double> lengths;
    for (const SegmentTiming& segment : play(timings[i], 20'000))
      lengths.push_back(static_cast<double>((segment.end - segment.begin).ns));
    const auto [mean, error] = batch_means(lengths);
    // 5 standard errors are allowed. With 10 % jitter at 10 Hz, the number of hits of a step differs from that of a mean
    // step by 1e-6.
    CHECK(std::abs(mean - mean_timing(timings[i]).segment_ns) < 5 * error);
  }
}

TEST_CASE("ten thousand random combinations keep the order of a schedule, and each is the same again for its seed") {
  const RandomStream random(1, "combinations");
  std::uint64_t draw = 0;
  const auto chance = [&](double p) { return random.uniform(draw++) < p; };
  const auto between = [&](double least, double most) { return least + (most - least) * random.uniform(draw++); };
  std::int64_t wrong = 0, different = 0, concurrent = 0, paced = 0;
  for (std::uint64_t i = 0; i < evenstep::testing::cases(10'000); ++i) {
    ProgrammedTiming timing;
    timing.seed = i;
    timing.segment = {static_cast<std::int64_t>(between(10, 200)), 1};
    timing.visualization.ns = chance(0.1) ? 0 : static_cast<std::int64_t>(between(1, 50e6));
    timing.step = Duration{static_cast<std::int64_t>(chance(0.1) ? 1 : between(1, 20e6))};
    timing.steps = {static_cast<int>(between(1, 20))};
    if (chance(0.3)) timing.steps.push_back(static_cast<int>(between(1, 20)));
    timing.order = static_cast<SegmentOrder>(random.below(draw++, 3));
    timing.paced = chance(0.5);
    timing.visualization_variation = chance(0.5) ? between(0, 1) : 0;
    timing.step_variation = between(0.001, 1);
    if (chance(0.3)) timing.visualization_law = JitterLaw::uniform;
    if (chance(0.3)) timing.step_law = JitterLaw::uniform;
    if (chance(0.3)) timing.hitch = Hitch{{500 * ms}, {static_cast<std::int64_t>(between(1, 200e6))}};
    if (chance(0.3)) timing.spikes = Spikes{between(0, 1e3), {static_cast<std::int64_t>(between(1, 1e7))}};
    if (chance(0.3)) timing.preemption = Preemption{between(0, 1e3), {3 * ms}, {40 * ms}, between(0.1, 10)};
    if (chance(0.3)) timing.regimes = Regimes{between(1, 5), between(1, 20)};
    // If drift goes up, lengths grow exponentially. If it goes down, 1 ns remains, and a paced lane would hold 10^8 of
    // those.
    if (chance(0.3)) timing.drift_per_s = between(timing.order == SegmentOrder::concurrent ? -0.1 : -3, 0.3);
    if (chance(0.3)) timing.merged_visualization = between(0, 0.5);
    if (chance(0.3)) timing.dropped_visualization = between(0, 0.5);
    if (chance(0.3))
      timing.changes = {{.at = {50 * ms}, .visualization = Duration{7 * ms}}, {.at = {60 * ms}, .steps = {4}}};
    if (timing.order == SegmentOrder::concurrent) {
      timing.visualization.ns = std::max<std::int64_t>(timing.visualization.ns, 1'000);
      timing.step->ns = std::max<std::int64_t>(timing.step->ns, 50'000);
      if (!timing.paced) timing.dropped_visualization = 0;
      timing.slowdown = between(1, 3);
      ++concurrent;
    } else {
      timing.first_step = chance(0.3) ? between(0, 1) : 0;
    }
    paced += timing.paced;
    const auto segments = play(timing, 15);
    const std::int64_t disordered = disorder(segments);
    if (disordered > 0 && wrong == 0) WARN("first disorder in combination " << i);
    wrong += disordered;
    different += digest_of(segments) != digest_of(play(timing, 15));
    if (timing.paced) {
      for (const SegmentTiming& segment : segments) wrong += segment.begin < tick_time(timing.segment, segment.index);
    }
  }
  CHECK(wrong == 0);
  CHECK(different == 0);
  CHECK(concurrent > evenstep::testing::cases(3'000));
  CHECK(paced > evenstep::testing::cases(4'500));
}

// Recorded trace hashes will depend on these instants. If these constants change, those hashes change.
TEST_CASE("the models have the instants they always had") {
  ProgrammedTiming timing = jittered();
  timing.first_step = 0.4;
  timing.spikes = Spikes{10, {4 * ms}};
  timing.preemption = Preemption{5, {3 * ms}, {40 * ms}, 1.5};
  timing.regimes = Regimes{1.6, 8};
  timing.drift_per_s = 0.0001;
  timing.dropped_visualization = 0.05;
  timing.merged_visualization = 0.1;
  CHECK(digest_of(play(timing, 10'000)) == 0x58ae0f99f7910c52ULL);
  timing.segment = {25, 1};
  timing.paced = true;
  CHECK(digest_of(play(timing, 10'000)) == 0x778a95466f623c45ULL);
  timing.first_step = 0;
  timing.order = SegmentOrder::concurrent;
  timing.slowdown = 1.25;
  CHECK(digest_of(play(timing, 10'000)) == 0x834437ea4aed427cULL);
}
