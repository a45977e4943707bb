// What a read finds in a ring, compared with a walk over a list of everything that was pushed: back from the newest entry,
// one entry at a time.
#include <algorithm>
#include <thread>
#include <vector>

#include "catch.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/sample_buffer.h"
#include "for_all.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// Everything that was pushed. At a head, the last `capacity` entries before it count, as far as they are among the last
/// `capacity + spare` of all.
struct Pushed {
  std::size_t capacity = 0, spare = 0;
  std::vector<RealTime> times;
  std::uint64_t oldest(std::uint64_t head) const {
    const std::uint64_t kept = capacity + spare, all = times.size();
    return std::max(head > capacity ? head - capacity : 0, all > kept ? all - kept : 0);
  }
};

double value_of(std::uint64_t index) { return static_cast<double>(index * index); }

/// Where the walk ends: at the last entry at or before `at`, or nowhere.
struct Walk {
  bool any = false, found = false;
  std::uint64_t earlier = 0;  // the entry, if one was found
  std::uint64_t oldest = 0;
};
Walk walk(const Pushed& pushed, RealTime at, std::uint64_t head) {
  Walk walk{.oldest = pushed.oldest(head)};
  walk.any = walk.oldest < head;
  for (std::uint64_t index = head; index-- > walk.oldest && !walk.found;) {
    walk.found = pushed.times[index] <= at;
    walk.earlier = index;
  }
  return walk;
}

double on_the_line(const Pushed& pushed, std::uint64_t earlier, RealTime at) {
  const double w = ratio(at - pushed.times[earlier], pushed.times[earlier + 1] - pushed.times[earlier]);
  return lerp(value_of(earlier), value_of(earlier + 1), w);
}

Reading<double> expected_sample(const Pushed& pushed, RealTime at, std::uint64_t head) {
  const Walk found = walk(pushed, at, head);
  if (head == 0) return {};
  if (!found.any) return {0, ReadStatus::overrun, {}};
  const RealTime newest = pushed.times[head - 1];
  if (at > newest) return {value_of(head - 1), ReadStatus::underrun, newest};
  if (!found.found) return {value_of(found.oldest), found.oldest == 0 ? ReadStatus::inside : ReadStatus::overrun, newest};
  if (found.earlier == head - 1) return {value_of(head - 1), ReadStatus::inside, newest};
  return {on_the_line(pushed, found.earlier, at), ReadStatus::inside, newest};
}

Reading<double> expected_force(const Pushed& pushed, RealTime at, std::uint64_t head, Emission emission) {
  const Walk found = walk(pushed, at, head);
  if (head == 0) return {};
  if (!found.any) return {0, ReadStatus::overrun, {}};
  const RealTime newest = pushed.times[head - 1];
  if (!found.found && found.oldest == 0) return {0, ReadStatus::empty, newest};
  if (!found.found) return {value_of(found.oldest), ReadStatus::overrun, newest};
  if (emission == Emission::linear && at > newest) return {value_of(head - 1), ReadStatus::underrun, newest};
  if (emission == Emission::hold || found.earlier == head - 1) return {value_of(found.earlier), ReadStatus::inside, newest};
  return {on_the_line(pushed, found.earlier, at), ReadStatus::inside, newest};
}

bool same(const Reading<double>& a, const Reading<double>& b) {
  return a.value == b.value && a.status == b.status && a.newest == b.newest;
}

/// Rings of 2 to 300 entries are filled up to four times, with up to 7 entries of the same time. Reads come at old and new
/// heads: on entries, between them, before the first and past the newest.
const char* search_is_the_walk(Draw draw) {
  Pushed pushed;
  pushed.capacity = static_cast<std::size_t>(draw.between(0, 3) == 0 ? draw.between(2, 300) : draw.between(2, 20));
  pushed.spare = static_cast<std::size_t>(draw.between(0, 2) == 0 ? draw.between(0, 40) : 0);
  const bool hold = draw.between(0, 1) == 0;
  const Emission emission = hold ? Emission::hold : Emission::linear;
  SampleBuffer<double> hand(pushed.capacity, kHoldNewest, pushed.spare);
  ForceSchedule<double> forces(pushed.capacity, emission, kHoldNewest, pushed.spare);
  const std::int64_t count = draw.between(0, 4 * static_cast<std::int64_t>(pushed.capacity));
  const std::int64_t widest = draw.between(1, 1'000);
  RealTime time{draw.between(-50, 50)};
  for (std::int64_t i = 0; i < count; ++i) {
    const double value = value_of(pushed.times.size());
    hand.push(time, value);
    forces.push(time, value);
    pushed.times.push_back(time);
    time = time + Duration{draw.between(0, 9) < 3 ? 0 : draw.between(1, widest)};
  }
  for (int read = 0; read < 12; ++read) {
    const auto all = static_cast<std::int64_t>(pushed.times.size());
    const auto head = static_cast<std::uint64_t>(draw.between(0, 1) == 0 ? all : draw.between(0, all));
    RealTime at{draw.between(-60, time.ns + 60)};
    if (all > 0 && draw.between(0, 2) == 0) at = pushed.times[static_cast<std::size_t>(draw.between(0, all - 1))];
    if (!same(hand.at(at, head), expected_sample(pushed, at, head))) return "a sample differs from the walk's";
    if (!same(forces.at(at, head), expected_force(pushed, at, head, emission))) return "a force differs from the walk's";
  }
  return nullptr;
}

}  // namespace

TEST_CASE("a read finds what a walk back from the newest entry finds: 12 reads in each of 100,000 rings") {
  for_all_draws(kMany, search_is_the_walk);
}

TEST_CASE("a read finds what a walk back from the newest entry finds: 12 reads in each of 1,000,000 rings", "[long]") {
  for_all_draws(kVeryMany, search_is_the_walk);
}

TEST_CASE("a read finds every entry and every gap of a ring, of each fill up to 130 and capacities around powers of two") {
  for (const std::size_t capacity : {2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65}) {
    SampleBuffer<double> hand(capacity);
    ForceSchedule<double> forces(capacity, Emission::linear);
    Pushed pushed{.capacity = capacity};
    for (std::int64_t fill = 1; fill <= 130; ++fill) {
      const double value = value_of(pushed.times.size());
      hand.push(RealTime{2 * fill}, value);
      forces.push(RealTime{2 * fill}, value);
      pushed.times.push_back(RealTime{2 * fill});
      for (std::int64_t at = 1; at <= 2 * fill + 1; ++at) {
        const auto head = static_cast<std::uint64_t>(fill);
        REQUIRE(same(hand.at(RealTime{at}, head), expected_sample(pushed, RealTime{at}, head)));
        REQUIRE(same(forces.at(RealTime{at}, head), expected_force(pushed, RealTime{at}, head, Emission::linear)));
      }
    }
  }
}

TEST_CASE("one writer and one reader: a reading far back is on the line, or says overrun, while the writer overtakes it") {
  // Each value is its own time, so that any mixture of entries would be seen. Reads go back as far as the oldest entry of
  // the ring, which the writer overwrites next.
  constexpr std::int64_t kPushes = 200'000;
  constexpr std::int64_t kCapacity = 64;
  SampleBuffer<double> hand(kCapacity);
  ForceSchedule<double> forces(kCapacity, Emission::linear);
  std::thread writer([&] {
    for (std::int64_t i = 0; i < kPushes; ++i) {
      hand.push(RealTime{2 * i}, static_cast<double>(2 * i));
      forces.push(RealTime{2 * i}, static_cast<double>(2 * i));
    }
  });
  std::int64_t wrong = 0, inside = 0, back = 1;
  std::uint64_t head = 0;
  const auto read = [&] {
    const RealTime at{2 * (static_cast<std::int64_t>(head) - 1 - back) + 1};  // between the entries `back` and back - 1
    for (const Reading<double>& reading : {hand.at(at, head), forces.at(at, head)}) {
      inside += reading.status == ReadStatus::inside;
      if (reading.status == ReadStatus::inside)
        wrong += reading.value != static_cast<double>(at.ns);
      else
        wrong += reading.status != ReadStatus::overrun;
    }
    back = back % (kCapacity - 1) + 1;
  };
  for (; head < kPushes; head = forces.head())
    if (head > kCapacity) read();
  writer.join();
  CHECK(wrong == 0);
  // The writer has ended, so the whole ring can be read.
  const std::int64_t before = inside;
  back = 1;
  while (back < kCapacity - 1) read();
  CHECK(inside - before >= 2 * (kCapacity - 3));
  CHECK(wrong == 0);
}
