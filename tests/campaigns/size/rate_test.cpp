// The least latency for a rate of underruns, compared with every possible lead and with the count by which a run is judged.
#include <algorithm>

#include "evenstep/harness/trust.h"
#include "evenstep/harness/underrun_rate.h"
#include "src/size/rate.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::testing;
using Catch::Contains;

namespace {

std::int64_t hits(const std::vector<SegmentNeed>& needs, Duration lead, Duration latency) {
  return std::count_if(needs.begin(), needs.end(),
                       [&](const SegmentNeed& need) { return need.lead > lead || need.delay > latency - lead; });
}

/// A free-running or paced timing of four seconds on a held device.
Scenario scenario(std::uint64_t seed) {
  Scenario out;
  out.timing.programmed = random_timing(seed);
  out.run_duration = {4'000 * ms};
  out.warmup = {};
  out.strategies = {StrategyKind::paper, StrategyKind::phase_locked};
  DeviceSpec device;
  device.name = "left";
  device.phase = {static_cast<std::int64_t>(seed % 7) * 137'000};
  device.emission = Emission::hold;
  out.devices = {device};
  return out;
}

RateCount counted(const Scenario& scenario, StrategyKind kind, Duration lead, Duration latency) {
  return count_underrun_segments(scenario, {"", kind, UnderrunSide::either, 0}, lead, latency, 1);
}

}  // namespace

TEST_CASE("of up to eight segments no lead and latency is better than the least found for any number of underruns") {
  const RandomStream stream(1, "rate.test");
  std::uint64_t draw = 0;
  for (int round = 0; round < 4000; ++round) {
    std::vector<SegmentNeed> needs(1 + stream.bits(draw++) % 8);
    for (SegmentNeed& need : needs) {  // only a few values, so that many are equal
      need.lead = {static_cast<std::int64_t>(stream.bits(draw++) % 12) - 4};
      need.delay = {static_cast<std::int64_t>(stream.bits(draw++) % 12) - 4};
    }
    for (std::int64_t allowed = 0; allowed < std::ssize(needs); ++allowed) {
      const RateLatency least = least_latency_with_underruns(needs, allowed);
      REQUIRE(hits(needs, least.lead, least.latency) == least.underruns);
      REQUIRE(least.underruns <= allowed);
      for (std::int64_t lead = -6; lead <= 9; ++lead) {
        INFO("round " << round << ", allowed " << allowed << ", lead " << lead);
        REQUIRE(hits(needs, {lead}, least.latency - Duration{1}) > allowed);
      }
    }
  }
}

TEST_CASE("at the latency for a rate a run counts no more segments than allowed and more at 1 ns less whatever the lead",
          "[sweep]") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Scenario timing = scenario(seed);
    for (const double rate : {0.02, 0.3}) {
      const SizeResult sized = size_scenario(timing, {.rate = rate});
      REQUIRE(sized.errors.empty());
      for (std::size_t i = 0; i < 2; ++i) {
        const StrategyKind kind = timing.strategies[i];
        REQUIRE(sized.record.strategies[i].rate);
        const SizeRate& found = *sized.record.strategies[i].rate;
        const SizeRateNeed& here = found.this_phase;
        INFO("seed " << seed << ", " << sized.record.strategies[i].name << " at " << rate);
        const RateCount count = counted(timing, kind, here.lead, here.latency);
        REQUIRE(count.segments == found.segments);
        REQUIRE(count.hit == here.underruns);
        REQUIRE(count.hit <= found.allowed);
        REQUIRE(static_cast<double>(found.allowed) <= rate * static_cast<double>(found.segments) + 1e-9);
        REQUIRE(here.latency <= sized.record.strategies[i].latency_this_phase);
        for (std::int64_t step = -12; step <= 12; ++step) {
          const Duration lead = here.lead + Duration{step * 499'979};
          REQUIRE(counted(timing, kind, lead, here.latency - Duration{1}).hit > found.allowed);
        }
      }
    }
  }
}

TEST_CASE("the latency for a rate at any phase holds at every phase of the device") {
  for (std::uint64_t seed = 100; seed < 115; ++seed) {
    Scenario timing = scenario(seed);
    const SizeResult sized = size_scenario(timing, {.rate = 0.1});
    for (std::size_t i = 0; i < 2; ++i) {
      const SizeRate& found = *sized.record.strategies[i].rate;
      REQUIRE(found.this_phase.latency <= found.any_phase.latency);
      for (std::int64_t phase = 0; phase < 1'000'000; phase += 90'001) {
        timing.devices[0].phase = {phase};
        REQUIRE(counted(timing, timing.strategies[i], found.any_phase.lead, found.any_phase.latency).hit <= found.allowed);
      }
    }
  }
}

TEST_CASE("a recording is sure of a rate only with as many segments as that takes and says so") {
  const ProgrammedTiming timing{.visualization_variation = 0.1, .step_variation = 0.1, .seed = 5};
  SizeOptions options{.rate = 0.05, .confidence = 0.95};
  const SizeRecord enough = size_segments(play(timing, 601), "", options);  // the first acquires
  CHECK(enough.clean_segments == 93);                                       // 0.95^93 + 93 * 0.05 * 0.95^92 = 4.996 %
  const SizeStrategy& use = strategy(enough, "phase_locked");
  REQUIRE(use.rate);
  const SizeRate& rate = *use.rate;
  CHECK(rate.segments == 600);
  CHECK(rate.allowed == 30);
  CHECK(rate.any_phase.rate_at_most == chosen_rate_at_most(rate.any_phase.underruns, 600, use.trust.alike, 0.95));
  CHECK(rate.any_phase.latency < use.any_phase.latency);
  REQUIRE(use.trust.one_process());
  REQUIRE(rate.sure);
  CHECK(rate.sure->underruns < rate.any_phase.underruns);
  CHECK(rate.sure->latency > rate.any_phase.latency);
  CHECK(*rate.sure->rate_at_most <= 0.05);
  CHECK(chosen_rate_at_most(rate.sure->underruns + 1, 600, use.trust.alike, 0.95) > 0.05);
  CHECK_THAT(size_text(enough), Contains("95 % sure") && !Contains("nothing:"));
  const SizeRecord few = size_segments(play(timing, 75), "", options);
  CHECK_FALSE(strategy(few, "phase_locked").rate->sure);
  CHECK_THAT(size_text(few), Contains("95 % sure   nothing: too short, 74 segments say as much as"));
  CHECK_THAT(size_json(few), Contains("\"clean_segments_needed\":93") && Contains("\"sure\":null"));
  CHECK_FALSE(size_segments(play(timing, 75), "", {}).strategies[0].rate);
}
