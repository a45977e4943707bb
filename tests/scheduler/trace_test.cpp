#include <algorithm>

#include "rig.h"

namespace evenstep::test {
namespace {

Task notes(Scheduler& scheduler, std::uint64_t seed) {
  for (int k = 0; k < 20; ++k) {
    co_await scheduler.until({k * 100}, Lane::device, "quiet");
    const Arrival arrival = co_await scheduler.until({k * 100 + 50}, Lane::launch, "loud");
    scheduler.note(static_cast<std::uint64_t>(arrival.scheduled.ns) + seed);
    scheduler.note(0.5 * k);
  }
}

TEST_CASE("An event's payload is the mix of its notes, 0 without") {
  VirtualRig rig;
  rig.scheduler.spawn(notes(rig.scheduler, 3));
  rig.scheduler.run(kNever);
  const auto& events = rig.scheduler.events();
  REQUIRE(events.size() == 40);
  for (std::size_t i = 0; i < events.size(); ++i) {
    const auto k = static_cast<std::uint64_t>(i / 2);
    CHECK(events[i].payload == (i % 2 == 0 ? 0 : mix(mix(0, k * 100 + 53), 0.5 * static_cast<double>(k))));
  }
}

TEST_CASE("After every event the trace hash is the chain over the events so far, kept or not") {
  VirtualRig kept;
  VirtualRig counted({.keep_events = false});
  kept.scheduler.spawn(notes(kept.scheduler, 3));
  counted.scheduler.spawn(notes(counted.scheduler, 3));
  CHECK(kept.scheduler.trace_hash() == 0);
  while (kept.scheduler.run_one()) {
    REQUIRE(counted.scheduler.run_one());
    REQUIRE(kept.scheduler.trace_hash() == chain(kept.scheduler.events()));
    REQUIRE(counted.scheduler.trace_hash() == kept.scheduler.trace_hash());
  }
  CHECK(counted.scheduler.events().empty());
  CHECK(counted.scheduler.event_count() == 40);
}

TEST_CASE("Every field of every event changes the chain, and so does the order") {
  VirtualRig rig;
  rig.scheduler.spawn(notes(rig.scheduler, 3));
  rig.scheduler.run(kNever);
  const std::vector<Event> events = rig.scheduler.events();
  const std::uint64_t whole = chain(events);
  for (std::size_t i = 0; i < events.size(); ++i) {
    for (int field = 0; field < 5; ++field) {
      std::vector<Event> changed = events;
      switch (field) {
        case 0:
          changed[i].time = changed[i].time + Duration{1};
          break;
        case 1:
          changed[i].lane = Lane::completion;
          break;
        case 2:
          changed[i].name = EventName("other");
          break;
        case 3:
          changed[i].payload ^= 1;
          break;
        case 4:
          std::swap(changed[i], changed[(i + 1) % changed.size()]);
          break;
      }
      CAPTURE(i, field);
      CHECK(chain(changed) != whole);
    }
  }
}

TEST_CASE("One nanosecond and one note of difference give another hash, the same run the same") {
  const auto hash = [](std::uint64_t seed) {
    VirtualRig rig;
    rig.scheduler.spawn(notes(rig.scheduler, seed));
    rig.scheduler.run(kNever);
    return rig.scheduler.trace_hash();
  };
  CHECK(hash(3) == hash(3));
  CHECK(hash(3) != hash(4));
}

// ---- merge

Event event(std::int64_t ns, Lane lane, std::uint64_t payload) { return {{ns}, lane, EventName("e"), payload}; }
std::vector<std::uint64_t> payloads(const std::vector<Event>& events) {
  std::vector<std::uint64_t> result;
  for (const Event& e : events) result.push_back(e.payload);
  return result;
}

TEST_CASE("Two sorted logs merge by (time, lane), a before b, each log's order kept, 1000 random pairs") {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    std::vector<Event> logs[2];
    for (std::uint64_t i = 0; i < 30; ++i) {
      const std::uint64_t n = 3 * i;
      logs[draw(seed, n, 2)].push_back(event(draw(seed, n + 1, 5), static_cast<Lane>(draw(seed, n + 2, 3)), i));
    }
    const auto earlier = [](const Event& a, const Event& b) {
      return std::pair(a.time, a.lane) < std::pair(b.time, b.lane);
    };
    std::vector<Event> expected;
    for (auto& log : logs) {
      std::stable_sort(log.begin(), log.end(), earlier);
      expected.insert(expected.end(), log.begin(), log.end());
    }
    std::stable_sort(expected.begin(), expected.end(), earlier);
    REQUIRE(payloads(merge(logs[0], logs[1])) == payloads(expected));
    // The same while the logs grow. Each log is known until some instant, one further than the other.
    std::vector<Event> merged;
    EventMerge growing([&](const Event& event) { merged.push_back(event); });
    std::size_t given[2] = {0, 0};
    for (std::uint64_t i = 0; i < 12; ++i) {
      const std::size_t which = draw(seed, 1000 + i, 2);
      const std::int64_t until = draw(seed, 2000 + i, 6);
      const std::size_t from = given[which];
      while (given[which] < logs[which].size() && logs[which][given[which]].time.ns < until) ++given[which];
      const std::span<const Event> more(logs[which].data() + from, given[which] - from);
      which == 0 ? growing.add_a(more, RealTime{until}) : growing.add_b(more, RealTime{until});
    }
    growing.add_a({logs[0].begin() + static_cast<std::ptrdiff_t>(given[0]), logs[0].end()}, RealTime{5});
    growing.add_b({logs[1].begin() + static_cast<std::ptrdiff_t>(given[1]), logs[1].end()}, RealTime{5});
    CHECK(growing.waiting() == 0);
    growing.finish();
    REQUIRE(payloads(merged) == payloads(expected));
  }
}

TEST_CASE("A completion that a device event asked for at its own instant stays behind it in the merged log") {
  const std::vector<Event> a = {event(5, Lane::device, 1), event(5, Lane::completion, 2), event(6, Lane::device, 3)};
  const std::vector<Event> b = {event(5, Lane::device, 4), event(5, Lane::launch, 5)};
  // On one scheduler both device events wait. That of `a` runs first and asks for a completion, which sorts before that of
  // `b`.
  CHECK(payloads(merge(a, b)) == std::vector<std::uint64_t>{1, 2, 4, 5, 3});
  CHECK(payloads(merge(b, a)) == std::vector<std::uint64_t>{4, 1, 2, 5, 3});
  CHECK(payloads(merge(a, {})) == payloads(a));
  CHECK(payloads(merge({}, a)) == payloads(a));
}

}  // namespace
}  // namespace evenstep::test
