#include "evenstep/remap/timed_ring.h"

#include <thread>

#include "catch.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/sample_buffer.h"
#include "evenstep/time/digest.h"
#include "schedules.h"

using namespace evenstep;

TEST_CASE("a ring gives the last `capacity` entries and no other: every capacity 2..9, every fill up to 3 times round") {
  for (std::size_t capacity = 2; capacity <= 9; ++capacity) {
    TimedRing<std::int64_t> ring(capacity);
    CHECK(ring.capacity() == capacity);
    for (std::uint64_t head = 0; head <= 3 * capacity + 1; ++head) {
      REQUIRE(ring.head() == head);
      for (std::uint64_t index = 0; index < head + 3; ++index) {
        TimedRing<std::int64_t>::Entry entry;
        const bool there = index < head && head - index <= capacity;
        REQUIRE(ring.get(index, head, entry) == there);
        // An entry that is not there yet cannot be read, even with a head beyond it.
        REQUIRE((index < head || !ring.get(index, index + 1, entry)));
        if (!there) continue;
        REQUIRE(entry.time.ns == static_cast<std::int64_t>(index) * 10);
        REQUIRE(entry.value == -static_cast<std::int64_t>(index));
      }
      ring.push(RealTime{static_cast<std::int64_t>(head) * 10}, -static_cast<std::int64_t>(head));
    }
  }
}

TEST_CASE(
    "what is read at a head stays the same until more than the spare entries were pushed since, every capacity and spare up "
    "to 6") {
  const auto time = [](std::uint64_t index) { return RealTime{static_cast<std::int64_t>(index) * 10}; };
  for (std::size_t capacity = 2; capacity <= 6; ++capacity) {
    for (std::size_t spare = 0; spare <= 6; ++spare) {
      for (std::uint64_t head = 1; head <= 20; ++head) {
        TimedRing<std::uint64_t> ring(capacity, spare);
        for (std::uint64_t index = 0; index < head; ++index) ring.push(time(index), index);
        for (std::uint64_t since = 0; since <= spare + capacity + 1; ++since) {
          for (std::uint64_t index = 0; index < head + 2; ++index) {
            TimedRing<std::uint64_t>::Entry entry;
            const bool there = index < head && head - index <= capacity && head + since - index <= capacity + spare;
            REQUIRE(ring.get(index, head, entry) == there);
            if (there) REQUIRE((entry.time == time(index) && entry.value == index));
          }
          ring.push(time(head + since), head + since);
        }
      }
    }
  }
}

TEST_CASE("a buffer and a schedule say at a head what they said then, overruns included, however far the writer is by now") {
  SampleBuffer<double> hand(4, kHoldNewest, 30);
  ForceSchedule<double> forces(4, Emission::linear, kHoldNewest, 30);
  std::vector<std::vector<Reading<double>>> then(31);
  const auto read = [&](std::uint64_t head) {
    std::vector<Reading<double>> all;
    for (std::int64_t at = -5; at <= 320; at += 5) {
      all.push_back(hand.at(RealTime{at}, head));
      all.push_back(forces.at(RealTime{at}, head));
    }
    return all;
  };
  for (std::uint64_t head = 1; head <= 30; ++head) {
    const double value = static_cast<double>(head * head);
    hand.push(RealTime{static_cast<std::int64_t>(head) * 10}, value);
    forces.push(RealTime{static_cast<std::int64_t>(head) * 10}, value);
    then[head] = read(head);
  }
  bool overruns = false;
  for (std::uint64_t head = 1; head <= 30; ++head) {
    const std::vector<Reading<double>> now = read(head);
    for (std::size_t i = 0; i < now.size(); ++i) {
      REQUIRE((now[i].value == then[head][i].value && now[i].status == then[head][i].status &&
               now[i].newest == then[head][i].newest));
      overruns = overruns || now[i].status == ReadStatus::overrun;
    }
  }
  CHECK(overruns);
}

TEST_CASE("a ring of less than two entries stops on an assertion") {
  CHECK(testing::asserts([] { TimedRing<double> ring(1); }));
  CHECK_FALSE(testing::asserts([] { TimedRing<double> ring(2); }));
}

namespace {

/// Seven words; the first determines all others.
struct Sealed {
  std::array<std::uint64_t, 7> words;
  static Sealed of(std::uint64_t key) {
    Sealed sealed{};
    for (std::uint64_t i = 0; i < 7; ++i) sealed.words[i] = mix(key, i);
    return sealed;
  }
  bool operator==(const Sealed&) const = default;
};

}  // namespace

TEST_CASE("one writer and one reader: an entry that was read is whole and the right one, or it was an overrun") {
  constexpr std::uint64_t kPushes = 300'000;
  TimedRing<Sealed> ring(4);
  std::uint64_t read = 0, refused = 0, wrong = 0;
  std::thread writer([&] {
    for (std::uint64_t i = 0; i < kPushes; ++i) ring.push(RealTime{static_cast<std::int64_t>(i)}, Sealed::of(i));
  });
  for (std::uint64_t head = 0; head < kPushes; head = ring.head()) {
    for (std::uint64_t back = 1; back <= std::min<std::uint64_t>(head, 6); ++back) {
      TimedRing<Sealed>::Entry entry;
      if (!ring.get(head - back, head, entry)) {
        ++refused;
        continue;
      }
      ++read;
      wrong += entry.time.ns != static_cast<std::int64_t>(head - back) || entry.value != Sealed::of(head - back);
    }
  }
  writer.join();
  CHECK(wrong == 0);
  // The four entries that are left can be read now, so a ring that refuses everything does not pass.
  for (std::uint64_t back = 1; back <= 4; ++back) {
    TimedRing<Sealed>::Entry entry;
    CHECK(ring.get(kPushes - back, kPushes, entry));
    CHECK(entry.value == Sealed::of(kPushes - back));
  }
  CAPTURE(read, refused);
}

TEST_CASE("one writer and one reader: interpolation at a head gives the line, or says overrun") {
  // Each value is its own time, so that any mixture of entries would be seen.
  constexpr std::int64_t kPushes = 200'000;
  SampleBuffer<double> hand(8);
  ForceSchedule<double> forces(8, Emission::linear);
  std::thread writer([&] {
    for (std::int64_t i = 0; i < kPushes; ++i) {
      hand.push(RealTime{2 * i}, static_cast<double>(2 * i));
      forces.push(RealTime{2 * i}, static_cast<double>(2 * i));
    }
  });
  std::int64_t wrong = 0;
  for (std::uint64_t head = 0; head < kPushes; head = forces.head()) {
    if (head < 4) continue;
    const RealTime at{2 * static_cast<std::int64_t>(head) - 5};  // between the entries before the newest
    for (const Reading<double>& reading : {hand.at(at, head), forces.at(at, head)}) {
      if (reading.status == ReadStatus::inside)
        wrong += reading.value != static_cast<double>(at.ns);
      else
        wrong += reading.status != ReadStatus::overrun;
    }
  }
  writer.join();
  CHECK(wrong == 0);
}
