// `evenstep size --fits`: whether the latency, lead and rings of a program are enough.
#include <algorithm>

#include "cases.h"
#include "evenstep/campaigns/size_fits.h"
#include "evenstep/format/reader.h"
#include "evenstep/harness/sizing.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::testing;
using Catch::Contains;

namespace {

SizeRecord with(const std::vector<SegmentTiming>& segments, const std::string& fits, SizeOptions options = {}) {
  const Result<SizeFits> has = parse_fits(fits);
  INFO(fits << (has ? "" : ": " + has.error()));
  REQUIRE(has);
  options.fits = *has;
  return size_segments(segments, "recording", options);
}

std::string latency(Duration of) { return "latency " + std::to_string(of.ns) + " ns"; }

}  // namespace

TEST_CASE("a latency, a lead and rings fit to the ns and to the entry, on 40 random timings") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    INFO("seed " << seed);
    const std::vector<SegmentTiming> segments = play(random_timing(seed), 40);
    const SizeRecord sized = size_segments(segments, "recording", {});
    const SizeStrategy& map = strategy(sized, "phase_locked");
    const Duration least = map.any_phase.latency;
    const auto fits = [&](const std::string& has) { return with(segments, has + ", map phase_locked").fit->fits(); };
    CHECK(fits(latency(least)));
    CHECK(!fits(latency(least - Duration{1})));
    // 3 ms more of lead need 3 ms more of latency; too little lead is missed by so much, and the latency stays.
    const std::string lead = ", lead " + std::to_string((map.lead + Duration{3 * ms}).ns) + " ns";
    CHECK(fits(latency(least + Duration{3 * ms}) + lead));
    CHECK(!fits(latency(least + Duration{3 * ms - 1}) + lead));
    const std::string less = ", lead " + std::to_string(map.lead.ns - 1) + " ns";
    CHECK(!fits(latency(least) + less));
    CHECK(with(segments, latency(least) + less + ", map phase_locked").fit->needed_latency == least);
    // Rings, as a run with such a latency and lead has them.
    const SizeFit needs = *with(segments, latency(least) + ", rings 1000 1000, map phase_locked").fit;
    CHECK(needs.needed_samples == map.interaction_capacity);
    CHECK(needs.needed_forces == map.force_capacity);
    const auto rings = [](std::int64_t samples, std::int64_t forces) {
      return "rings " + std::to_string(samples) + " " + std::to_string(forces);
    };
    if (std::min(needs.needed_samples, needs.needed_forces) <= 3) continue;
    CHECK(fits(rings(needs.needed_samples, needs.needed_forces)));
    CHECK(!fits(rings(needs.needed_samples - 1, needs.needed_forces)));
    CHECK(!fits(rings(needs.needed_samples, needs.needed_forces - 1)));
    // More latency keeps forces waiting, and more lead looks further back.
    const SizeFit longer = *with(segments, latency(least + Duration{500 * ms}) + ", rings 1000 1000, map phase_locked").fit;
    CHECK(longer.needed_forces > needs.needed_forces);
    CHECK(longer.needed_samples == needs.needed_samples);
  }
}

TEST_CASE("the rings that must fit are those that a scenario with this latency and lead has") {
  const std::string file = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/recorded/h100-contended.toml";
  const ReadResult scenario = read_scenario(
      file, {{"remap.latency=\"80 ms\"", "remap.lead=\"40 ms\"", "run.strategies=[\"phase_locked\"]", "expect=[]"}});
  REQUIRE(scenario);
  SizeOptions options;
  options.fits = *parse_fits("latency 80 ms, lead 40 ms, rings 64 32, map phase_locked");
  const SizeFit fit = *size_scenario(*scenario, options).record.fit;
  const StrategyPlan run = plan(*scenario).front();
  CHECK(fit.needed_samples == static_cast<std::int64_t>(run.interaction_capacity));
  CHECK(fit.needed_forces == static_cast<std::int64_t>(run.force_capacity));
  CHECK(!fit.fits());
}

TEST_CASE("what does not fit says by how much and which hitch to mend, and a share that may be late counts") {
  std::vector<SegmentTiming> segments = play({.segment = {30, 1}, .visualization = {11'100'000}, .steps = {15}}, 200);
  for (std::size_t i = 100; i < segments.size(); ++i) {  // one drawing takes 40 ms longer
    const auto later = [&](RealTime& at) { at = at + Duration{40 * ms}; };
    if (i > 100) later(segments[i].begin), later(segments[i].visualization->begin);
    later(segments[i].end), later(segments[i].visualization->end);
    for (Interval& step : segments[i].steps) later(step.begin), later(step.end);
  }
  const SizeRecord record = with(segments, "latency 20 ms, map phase_locked");
  CHECK(!record.fit->fits());
  const std::string needed = std::to_string(record.fit->needed_latency.ns / ms);
  CHECK_THAT(lacking(record), Contains("phase_locked needs " + needed) &&
                                  Contains("All of that is the visualization of 51.1 ms, once, at 3.333 s."));
  CHECK_THAT(size_text(record), Contains("DOES NOT FIT"));
  CHECK_THAT(size_json(record), Contains("\"fits\":false"));
  const SizeRecord some = with(segments, "latency 20 ms, map phase_locked", {.rate = 0.1});
  CHECK(some.fit->fits());
  CHECK(lacking(some).empty());
  CHECK_THAT(size_text(some), Catch::EndsWith("\nFITS\n"));
}

TEST_CASE("for a span of time it must be enough with the confidence asked for, and where nobody knows it does not fit") {
  const std::string file = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/timing/latency-adaptive-jitter.toml";
  const ReadResult scenario = read_scenario(file);
  REQUIRE(scenario);
  SizeOptions options;
  options.per = Duration{3600 * 1000 * ms};
  options.fits = *parse_fits("latency 100 ms, map phase_locked");
  const SizeRecord record = size_scenario(*scenario, options).record;
  const SizePer& per = *strategy(record, "phase_locked").per;
  REQUIRE(per.refused.empty());
  CHECK(record.fit->needed_latency == per.latency);
  CHECK(record.fit->fits());
  CHECK(per.latency > strategy(record, "phase_locked").any_phase.latency);
  const std::vector<SegmentTiming> segments = play({.segment = {30, 1}, .visualization = {11'100'000}, .steps = {15}}, 20);
  const SizeRecord nobody = with(segments, "latency 1 s, map phase_locked", {.per = options.per});
  CHECK(!nobody.fit->fits());
  CHECK_THAT(lacking(nobody), Contains("what phase_locked needs for so long cannot be known: "));
  CHECK_THAT(size_text(nobody), Contains("nobody can say") && Catch::EndsWith("DOES NOT FIT\n"));
  CHECK_THAT(size_json(nobody), Contains("\"unknown\":"));
}

TEST_CASE("what cannot be judged is refused: a map that was not sized, and a timing in which no map has slots") {
  const std::vector<SegmentTiming> segments = play({.segment = {30, 1}, .visualization = {11'100'000}, .steps = {15}}, 20);
  CHECK_THAT(with(segments, "latency 1 s, map jack_dll").fit->refused, Contains("was not sized, but paper, phase_locked"));
  CHECK(with(segments, "latency 1 s, map jack_dll", {.other_maps = true}).fit->fits());
  const SizeRecord nothing = with({segments.front()}, "latency 1 s");
  CHECK_THAT(nothing.fit->refused, Contains("record more"));
  CHECK(!nothing.fit->fits());
}

TEST_CASE("what a program has is read clause by clause, and a mistake is named") {
  const SizeFits has = *parse_fits(" rings 64  32,lead -2 ms , latency 20 ms, map clocked");
  CHECK(has.latency == Duration{20 * ms});
  CHECK(has.lead == Duration{-2 * ms});
  CHECK((has.rings->samples == 64 && has.rings->forces == 32));
  CHECK(has.map == "clocked");
  const SizeFits for_long = *parse_fits("per 1 h, latency 20 ms,confidence 90 %, rate 1 %");
  CHECK(for_long.per == "1 h");
  CHECK(for_long.confidence == "90 %");
  CHECK(for_long.rate == "1 %");
  for (const auto& [text, why] : std::initializer_list<std::pair<const char*, const char*>>{
           {"", "is none of"},
           {"map paper", "no latency, lead or rings"},
           {"latency 20", "\"latency 20\""},
           {"latency -1 ms", "must not be below 0 s"},
           {"latency 1 ms, latency 2 ms", "is there twice"},
           {"rings 64", "of the ring of samples and of that of forces"},
           {"rings 64 2", "3 to 1048576"},
           {"rings 64 32 16", "must follow"},
           {"rings 64 9999999999999999999999", "must follow"},
           {"map", "is none of"},
           {"latency 20 ms, per", "is none of"},
           {"per 1 h", "no latency, lead or rings"},
           {"latency 20 ms,", "is none of"}}) {
    INFO(text);
    const Result<SizeFits> wrong = parse_fits(text);
    REQUIRE(!wrong);
    CHECK_THAT(wrong.error(), Contains(why));
  }
}
