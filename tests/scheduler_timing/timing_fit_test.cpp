// A fit finds the model of a known schedule again, part by part, and finds nothing that is not in it.
#include "evenstep/scheduler/timing_fit.h"

#include <cmath>

#include "cases.h"
#include "catch.h"
#include "evenstep/scheduler/random.h"
#include "fit_statistics.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

constexpr int kFittedSegments = 2'000;

/// Free running: V 11.1 ms +- 5 %, 15 steps of 1.4 ms +- 1 %.
ProgrammedTiming base(std::uint64_t seed = 1) {
  return {.step = Duration{1'400'000}, .visualization_variation = 0.05, .step_variation = 0.01, .seed = seed};
}

TimingFit fitted(const ProgrammedTiming& timing, int segments = kFittedSegments) {
  return fit_timing(play(timing, segments));
}

/// The names of the parts that are proposed.
std::string parts(const TimingFit& fit) {
  const ProgrammedTiming& timing = fit.timing;
  std::string out;
  const auto add = [&out](bool is_there, const char* name) { out += is_there ? std::string(name) + " " : ""; };
  add(timing.order == SegmentOrder::steps_first, "steps-first");
  add(timing.order == SegmentOrder::concurrent, "concurrent");
  add(timing.paced, "paced");
  add(timing.first_step > 0, "first_step");
  add(timing.slowdown > 1, "slowdown");
  add(timing.spikes.has_value(), "spikes");
  add(timing.preemption.has_value(), "preemption");
  add(timing.regimes.has_value(), "regimes");
  add(timing.hitch.has_value(), "hitch");
  add(timing.drift_per_s != 0, "drift");
  add(timing.dropped_visualization > 0, "dropped");
  add(timing.merged_visualization > 0, "merged");
  return out;
}

double V(const TimingFit& fit) { return static_cast<double>(fit.timing.visualization.ns); }
double s(const TimingFit& fit) { return static_cast<double>(fit.timing.step->ns); }

/// The mean V of these segments. The stays at a level are so few that it is a few percent off the programmed V.
double mean_visualization_ns(const std::vector<SegmentTiming>& segments) {
  double sum = 0;
  for (const SegmentTiming& segment : segments) sum += static_cast<double>(length(*segment.visualization).ns);
  return sum / static_cast<double>(segments.size());
}

/// Checks a rate from counted hits to 5 standard errors of a Poisson count.
void check_rate(double measured, double rate, double seconds) {
  INFO(measured << " Hz for " << rate << " Hz in " << seconds << " s");
  CHECK(std::abs(measured - rate) < 5 * std::sqrt(rate / seconds) + 0.01 * rate);
}

}  // namespace

TEST_CASE("fit: means and variations come back, and nothing that is not there is proposed, for 20 seeds", "[sweep]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    const TimingFit fit = fitted(base(seed));
    CHECK(parts(fit) == "");
    // 5 standard errors of 2000 and 30 000 lengths. Lengths beyond 5 deviations do not occur.
    CHECK(V(fit) == Approx(11.1e6).epsilon(5 * 0.05 / std::sqrt(2'000)));
    CHECK(s(fit) == Approx(1.4e6).epsilon(5 * 0.01 / std::sqrt(30'000)));
    // A median absolute deviation has 1.65 times the error of a standard deviation, 1 / sqrt(2 n).
    CHECK(fit.timing.visualization_variation == Approx(0.05).epsilon(5 * 1.65 / std::sqrt(4'000)));
    CHECK(fit.timing.step_variation == Approx(0.01).epsilon(5 * 1.65 / std::sqrt(60'000)));
    CHECK(fit.timing.steps == std::vector<int>{15});
    // The lengths are log-normal: P(sqrt(n) D > 1.8) < 3e-3 for known parameters, and less for fitted ones.
    CHECK(fit.visualization.distance < 1.8 / std::sqrt(2'000));
    CHECK(fit.step.distance < 1.8 / std::sqrt(30'000));
  }
}

TEST_CASE("fit: a schedule that does not vary at all comes back to the nanosecond") {
  const TimingFit fit = fitted({.segment = {30, 1}, .visualization = {11 * ms}, .step = Duration{1 * ms}}, 100);
  CHECK(parts(fit) == "paced ");
  CHECK(fit.timing.segment == Rate{30, 1});
  CHECK(fit.timing.visualization.ns == 11 * ms);
  CHECK(fit.timing.step->ns == 1 * ms);
  CHECK(fit.timing.visualization_variation < 1e-6);
  CHECK(fit.timing.step_variation < 1e-6);
}

TEST_CASE("fit: the list of step counts is as short as its shares allow") {
  ProgrammedTiming timing = base();
  timing.steps = {14, 15, 16};
  CHECK(fitted(timing).timing.steps == std::vector<int>{14, 15, 16});
  timing.steps = {10, 20, 20, 20};
  CHECK(fitted(timing).timing.steps == std::vector<int>{10, 20, 20, 20});
}

TEST_CASE("fit: the order is seen, and the first step after a visualization in each") {
  for (const auto order : {SegmentOrder::visualization_first, SegmentOrder::steps_first}) {
    ProgrammedTiming timing = base();
    timing.order = order;
    timing.first_step = 0.2;
    const TimingFit fit = fitted(timing);
    CHECK(parts(fit) == (order == SegmentOrder::steps_first ? "steps-first first_step " : "first_step "));
    // The standard error of a ratio of medians at 1 % is 1.25 * 1 % / sqrt(2000).
    CHECK(fit.timing.first_step == Approx(0.2).margin(5 * 1.2 * 0.0125 / std::sqrt(2'000)));
    CHECK(s(fit) == Approx(1.4e6).epsilon(0.001));
  }
}

TEST_CASE("fit: spikes come back with their rate and cost, and leave the step what it was") {
  for (const double rate : {2.0, 20.0}) {
    ProgrammedTiming timing = base();
    timing.spikes = Spikes{rate, {4 * ms}};
    const TimingFit fit = fitted(timing);
    REQUIRE(parts(fit) == "spikes ");
    check_rate(fit.timing.spikes->rate_Hz, rate, fit.work_s);
    CHECK(static_cast<double>(fit.timing.spikes->cost.ns) == Approx(4e6).epsilon(0.005));  // 1 % of a step of 1.4 ms
    CHECK(s(fit) == Approx(1.4e6).epsilon(0.001));
  }
}

TEST_CASE("fit: a tail comes back with rate, bounds and index, visualizations lose what it added to them") {
  ProgrammedTiming timing = base();
  timing.preemption = Preemption{20, {3 * ms}, {40 * ms}, 1.5};
  const TimingFit fit = fitted(timing);
  REQUIRE(parts(fit) == "preemption ");
  const Preemption tail = *fit.timing.preemption;
  check_rate(tail.rate_Hz, 20, fit.work_s);
  const double hits = static_cast<double>(fit.excess_ns.size());
  CHECK(static_cast<double>(tail.least.ns) == Approx(3e6).epsilon(0.03));
  CHECK(tail.most.ns > 25 * ms);
  CHECK(tail.most.ns <= 40 * ms + ms / 10);
  // The standard error of a maximum-likelihood index is 1.5 / sqrt(hits) without a bound, and about half as much more with a
  // bound at 13 times the least value.
  CHECK(tail.tail == Approx(1.5).margin(5 * 1.5 * 1.5 / std::sqrt(hits)));
  CHECK(fit.tail_distance < 1.8 / std::sqrt(hits));
  // Hits of 3 ms are beyond 5 deviations of V, so the mean of the others does not contain them.
  CHECK(V(fit) == Approx(11.1e6).epsilon(0.01));
}

TEST_CASE("fit: a tail of short hits is inside the mean of V and is taken off, for the model adds it again") {
  ProgrammedTiming timing = base();
  timing.preemption = Preemption{100, {300'000}, {1'500'000}, 0.1};
  const TimingFit fit = fitted(timing);
  REQUIRE(parts(fit) == "preemption ");
  // 1 - exp(-100 Hz * 11.1 ms) = 67 % of the visualizations are hit, by 0.72 ms. If these hits were left in, V would be 4.3
  // % too long.
  CHECK(V(fit) == Approx(11.1e6).epsilon(0.008));
}

TEST_CASE("fit: what a spike costs is not scaled by what makes its step longer") {
  ProgrammedTiming timing = base();
  timing.first_step = 2;
  timing.spikes = Spikes{50, {4 * ms}};
  const TimingFit fit = fitted(timing);
  REQUIRE(parts(fit) == "first_step spikes ");
  CHECK(fit.alike == static_cast<std::int64_t>(fit.excess_ns.size()));
}

TEST_CASE("fit: spikes and a tail are told apart where at least half the hits are alike") {
  ProgrammedTiming timing = base();
  timing.spikes = Spikes{20, {2 * ms}};
  timing.preemption = Preemption{5, {6 * ms}, {40 * ms}, 1.5};
  const TimingFit fit = fitted(timing);
  REQUIRE(parts(fit) == "spikes preemption ");
  CHECK(V(fit) == Approx(fit.visualization.mean_ns).margin(1));  // the mean contains no hits of 6 ms
  check_rate(fit.timing.spikes->rate_Hz, 20, fit.work_s);
  check_rate(fit.timing.preemption->rate_Hz, 5, fit.work_s);
}

TEST_CASE("fit: regimes come back with factor and length, whether jitter hides them from value to value or not") {
  for (const double variation : {0.02, 0.15}) {
    for (const double mean_length : {3.0, 8.0, 40.0}) {
      INFO("variation " << variation << ", mean length " << mean_length);
      ProgrammedTiming timing = base();
      timing.visualization_variation = variation;
      timing.regimes = Regimes{1.6, mean_length};
      const auto segments = play(timing, 4'000);
      const TimingFit fit = fit_timing(segments);
      REQUIRE(parts(fit) == "regimes ");
      CHECK(fit.timing.regimes->factor == Approx(1.6).epsilon(0.03));
      // There are 4000 / mean_length changes. 5 standard errors are allowed, and as much again for changes that jitter
      // hides.
      CHECK(fit.timing.regimes->mean_length == Approx(mean_length).epsilon(10 / std::sqrt(4'000 / mean_length)));
      CHECK(V(fit) == Approx(mean_visualization_ns(segments)).epsilon(0.01));
      CHECK(fit.timing.visualization_variation == Approx(variation).epsilon(0.1));
    }
  }
}

TEST_CASE("fit: regimes that are not half and half come back with their shares, and V with its mean") {
  for (const double share : {0.15, 0.3, 0.75}) {
    INFO("share " << share);
    ProgrammedTiming timing = base();
    timing.regimes = Regimes{1.7, 10, share};
    const auto segments = play(timing, 6'000);
    const TimingFit fit = fit_timing(segments);
    REQUIRE(parts(fit) == "regimes ");
    // There are about 200 stays of each kind, and their lengths vary by their whole mean. So the share has an error of 10 %;
    // three times that is allowed.
    CHECK(fit.timing.regimes->slow_share == Approx(share).epsilon(0.3));
    CHECK(fit.timing.regimes->factor == Approx(1.7).epsilon(0.03));
    CHECK(V(fit) == Approx(mean_visualization_ns(segments)).epsilon(0.01));
  }
}

TEST_CASE("fit: one level that changes its length once, or jitter however wide, is no regime") {
  ProgrammedTiming once = base();
  once.changes = {{.at = {30'000 * ms}, .visualization = Duration{20 * ms}}};
  CHECK_FALSE(fitted(once).timing.regimes);
  for (const double variation : {0.1, 0.3, 1.0}) {
    ProgrammedTiming wide = base();
    wide.visualization_variation = variation;
    CHECK_FALSE(fitted(wide).timing.regimes);
  }
}

TEST_CASE("fit: a level that came once and went again is no regime, however clear it is") {
  ProgrammedTiming once = base();
  once.changes = {{.at = {20'000 * ms}, .visualization = Duration{20 * ms}},
                  {.at = {40'000 * ms}, .visualization = Duration{11'100'000}}};
  CHECK_FALSE(fitted(once).timing.regimes);
}

TEST_CASE("fit: two levels that are closer than two deviations of what each varies by are one, for 20 seeds") {
  for (std::uint64_t seed = 1; seed <= evenstep::testing::cases(20); ++seed) {
    ProgrammedTiming close = base(seed);
    close.visualization_variation = 0.1;
    close.regimes = Regimes{1.17, 40, 0.5};
    INFO("seed " << seed);
    CHECK_FALSE(fitted(close).timing.regimes);
  }
}

TEST_CASE("fit: chance makes few regimes in short recordings: at most one of 500, of 4,000 of 40 to 100 segments") {
  std::uint64_t invented = 0;
  const std::uint64_t count = evenstep::testing::cases(4'000);
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    ProgrammedTiming timing = base(seed);
    timing.visualization_law = seed % 2 == 0 ? JitterLaw::uniform : JitterLaw::log_normal;
    invented += fitted(timing, 40 + static_cast<int>(seed % 61)).timing.regimes.has_value();
  }
  INFO(invented);
  CHECK(500 * invented <= count);
}

TEST_CASE("fit: drift comes back where visualizations and steps drift alike, where only one does it is none") {
  for (const double drift : {0.01, -0.004}) {
    ProgrammedTiming timing = base();
    timing.drift_per_s = drift;
    const TimingFit fit = fitted(timing);
    REQUIRE(parts(fit) == "drift ");
    CHECK(fit.timing.drift_per_s == Approx(drift).epsilon(0.03));
    CHECK(V(fit) == Approx(11.1e6).epsilon(0.01));
    CHECK(fit.timing.step_variation == Approx(0.01).epsilon(0.15));
  }
  ProgrammedTiming one_only = base();
  one_only.changes.clear();
  for (int i = 1; i <= 60; ++i)
    one_only.changes.push_back({.at = {i * 1'000 * ms}, .visualization = Duration{11'100'000 + i * 100'000}});
  const TimingFit fit = fitted(one_only);
  CHECK(fit.timing.drift_per_s == 0);
  CHECK(fit.visualization_drift_per_s.value > 4 * fit.visualization_drift_per_s.error);
}

TEST_CASE("fit: pacing is seen with its rate, deadlines missed or not, a free-running schedule is not paced") {
  ProgrammedTiming timing = base();
  timing.step = Duration{1 * ms};
  timing.paced = true;
  TimingFit fit = fitted(timing);
  CHECK(parts(fit) == "paced ");
  CHECK(fit.timing.segment == Rate{30, 1});
  CHECK(fit.late == 0);
  CHECK(fit.idle_share == Approx(1 - 26.1 / (1e3 / 30)).margin(0.002));
  timing.preemption = Preemption{5, {3 * ms}, {40 * ms}, 1.5};
  fit = fitted(timing);
  CHECK(parts(fit) == "paced preemption ");
  CHECK(fit.late > 10);
  timing.preemption.reset();
  timing.segment = {1'000'000, 33'210};  // 33.21 ms is not a whole rate
  CHECK(fitted(timing).timing.segment == Rate{1'000'000, 33'210});
}

TEST_CASE("fit: a loop that rests as long after each segment, whatever that took, is not paced") {
  std::vector<SegmentTiming> segments = play(base(), kFittedSegments);
  Duration rested;
  for (SegmentTiming& segment : segments) {
    segment.begin = segment.begin + rested;
    segment.end = segment.end + rested;
    segment.visualization = Interval{segment.visualization->begin + rested, segment.visualization->end + rested};
    for (Interval& step : segment.steps) step = {step.begin + rested, step.end + rested};
    rested = rested + Duration{3 * ms};
  }
  CHECK(parts(fit_timing(segments)) == "");
}

TEST_CASE("fit: dropped and merged visualizations are counted") {
  ProgrammedTiming timing = base();
  timing.dropped_visualization = 0.02;
  timing.merged_visualization = 0.03;
  const TimingFit fit = fitted(timing);
  CHECK(parts(fit) == "dropped merged ");
  std::int64_t dropped = 0, merged = 0;
  const auto segments = play(timing, kFittedSegments - 1);
  for (const SegmentTiming& segment : segments) {
    dropped += !segment.visualization;
    merged += segment.visualization && length(*segment.visualization).ns > 16 * ms;
  }
  CHECK(fit.dropped == dropped);
  CHECK(fit.merged == merged);
  CHECK(V(fit) == Approx(11.1e6).epsilon(0.01));
}

TEST_CASE("fit: a visualization in a lane of its own, its pace and the slowdown of the steps beside it") {
  ProgrammedTiming timing = base();
  timing.order = SegmentOrder::concurrent;
  TimingFit fit = fitted(timing);
  CHECK(parts(fit) == "concurrent ");
  CHECK(s(fit) == Approx(1.4e6).epsilon(0.001));
  timing.paced = true;
  timing.slowdown = 1.5;
  fit = fitted(timing);
  CHECK(parts(fit) == "concurrent paced slowdown ");
  CHECK(fit.timing.slowdown == Approx(1.5).epsilon(0.005));
  CHECK(s(fit) == Approx(1.4e6).epsilon(0.001));
  CHECK(fit.timing.segment == Rate{30, 1});
}

TEST_CASE("fit: everything at once") {
  ProgrammedTiming timing = base();
  timing.step = Duration{1 * ms};
  timing.segment = {25, 1};
  timing.paced = true;
  timing.first_step = 0.3;
  timing.spikes = Spikes{10, {4 * ms}};
  timing.regimes = Regimes{1.5, 8};
  timing.dropped_visualization = 0.02;
  const TimingFit fit = fitted(timing);
  CHECK(parts(fit) == "paced first_step spikes regimes dropped ");
  CHECK(fit.timing.first_step == Approx(0.3).margin(0.01));
  CHECK(fit.timing.regimes->factor == Approx(1.5).epsilon(0.02));
  check_rate(fit.timing.spikes->rate_Hz, 10, fit.work_s);
  CHECK(V(fit) == Approx(11.1e6).epsilon(0.02));
}

TEST_CASE("fit: too little to fit is refused with what is missing, the shortest that is not goes through") {
  const auto segments = play(base(), 200);
  const auto first = [&](std::size_t count) { return std::span(segments).first(count); };
  CHECK_THAT(fit_objection(first(31)), Catch::Contains("holds 31 segments; a fit needs at least 32"));
  CHECK(fit_objection(first(32)).empty());
  CHECK(fit_timing(first(32)).segments == 31);
  std::vector<SegmentTiming> empty = segments;
  for (SegmentTiming& segment : empty) segment.steps.clear();
  CHECK_THAT(fit_objection(empty), Catch::Contains("has a step in fewer than one segment of ten"));
  CHECK_FALSE(fit_objection({}).empty());
}

TEST_CASE("fit: schedules without a visualization, with steps of 1 ns or a single length go through") {
  for (const ProgrammedTiming& timing :
       {ProgrammedTiming{.visualization = {0}, .step = Duration{1 * ms}, .step_variation = 0.1},
        ProgrammedTiming{.steps = {1}, .step = Duration{1}, .visualization_variation = 0.1},
        ProgrammedTiming{.dropped_visualization = 0.9},
        ProgrammedTiming{.visualization_variation = 1, .step_variation = 1}}) {
    const TimingFit fit = fitted(timing, 500);
    CHECK(fit.timing.step->ns > 0);
    CHECK(std::isfinite(fit.timing.visualization_variation));
    play(fit.timing, 100);
  }
}

TEST_CASE("statistics of the fit against closed forms") {
  using namespace evenstep::internal;
  const Sample five{5, 1, 4, 2, 3};
  CHECK(median(five) == 3);
  CHECK(quantile(five, 0.2) == 1);
  CHECK(quantile(five, 0.21) == 2);
  CHECK(quantile(five, 1) == 5);
  CHECK(robust_deviation(five) == Approx(1.4826));
  CHECK(lag_correlation({1, -1, 1, -1, 1, -1}, 1) == Approx(-5.0 / 6));
  CHECK(kolmogorov_distance({0.25, 0.75}, [](double x) { return x; }) == Approx(0.25));
  CHECK(densest({1, 2, 4, 4.1, 4.2, 9}).center == Approx(4.1));
  CHECK(densest({1, 2, 4, 4.1, 4.2, 9}).count == 3);
  for (const double tail : {0.3, 1.5, 5.0}) {
    // The quantiles of a Pareto distribution that is cut off at three times its least value. If the cut were ignored, its
    // index would seem far larger.
    Sample cut;
    const double q = std::pow(1.0 / 3, tail);
    for (int i = 0; i < 10'000; ++i) cut.push_back(2 * std::pow(1 - (i + 0.5) / 10'000 * (1 - q), -1 / tail));
    CHECK(fit_tail(cut, 2, 6) == Approx(tail).epsilon(0.01));
  }
  Sample t, y;
  for (int i = 0; i < 400; ++i) {
    t.push_back(i);
    y.push_back(2 * (1 + 0.01 * i));
  }
  CHECK(relative_slope(t, y).value == Approx(0.01).epsilon(1e-2));
  CHECK(relative_slope(t, Sample(400, 3.0)).value == Approx(0).margin(1e-12));
}

TEST_CASE("fit: a hitch comes back with its period, and the rest is as without it, 100 schedules") {
  const RandomStream random(1, "fit.hitch");
  std::uint64_t draw = 0;
  for (std::uint64_t seed = 1; seed <= evenstep::testing::cases(100); ++seed) {
    ProgrammedTiming timing = base(seed);
    timing.paced = seed % 2 == 0;
    if (timing.paced) timing.step = Duration{1'200'000};  // leaves idle time, so that the fit can see the pacing
    const auto period_ms = static_cast<std::int64_t>(1'000 + 100 * random.below(draw++, 45));
    const auto length_ms = static_cast<std::int64_t>(20 + random.below(draw++, 30));
    timing.hitch = Hitch{{period_ms * ms}, {length_ms * ms}};
    const TimingFit fit = fitted(timing);  // takes 66 s or more, so there are at least 12 hitches
    INFO("seed " << seed << ": " << length_ms << " ms every " << period_ms << " ms");
    CHECK(parts(fit) == (timing.paced ? "paced hitch " : "hitch "));
    REQUIRE(fit.timing.hitch);
    CHECK(fit.timing.hitch->every.ns == period_ms * ms);
    // The median of 12 or more lengths that vary by 5 % has an error of 1.25 * 5 % / sqrt(12). 5 errors are allowed.
    CHECK(static_cast<double>(fit.timing.hitch->visualization.ns) ==
          Approx(static_cast<double>(length_ms * ms)).epsilon(5 * 1.25 * 0.05 / std::sqrt(12)));
    CHECK(V(fit) == Approx(11.1e6).epsilon(5 * 0.05 / std::sqrt(1'900)));
  }
}

TEST_CASE("fit: four long visualizations at equal intervals are a hitch, three may be chance") {
  for (const int hitches : {3, 4, 6}) {
    ProgrammedTiming timing = base();
    timing.hitch = Hitch{{2'000 * ms}, {40 * ms}};
    const TimingFit fit = fitted(timing, (hitches * 2'000 + 1'000) / 32);
    INFO(hitches);
    CHECK(fit.timing.hitch.has_value() == (hitches >= 4));
    if (hitches >= 4) CHECK(fit.hitches == hitches);
  }
}

TEST_CASE("fit: merged visualizations and other chance events are no hitches, 1,000 schedules", "[sweep]") {
  std::int64_t invented = 0;
  for (std::uint64_t seed = 1; seed <= evenstep::testing::cases(1'000); ++seed) {
    ProgrammedTiming timing = base(seed);
    timing.merged_visualization = 0.005 * static_cast<double>(1 + seed % 8);
    if (seed % 3 == 0) timing.preemption = Preemption{1, {8 * ms}, {40 * ms}};
    if (seed % 5 == 0) timing.regimes = Regimes{1.6, 8, 0.2};
    invented += fitted(timing, 300).timing.hitch.has_value();
  }
  CHECK(invented <= 1);  // by chance in one of a thousand, see docs/timings/timing.md
}

TEST_CASE("fit: uniform jitter comes back as such, and log-normal jitter does not, 200 schedules of each") {
  std::int64_t missed = 0, invented = 0, other = 0;
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= evenstep::testing::cases(200); ++seed) {
    const double width = 0.02 * static_cast<double>(1 + seed % 20);
    ProgrammedTiming timing = base(seed);
    invented += fitted(timing, 500).visualization.is_uniform() + fitted(timing, 500).step.is_uniform();
    timing.visualization_variation = timing.step_variation = width;
    timing.visualization_law = timing.step_law = JitterLaw::uniform;
    const TimingFit fit = fitted(timing, 500);
    missed += fit.timing.visualization_law != JitterLaw::uniform;
    missed += fit.timing.step_law != JitterLaw::uniform;
    other += parts(fit) != "";
    if (fit.timing.visualization_law == JitterLaw::uniform)
      worst = std::max(worst, std::abs(fit.timing.visualization_variation / width - 1));
  }
  CHECK(missed <= 4);  // 1 % of 400
  CHECK(invented == 0);
  CHECK(other == 0);
  // A quantile at 5 % of 500 values is off by 1 % of the width (one standard error). The width comes from two quantiles.
  CHECK(worst < 0.06);
}
