// Hitches that were put into a schedule are found as kinds, each with its count and lengths. Mending a kind gives the
// schedule without it.
#include "src/size/hitches.h"
#include "cases.h"

#include <algorithm>
#include <array>

#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::testing;

namespace {

using What = SizeHitches::What;

/// A hitch that is put in: in this segment the visualization, the third step, or the gap before the third step is longer by
/// `excess`.
struct Put {
  std::size_t segment = 0;
  What what = What::visualization;
  Duration excess;
};

/// 10 ms of visualization and 10 steps of 2 ms, back to back, with jitter that depends on the seed. With `grid`, a segment
/// begins every 40 ms or, if that is later, when the one before is over. Without it, segments follow each other at once.
std::vector<SegmentTiming> schedule(std::size_t count, const std::vector<Put>& puts, std::uint64_t jitter_seed, bool grid) {
  const RandomStream jitter(jitter_seed, "hitches.test");
  const auto varied = [&](std::uint64_t draw, std::int64_t ns) {
    return Duration{ns + (jitter_seed == 0 ? 0 : static_cast<std::int64_t>(jitter.below(draw, 100'000)) - 50'000)};
  };
  std::vector<SegmentTiming> out;
  RealTime at;
  std::uint64_t draw = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto excess = [&](What what) {
      Duration sum;
      for (const Put& put : puts) sum = sum + (put.segment == k && put.what == what ? put.excess : Duration{});
      return sum;
    };
    if (grid) at = std::max(at, RealTime{static_cast<std::int64_t>(k) * 40 * ms});
    SegmentTiming segment;
    segment.index = static_cast<std::int64_t>(k);
    segment.begin = at;
    segment.visualization = Interval{at, at + varied(draw++, 10 * ms) + excess(What::visualization)};
    at = segment.visualization->end;
    for (int i = 0; i < 10; ++i) {
      if (i == 3) at = at + excess(What::gap);
      const RealTime begin = at;
      at = at + varied(draw++, 2 * ms) + (i == 3 ? excess(What::step) : Duration{});
      segment.steps.push_back({begin, at});
    }
    segment.end = at;
    out.push_back(segment);
  }
  return out;
}

bool same(const std::vector<SegmentTiming>& a, const std::vector<SegmentTiming>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (a[k].begin != b[k].begin || a[k].visualization->end != b[k].visualization->end) return false;
    for (std::size_t i = 0; i < a[k].steps.size(); ++i) {
      if (a[k].steps[i].begin != b[k].steps[i].begin || a[k].steps[i].end != b[k].steps[i].end) return false;
    }
  }
  return a.size() == b.size();
}

/// Several kinds of hitches, 1 to 10 of each, in separate segments. Each kind is at least twice as long as the next one.
struct Programmed {
  std::vector<std::vector<Put>> kinds;
  std::vector<Put> without(std::size_t kind) const {
    std::vector<Put> out;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (i != kind) out.insert(out.end(), kinds[i].begin(), kinds[i].end());
    }
    return out;
  }
};
Programmed programmed(const RandomStream& random, std::uint64_t& draw, std::size_t segments) {
  Programmed out;
  std::vector<std::size_t> places;
  for (std::size_t k = 1; k < segments; k += 6) places.push_back(k);
  Duration excess{60 * ms};
  const std::uint64_t kinds = 1 + random.below(draw++, 4);
  for (std::uint64_t i = 0; i < kinds; ++i) {
    const What what = std::array{What::visualization, What::step, What::gap}[random.below(draw++, 3)];
    out.kinds.emplace_back();
    for (std::uint64_t n = 1 + random.below(draw++, 10); n > 0 && !places.empty(); --n) {
      const std::size_t at = random.below(draw++, places.size());
      out.kinds.back().push_back({places[at], what, excess});
      places.erase(places.begin() + static_cast<std::ptrdiff_t>(at));
    }
    excess = {excess.ns / 2 - static_cast<std::int64_t>(random.below(draw++, 1'000'000))};
  }
  return out;
}

}  // namespace

TEST_CASE("hitches that were put in come back kind by kind and mended is the schedule without them, 1,000 schedules") {
  const RandomStream random(1, "hitches.put");
  std::uint64_t draw = 0;
  std::int64_t wrong = 0;
  for (std::uint64_t i = 0; i < evenstep::testing::cases(1'000); ++i) {
    const Programmed put = programmed(random, draw, 480);
    const auto segments = schedule(480, put.without(99), 0, i % 2 == 0);
    const Hitches found(segments);
    INFO("schedule " << i);
    REQUIRE(found.kinds().size() == put.kinds.size());
    for (std::size_t kind = 0; kind < put.kinds.size(); ++kind) {
      const HitchKind& seen = found.kinds()[kind];
      wrong += seen.size() != put.kinds[kind].size();
      for (const SeenHitch& hitch : seen)
        wrong += hitch.what != put.kinds[kind].front().what || hitch.excess != put.kinds[kind].front().excess;
      // Only without a grid, where nothing waits. With one, a segment that is late for two kinds would be caught up in part.
      if (i % 2 != 0) wrong += !same(found.mended(kind, 1), schedule(480, put.without(kind), 0, false));
    }
    wrong += !same(found.mended(0, put.kinds.size()), schedule(480, {}, 0, i % 2 == 0));
  }
  CHECK(wrong == 0);
}

TEST_CASE("with jitter of 2.5 % the same hitches come back, and a schedule without any has none, 500 schedules") {
  const RandomStream random(2, "hitches.put");
  std::uint64_t draw = 0;
  std::int64_t wrong = 0, invented = 0;
  for (std::uint64_t i = 1; i <= evenstep::testing::cases(500); ++i) {
    const Programmed put = programmed(random, draw, 480);
    const auto segments = schedule(480, put.without(99), i, i % 2 == 0);
    const Hitches found(segments);
    wrong += found.kinds().size() != put.kinds.size();
    for (std::size_t kind = 0; kind < std::min(found.kinds().size(), put.kinds.size()); ++kind)
      wrong += found.kinds()[kind].size() != put.kinds[kind].size();
    invented += !Hitches(schedule(480, {}, i, i % 2 == 0)).kinds().empty();
  }
  CHECK(wrong == 0);
  CHECK(invented == 0);
}

TEST_CASE("three segments have a usual one, so a hitch among them is found, and two have none") {
  const std::vector<Put> puts{{1, What::step, {9 * ms}}};
  CHECK(Hitches(schedule(3, puts, 0, false)).kinds().size() == 1);
  CHECK(Hitches(schedule(2, puts, 0, false)).kinds().empty());
}

TEST_CASE("a step counts as a hitch from six of its robust deviations on") {
  // Steps of 1.7, 2 and 2.3 ms: the median deviation is 0.3 ms, so six robust deviations are 2.67 ms.
  const auto found = [](Duration excess) {
    std::vector<SegmentTiming> segments(240);
    RealTime at;
    for (std::int64_t k = 0; k < std::ssize(segments); ++k) {
      SegmentTiming& segment = segments[static_cast<std::size_t>(k)];
      segment.index = k;
      segment.begin = at;
      segment.visualization = Interval{at, at + Duration{10 * ms}};
      at = segment.visualization->end;
      for (std::int64_t i = 0; i < 10; ++i) {
        const Duration length{2 * ms + ((k * 10 + i) % 3 - 1) * 300'000};
        segment.steps.push_back({at, at + length + (k == 120 && i == 5 ? excess : Duration{})});
        at = segment.steps.back().end;
      }
      segment.end = at;
    }
    return Hitches(segments).kinds().size();
  };
  CHECK(found({2 * ms}) == 0);
  CHECK(found({4 * ms}) == 1);
}

TEST_CASE("hitches that get shorter little by little are one kind down to a quarter of the longest, and then another") {
  std::vector<Put> puts;
  for (const std::int64_t excess_ms : {40, 29, 21, 15, 11, 8})
    puts.push_back({100 + 20 * puts.size(), What::step, {excess_ms * ms}});
  const Hitches found(schedule(480, puts, 0, false));
  REQUIRE(found.kinds().size() == 2);
  CHECK(found.kinds()[0].size() == 5);
  CHECK(found.kinds()[1].size() == 1);
}

TEST_CASE("ten equal hitches hide each other one by one, but not as a kind") {
  std::vector<Put> puts;
  for (std::size_t i = 1; i <= 10; ++i) puts.push_back({20 * i, What::visualization, {20 * ms}});
  const SizeOptions options;
  const SizeRecord with = size_segments(schedule(240, puts, 0, true), "put", options);
  const SizeRecord without = size_segments(schedule(240, {}, 0, true), "none", options);
  const SizeStrategy &late = strategy(with, "phase_locked"), &usual = strategy(without, "phase_locked");
  CHECK(late.any_phase.latency.ns > usual.any_phase.latency.ns + 15 * ms);
  CHECK((late.any_phase.latency - late.any_phase.culprit.mended_latency).ns < 100'000);
  REQUIRE(with.hitches.size() == 1);
  const SizeHitches& kind = with.hitches.front();
  CHECK(kind.what == What::visualization);
  CHECK(kind.count == 10);
  CHECK(kind.shortest.ns == 30 * ms);
  CHECK(kind.longest.ns == 30 * ms);
  CHECK(kind.usual.ns == 10 * ms);
  CHECK(kind.median_between.ns == 800 * ms);
  CHECK(kind.regular(with.segment));
  const auto map = static_cast<std::size_t>(&late - with.strategies.data());
  CHECK(kind.mended[map].latency == usual.any_phase.latency);
  CHECK(kind.mended[map].with_all_above == usual.any_phase.latency);
  CHECK(kind.mended[map].stiffness_N_per_m == Approx(usual.any_phase.stiffness_limit_N_per_m).epsilon(0.01));
  CHECK(without.hitches.empty());
}

TEST_CASE(
    "a boundary that comes late is a wait where the segment before says that it is idle, and a gap where nobody says") {
  for (const bool recorded : {true, false}) {
    std::vector<SegmentTiming> segments = schedule(240, {}, 0, false);
    const Duration late{30 * ms};
    if (recorded) segments[99].end = segments[99].end + late;
    for (std::size_t k = 100; k < segments.size(); ++k) {
      SegmentTiming& segment = segments[k];
      segment.begin = segment.begin + late;
      segment.end = segment.end + late;
      segment.visualization = Interval{segment.visualization->begin + late, segment.visualization->end + late};
      for (Interval& step : segment.steps) step = {step.begin + late, step.end + late};
    }
    const SizeRecord record = size_segments(segments, "late", {});
    REQUIRE(record.hitches.size() == 1);
    CHECK(record.hitches.front().what == (recorded ? What::waiting : What::gap));
    CHECK(record.hitches.front().longest == late);
    CHECK_THAT(size_text(record), Catch::Contains(recorded ? "All of that is the wait of 30 ms" : "the gap of 30 ms"));
    CHECK(record.pause.waiting.ns == (recorded ? late.ns : 0));
    CHECK(record.pause.drawing.ns == 10 * ms);
    CHECK(record.pause.unrecorded.ns == (recorded ? 0 : late.ns));
  }
}

TEST_CASE("where visualizations have a thread of their own only steps and the gaps between them are hitches") {
  ProgrammedTiming timing{.visualization = {30 * ms}, .step = Duration{2 * ms}, .order = SegmentOrder::concurrent};
  auto segments = play(timing, 100);
  const auto usual = segments;
  const auto delay_after = [&](RealTime at, Duration by) {
    for (SegmentTiming& segment : segments) {
      for (Interval& step : segment.steps) {
        if (step.begin > at) step = {step.begin + by, step.end + by};
      }
    }
  };
  for (const std::size_t k : {20U, 50U, 80U}) {  // a step of 12 ms instead of 2
    Interval& step = segments[k].steps[4];
    delay_after(step.begin, {10 * ms});
    step.end = step.end + Duration{10 * ms};
  }
  const Hitches found(segments);
  REQUIRE(found.kinds().size() == 1);
  CHECK(found.kinds()[0].size() == 3);
  CHECK(found.kinds()[0].front().what == What::step);
  const auto mended = found.mended(0, 1);
  std::vector<RealTime> a, b;
  for (const SegmentTiming& segment : mended) {
    for (const Interval& step : segment.steps) a.push_back(step.begin);
  }
  for (const SegmentTiming& segment : usual) {
    for (const Interval& step : segment.steps) b.push_back(step.begin);
  }
  CHECK(a == b);
}

TEST_CASE("two segments have no usual one, and no hitches") {
  CHECK(Hitches(schedule(2, {{1, What::visualization, {60 * ms}}}, 0, false)).kinds().empty());
  CHECK(Hitches({}).kinds().empty());
}
