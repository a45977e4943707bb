// The worst order of a recording's segments: against all orders of a short recording, and by rules that every order found
// must keep.
#include "src/schedules/worst_order.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::testing;
using Catch::Contains;

namespace {

constexpr Duration kSecond{1'000'000'000};

MapSetup setup_for(const std::vector<SegmentTiming>& segments, Emission emission = Emission::hold) {
  MapSetup setup;
  setup.grids.push_back({Rate{1000, 1}, RealTime{}});
  setup.emission = emission;
  setup.end = segments.back().end + Duration{1};
  return setup;
}

/// Segments of one drawing and three steps of 2 ms each, back to back; a drawing of 8 ms is as usual.
std::vector<SegmentTiming> drawn(const std::vector<std::int64_t>& drawings_ms) {
  std::vector<SegmentTiming> out;
  RealTime at;
  const auto take = [&](std::int64_t length_ms) {
    const Interval time{at, at + Duration{length_ms * ms}};
    at = time.end;
    return time;
  };
  for (const std::int64_t drawing_ms : drawings_ms) {
    SegmentTiming segment;
    segment.index = std::ssize(out);
    segment.begin = at;
    segment.visualization = take(drawing_ms);
    for (int i = 0; i < 3; ++i) segment.steps.push_back(take(2));
    segment.end = at;
    out.push_back(segment);
  }
  return out;
}

Duration latency_of(const MapSetup& setup, StrategyKind map, const std::vector<SegmentTiming>& segments) {
  RunningNeeds needs(setup.grids, setup.emission, RunningNeeds::Phase::any);
  each_mapped_step(setup, map, segments, [&](std::span<const MappedStep> steps) { needs.add(steps); });
  return needs.budget().latency;
}

/// What tells a segment from others of the same recording: when things happen after its begin, and how long it lasts.
std::vector<std::int64_t> shape(const std::vector<SegmentTiming>& segments, std::size_t k) {
  const SegmentTiming& one = segments[k];
  const RealTime next = k + 1 < segments.size() ? segments[k + 1].begin : one.end;
  std::vector<std::int64_t> out{(next - one.begin).ns, (one.end - one.begin).ns};
  if (one.visualization)
    out.insert(out.end(), {(one.visualization->begin - one.begin).ns, (one.visualization->end - one.begin).ns});
  for (const Interval& step : one.steps) out.insert(out.end(), {(step.begin - one.begin).ns, (step.end - one.begin).ns});
  return out;
}
std::vector<std::vector<std::int64_t>> shapes(const std::vector<SegmentTiming>& segments) {
  std::vector<std::vector<std::int64_t>> out;
  for (std::size_t k = 0; k < segments.size(); ++k) out.push_back(shape(segments, k));
  return out;
}

/// Of segments longer than 15 ms: how many begin in the worst second.
std::int64_t most_long_in_a_second(const std::vector<SegmentTiming>& segments) {
  std::int64_t most = 0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    most = std::max<std::int64_t>(most, std::count_if(segments.begin(), segments.end(), [&](const SegmentTiming& one) {
                                    return one.end - one.begin > Duration{15 * ms} && one.begin <= segments[k].begin &&
                                           one.begin > segments[k].begin - kSecond;
                                  }));
  }
  return most;
}

}  // namespace

TEST_CASE("of all orders of a short recording the search finds the worst, or one that needs nearly as much") {
  int exact = 0;
  // All of them are within a second, so the rule about hitches allows every order of the seven that may move.
  for (const std::vector<std::int64_t>& drawings :
       {std::vector<std::int64_t>{8, 8, 30, 9, 8, 20, 7, 12, 8}, {8, 25, 8, 25, 6, 25, 8, 3, 8}}) {
    const std::vector<SegmentTiming> recorded = drawn(drawings);
    for (const StrategyKind map : {StrategyKind::paper, StrategyKind::phase_locked}) {
      for (const Emission emission : {Emission::hold, Emission::linear}) {
        const MapSetup setup = setup_for(recorded, emission);
        std::vector<std::int64_t> moved(drawings.begin() + 1, drawings.end() - 1);
        std::sort(moved.begin(), moved.end());
        Duration worst;
        do {
          std::vector<std::int64_t> order{drawings.front()};
          order.insert(order.end(), moved.begin(), moved.end());
          order.push_back(drawings.back());
          worst = std::max(worst, latency_of(setup, map, drawn(order)));
        } while (std::next_permutation(moved.begin(), moved.end()));
        const FoundOrder found = OrderSearch(setup, recorded, kSecond).search(map);
        INFO(name_of(map) << ", " << (emission == Emission::hold ? "held" : "interpolated"));
        CHECK(found.row.worst_latency <= worst);
        CHECK(static_cast<double>(found.row.worst_latency.ns) > 0.97 * static_cast<double>(worst.ns));
        exact += found.row.worst_latency == worst;
        CHECK(found.row.latency == latency_of(setup, map, recorded));
        CHECK(found.row.latency < worst);
      }
    }
  }
  CHECK(exact >= 6);  // of 8
}

TEST_CASE("a worst order has the segments of the recording, needs what it says, and is the same again") {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const std::vector<SegmentTiming> recorded = play(random_timing(seed), 90);
    const MapSetup setup = setup_for(recorded);
    const OrderSearch search(setup, recorded, kSecond);
    const FoundOrder found = search.search(StrategyKind::phase_locked);
    INFO("seed " << seed);
    CHECK(found.row.worst_latency >= found.row.latency);
    CHECK(latency_of(setup, StrategyKind::phase_locked, found.segments) == found.row.worst_latency);
    auto before = shapes(recorded), after = shapes(found.segments);
    // An eighth of them stays at the start, and the last one stays the last.
    CHECK(std::equal(before.begin(), before.begin() + 11, after.begin()));
    CHECK(before.back() == after.back());
    std::sort(before.begin(), before.end());
    std::sort(after.begin(), after.end());
    CHECK(before == after);
    CHECK(found.segments.back().end == recorded.back().end);
    const FoundOrder again = search.search(StrategyKind::phase_locked);
    CHECK(shapes(again.segments) == shapes(found.segments));
  }
}

TEST_CASE("no more hitches come together than in the worst second of the recording") {
  // Hitches of 30 ms among 400 drawings of 8 ms: at most two in a second, in one place.
  std::vector<std::int64_t> drawings(400, 8);
  for (const std::size_t k : {30u, 110u, 120u, 200u, 280u, 370u}) drawings[k] = 30;
  const std::vector<SegmentTiming> recorded = drawn(drawings);
  REQUIRE(most_long_in_a_second(recorded) == 2);
  const MapSetup setup = setup_for(recorded);
  const OrderSearch seconds(setup, recorded, kSecond), parts(setup, recorded, Duration{100 * ms});
  CHECK(seconds.hitches() == 6);
  CHECK(seconds.most_together() == 2);
  CHECK(parts.most_together() == 1);
  for (const StrategyKind map : {StrategyKind::paper, StrategyKind::phase_locked}) {
    const FoundOrder found = seconds.search(map), apart = parts.search(map);
    INFO(name_of(map));
    CHECK(most_long_in_a_second(found.segments) == 2);
    CHECK(apart.row.worst_latency >= apart.row.latency);
    // For a map that sees how late it is, two in a row are worse than any two that are a tenth of a second apart; to `paper`
    // the first of two says that the next will be as long.
    if (map == StrategyKind::phase_locked) CHECK(found.row.worst_latency > apart.row.worst_latency);
  }
  // What the map needs with two in a row, as a person would try it.
  std::vector<std::int64_t> together = drawings;
  together[110] = 8;
  together[119] = 30;
  const Duration tried = latency_of(setup, StrategyKind::phase_locked, drawn(together));
  CHECK(seconds.search(StrategyKind::phase_locked).row.worst_latency >= tried);
}

TEST_CASE("random orders of a long recording need no more than the worst order found") {
  const std::vector<SegmentTiming> recorded = play(random_timing(4), 600);
  const MapSetup setup = setup_for(recorded);
  // In a span longer than the recording every order is allowed.
  const FoundOrder found = OrderSearch(setup, recorded, kSecond * 1000).search(StrategyKind::phase_locked);
  const RandomStream random(1, "worst_order.test");
  std::vector<std::size_t> order(recorded.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::uint64_t draw = 0;
  for (int round = 0; round < 200; ++round) {
    for (std::size_t i = order.size() - 2; i > 60; --i) std::swap(order[i], order[60 + random.below(draw++, i - 59)]);
    std::vector<SegmentTiming> shuffled;
    RealTime at = recorded.front().begin;
    for (const std::size_t k : order) {
      SegmentTiming one = recorded[k];
      const Duration by = at - one.begin;
      at = (k + 1 < recorded.size() ? recorded[k + 1].begin : one.end) + by;
      one.begin = one.begin + by;
      one.end = one.end + by;
      for (Interval& step : one.steps) step = {step.begin + by, step.end + by};
      shuffled.push_back(one);
    }
    CHECK(latency_of(setup, StrategyKind::phase_locked, shuffled) <= found.row.worst_latency);
  }
}

TEST_CASE("an order is refused where segments are no wholes, or too few") {
  std::vector<SegmentTiming> few = drawn({8, 8, 8});
  CHECK_THAT(OrderSearch(setup_for(few), few, kSecond).refused(), Contains("it has 3 segments"));
  std::vector<SegmentTiming> beside = drawn({8, 8, 8, 8});
  beside[1].concurrent = true;
  CHECK_THAT(OrderSearch(setup_for(beside), beside, kSecond).refused(), Contains("a lane of their own"));
  CHECK(parse_worst_order("2 s, map paper")->map == "paper");
  CHECK(parse_worst_order("2 s")->span == kSecond * 2);
  for (const char* bad : {"", "0 s", "1 s, 2 s", "1 V", "1 s, map", "1 s, maps paper"}) CHECK_FALSE(parse_worst_order(bad));
}
