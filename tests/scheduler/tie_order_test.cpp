#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "rig.h"

namespace evenstep::test {
namespace {

constexpr Lane kLanes[] = {Lane::completion, Lane::device, Lane::launch};

/// The i-th spawned task asks for `lanes[i]`, all at one instant. Returns the order in which the tasks ran.
std::vector<int> order_at_one_instant(const std::vector<Lane>& lanes, std::optional<std::uint64_t> permute_ties = {}) {
  VirtualRig rig({.permute_ties = permute_ties});
  std::vector<int> log;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    rig.scheduler.spawn(mark(rig.scheduler, {1000}, lanes[i], static_cast<int>(i), log));
  }
  REQUIRE(rig.scheduler.run(kNever).end == RunEnd::idle);
  return log;
}

TEST_CASE(
    "At one instant completions run before device events before launches, each in the order of asking, for all 3^6 "
    "insertions") {
  for (int code = 0; code < 729; ++code) {
    std::vector<Lane> lanes;
    for (int i = 0, rest = code; i < 6; ++i, rest /= 3) lanes.push_back(kLanes[rest % 3]);
    std::vector<int> expected(lanes.size());
    std::iota(expected.begin(), expected.end(), 0);
    std::stable_sort(expected.begin(), expected.end(), [&](int a, int b) { return lanes[a] < lanes[b]; });
    REQUIRE(order_at_one_instant(lanes) == expected);
  }
}

struct Ask {
  std::int64_t delay_ns;
  Lane lane;
};
std::vector<Ask> random_asks(std::uint64_t seed, int lane) {
  std::vector<Ask> asks;
  for (std::uint64_t n = 0; n < 12; ++n) {
    const std::uint64_t stream = seed * 16 + static_cast<std::uint64_t>(lane);
    asks.push_back({draw(stream, 2 * n, 6) - 2, kLanes[draw(stream, 2 * n + 1, 3)]});  // -2: some lie in the past
  }
  return asks;
}
Task follow(Scheduler& scheduler, const std::vector<Ask>& asks, int who, std::vector<std::pair<int, std::int64_t>>& log) {
  for (const Ask& ask : asks) {
    co_await scheduler.until(RealTime{scheduler.now().ns + ask.delay_ns}, ask.lane, "follow");
    log.emplace_back(who, scheduler.now().ns);
  }
}

TEST_CASE("Events run in the order of a sorted list of (time, lane, sequence), 2000 random schedules, seeds 0 to 1999") {
  constexpr int kCount = 8;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    VirtualRig rig;
    std::vector<std::vector<Ask>> asks;
    std::vector<std::pair<int, std::int64_t>> log;
    for (int i = 0; i < kCount; ++i) asks.push_back(random_asks(seed, i));
    for (int i = 0; i < kCount; ++i) rig.scheduler.spawn(follow(rig.scheduler, asks[i], i, log));
    REQUIRE(rig.scheduler.run(kNever).end == RunEnd::idle);

    std::set<std::tuple<std::int64_t, Lane, int, int>> pending;  // time, lane, sequence, who
    std::vector<std::size_t> position(kCount, 0);
    std::vector<std::pair<int, std::int64_t>> expected;
    std::int64_t now = 0;
    int sequence = 0;
    const auto ask = [&](int who) {
      if (position[who] == asks[who].size()) return;
      const Ask& next = asks[who][position[who]++];
      pending.emplace(std::max(now + next.delay_ns, now), next.lane, ++sequence, who);
    };
    for (int i = 0; i < kCount; ++i) ask(i);
    while (!pending.empty()) {
      const auto [time, lane, number, who] = *pending.begin();
      pending.erase(pending.begin());
      now = time;
      expected.emplace_back(who, now);
      ask(who);
    }
    REQUIRE(log == expected);
  }
}

Task late_asker(Scheduler& scheduler, Lane lane, std::vector<int>& log, Arrival& arrival) {
  co_await scheduler.until({5000}, Lane::device, "first");
  log.push_back(0);
  const Arrival second = co_await scheduler.until({1}, lane, "past");
  arrival = second;
  log.push_back(1);
}

TEST_CASE("An await in the past is an event of its own at now(), at its lane's place among those that still wait") {
  const std::pair<Lane, std::vector<int>> rows[] = {
      {Lane::completion, {0, 1, 2, 3}},  // sorts before the device event 2 that already waits
      {Lane::device, {0, 2, 1, 3}},      // after 2, which asked first
      {Lane::launch, {0, 2, 3, 1}},      // after the launch 3, which asked first
  };
  for (const auto& [lane, expected] : rows) {
    VirtualRig rig;
    std::vector<int> log;
    Arrival arrival;
    rig.scheduler.spawn(late_asker(rig.scheduler, lane, log, arrival));
    rig.scheduler.spawn(mark(rig.scheduler, {5000}, Lane::device, 2, log));
    rig.scheduler.spawn(mark(rig.scheduler, {5000}, Lane::launch, 3, log));
    rig.scheduler.run(kNever);
    CAPTURE(lane_name(lane));
    CHECK(log == expected);
    CHECK(arrival.scheduled == RealTime{5000});
    CHECK(rig.scheduler.event_count() == 4);
  }
}

// ---- A step launched on a tick

Task ticks(Scheduler& scheduler, std::int64_t period_ns, int count, std::int64_t& newest_sample) {
  for (int k = 0; k < count; ++k) {
    co_await scheduler.until({k * period_ns}, Lane::device, "tick");
    newest_sample = k;
  }
}
Task steps(Scheduler& scheduler, std::int64_t step_ns, int count, bool with_turn, const std::int64_t& newest_sample,
           std::vector<std::int64_t>& seen) {
  for (int n = 1; n <= count; ++n) {
    co_await scheduler.external({n * step_ns}, nullptr, "step");
    if (with_turn) {
      co_await scheduler.turn(Lane::launch, "launch");
    }
    seen.push_back(newest_sample);
  }
}

TEST_CASE(
    "A step launched on a tick sees that tick's sample with a turn and the sample before without, whoever is spawned "
    "first") {
  // Steps of 3 ms against ticks of 1 ms: every launch falls on a tick.
  for (const bool with_turn : {true, false}) {
    for (const bool ticks_first : {true, false}) {
      VirtualRig rig;
      std::int64_t newest = -1;
      std::vector<std::int64_t> seen;
      std::vector<std::int64_t> expected;
      for (int n = 1; n <= 20; ++n) expected.push_back(with_turn ? 3 * n : 3 * n - 1);
      if (ticks_first) rig.scheduler.spawn(ticks(rig.scheduler, 1'000'000, 61, newest));
      rig.scheduler.spawn(steps(rig.scheduler, 3'000'000, 20, with_turn, newest, seen));
      if (!ticks_first) rig.scheduler.spawn(ticks(rig.scheduler, 1'000'000, 61, newest));
      rig.scheduler.run(kNever);
      CAPTURE(with_turn, ticks_first);
      CHECK(seen == expected);
    }
  }
}

// ---- permute_ties

TEST_CASE("With permuted ties every order of n tied events occurs over the seeds and none is lost, n = 1 to 5") {
  int factorial = 1;
  for (int n = 1; n <= 5; ++n) {
    factorial *= n;
    std::map<std::vector<int>, int> orders;
    const int seeds =
        60 * factorial;  // each order 60 times on average; a fair shuffle misses one with probability 120 * exp(-60)
    for (int seed = 0; seed < seeds; ++seed) {
      std::vector<int> order = order_at_one_instant(std::vector<Lane>(static_cast<std::size_t>(n), Lane::device), seed);
      ++orders[order];
      std::sort(order.begin(), order.end());
      for (int i = 0; i < n; ++i) REQUIRE(order.at(static_cast<std::size_t>(i)) == i);
    }
    CAPTURE(n);
    CHECK(static_cast<int>(orders.size()) == factorial);
    // 60 +- 6 standard deviations of a binomial (sqrt(60) = 7.7): no order is much rarer than the others.
    for (const auto& [order, count] : orders) CHECK((n == 1 || (count > 14 && count < 106)));
  }
}

TEST_CASE("Permuted ties never reorder events of different time or lane, 3^6 insertions") {
  for (int code = 0; code < 729; ++code) {
    std::vector<Lane> lanes;
    for (int i = 0, rest = code; i < 6; ++i, rest /= 3) lanes.push_back(kLanes[rest % 3]);
    const std::vector<int> order = order_at_one_instant(lanes, code);
    REQUIRE(order.size() == lanes.size());
    REQUIRE(std::is_sorted(order.begin(), order.end(), [&](int a, int b) { return lanes[a] < lanes[b]; }));
  }
  VirtualRig rig({.permute_ties = 7});
  std::vector<int> log;
  for (int i = 0; i < 100; ++i) rig.scheduler.spawn(mark(rig.scheduler, {100 - i}, kLanes[i % 3], 100 - i, log));
  rig.scheduler.run(kNever);
  CHECK(log.size() == 100);
  CHECK(std::is_sorted(log.begin(), log.end()));
}

TEST_CASE("The same permutation seed gives the same order") {
  const std::vector<Lane> lanes(40, Lane::launch);
  for (std::uint64_t seed = 0; seed < 50; ++seed)
    CHECK(order_at_one_instant(lanes, seed) == order_at_one_instant(lanes, seed));
}

}  // namespace
}  // namespace evenstep::test
