// A source: its clock, the paths of its results, and the three policies of waking up.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "cases.h"
#include "catch.h"
#include "evenstep/scheduler/random.h"
#include "evenstep/scheduler/source_timing.h"

using namespace evenstep;

namespace {

constexpr Duration kMillisecond{1'000'000};

/// 100 Hz, one step in each segment.
ProgrammedTiming hundred_hertz(Duration step) {
  ProgrammedTiming timing;
  timing.segment = {100, 1};
  timing.visualization = {};
  timing.steps = {1};
  timing.step = step;
  return timing;
}

/// The same, but the first step that begins at or after 50 ms takes `overrun`. All others take 2 ms.
std::vector<RealTime> begins_with_overrun(WakeUp wake, Duration overrun, std::size_t count) {
  ProgrammedTiming timing = hundred_hertz(kMillisecond * 2);
  timing.paced = true;
  timing.wake = wake;
  timing.changes = {{RealTime{50'000'000}, std::nullopt, overrun, {}},
                    {RealTime{51'000'000}, std::nullopt, kMillisecond * 2, {}}};
  const std::unique_ptr<StepTiming> steps = make_programmed_timing(timing);
  std::vector<RealTime> begins;
  for (SegmentTiming segment; begins.size() < count && steps->next(segment);) begins.push_back(segment.steps[0].begin);
  return begins;
}

}  // namespace

TEST_CASE("source: after one overrun the absolute grid leaves out ticks, from-last-update stays late and catch-up bursts") {
  // Overruns from just above one period to 9.9 periods, in steps of 0.1 ms. With all three policies the steps before the
  // overrun begin at 0, 10, ... 50 ms.
  for (std::int64_t tenths = 101; tenths <= 990; ++tenths) {
    const Duration overrun = Duration{100'000} * tenths;
    const RealTime ended = RealTime{50'000'000} + overrun;
    INFO("overrun of " << overrun.ns << " ns");
    const std::vector<RealTime> grid = begins_with_overrun(WakeUp::absolute_grid, overrun, 30);
    const std::vector<RealTime> last = begins_with_overrun(WakeUp::from_last_update, overrun, 30);
    const std::vector<RealTime> burst = begins_with_overrun(WakeUp::catch_up, overrun, 30);
    const std::int64_t left_out = (overrun.ns + 9'999'999) / 10'000'000 - 1;
    for (std::int64_t n = 0; n < 30; ++n) {
      const auto i = static_cast<std::size_t>(n);
      const RealTime on_time{n * 10'000'000};
      REQUIRE(grid[i] == (n <= 5 ? on_time : on_time + kMillisecond * 10 * left_out));
      REQUIRE(last[i] == (n <= 5 ? on_time : ended + kMillisecond * 10 * (n - 6)));
      REQUIRE(burst[i] == (n <= 5 ? on_time : std::max(on_time, ended + kMillisecond * 2 * (n - 6))));
    }
  }
}

TEST_CASE("source: an instant of a clock that is faster by p is t / (1 + p), floored, for every ppm from -10000 to 10000") {
  for (std::int64_t ppm = -10'000; ppm <= 10'000; ppm += 7) {
    SourceSpec source;
    source.clock_ppm = ppm;
    const std::unique_ptr<StepTiming> plain = make_programmed_timing(hundred_hertz(kMillisecond * 2));
    const std::unique_ptr<StepTiming> drifting =
        make_source_timing(make_programmed_timing(hundred_hertz(kMillisecond * 2)), source);
    SegmentTiming a, b;
    for (int k = 0; k < 500; ++k) {
      REQUIRE(plain->next(a));
      REQUIRE(drifting->next(b));
      for (const auto& [own, device] : {std::pair(a.begin, b.begin), {a.steps[0].end, b.steps[0].end}, {a.end, b.end}}) {
        // floor(x): x - 1 < floor(x) <= x, without a division.
        const __int128 scaled = static_cast<__int128>(own.ns) * 1'000'000;
        const __int128 back = static_cast<__int128>(device.ns) * (1'000'000 + ppm);
        REQUIRE(back <= scaled);
        REQUIRE(scaled < back + 1'000'000 + ppm);
      }
    }
  }
}

TEST_CASE("source: without a cause every result is there at once, and no instant changes") {
  const std::unique_ptr<StepTiming> plain = make_programmed_timing(hundred_hertz(kMillisecond * 3));
  const std::unique_ptr<StepTiming> source = make_source_timing(make_programmed_timing(hundred_hertz(kMillisecond * 3)), {});
  SegmentTiming a, b;
  for (int k = 0; k < 1000; ++k) {
    REQUIRE(plain->next(a));
    REQUIRE(source->next(b));
    REQUIRE(a.steps[0].begin == b.steps[0].begin);
    REQUIRE(a.steps[0].end == b.steps[0].end);
    REQUIRE(b.transport(b.steps[0]).delay == Duration{0});
    REQUIRE(!b.transport(b.steps[0]).lost);
  }
}

TEST_CASE("source: shares of lost and late results are those asked for, within 5 deviations of 1,000,000 draws") {
  SourceSpec source;
  source.delay = kMillisecond * 2;
  source.jitter = kMillisecond * 3;
  source.lost = 0.02;
  source.late = 0.05;
  source.late_by = kMillisecond * 20;
  const double count = static_cast<double>(testing::cases(1'000'000));
  double lost = 0, late = 0, mean_ns = 0, on_time = 0;
  for (std::uint64_t n = 0; n < testing::cases(1'000'000); ++n) {
    const Transport way = transport(source, n);
    lost += way.lost;
    if (way.lost) continue;
    REQUIRE(way.delay >= kMillisecond * 2);
    REQUIRE(way.delay <= kMillisecond * 25);
    const bool is_late = way.delay > kMillisecond * 5;
    REQUIRE((!is_late || way.delay >= kMillisecond * 22));
    late += is_late;
    if (is_late) continue;
    mean_ns += static_cast<double>(way.delay.ns);
    ++on_time;
  }
  const auto within = [](double hits, double of, double p) {
    return std::abs(hits - p * of) <= 5 * std::sqrt(p * (1 - p) * of);
  };
  CHECK(within(lost, count, 0.02));
  CHECK(within(late, count - lost, 0.05));
  // Uniform in [2, 5] ms: deviation 3 / sqrt(12) ms.
  CHECK(std::abs(mean_ns / on_time - 3.5e6) <= 5 * 3e6 / std::sqrt(12.0) / std::sqrt(on_time));
}

TEST_CASE("source: switching one cause on does not shift the draws of another, in 10,000 results") {
  SourceSpec jittery, all;
  jittery.jitter = all.jitter = kMillisecond * 3;
  all.lost = 0.3;
  all.late = 0.3;
  all.late_by = kMillisecond * 50;
  for (std::uint64_t n = 0; n < 10'000; ++n) {
    const Transport one = transport(jittery, n), other = transport(all, n);
    if (other.lost) continue;
    const Duration more = other.delay - one.delay;
    REQUIRE((more == Duration{0} || more == kMillisecond * 50));
  }
}
