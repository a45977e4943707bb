#include "evenstep/remap/timed_ring.h"

#include <catch2/catch.hpp>

#include <thread>

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
        REQUIRE(ring.get(index, entry) == there);
        if (!there) continue;
        REQUIRE(entry.time.ns == static_cast<std::int64_t>(index) * 10);
        REQUIRE(entry.value == -static_cast<std::int64_t>(index));
      }
      ring.push(RealTime{static_cast<std::int64_t>(head) * 10}, -static_cast<std::int64_t>(head));
    }
  }
}

TEST_CASE("a ring of less than two entries stops on an assertion") {
  CHECK(testing::asserts([] { TimedRing<double> ring(1); }));
  CHECK_FALSE(testing::asserts([] { TimedRing<double> ring(2); }));
}

namespace {

/// Seven words that all follow from the first.
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
      if (!ring.get(head - back, entry)) { ++refused; continue; }
      ++read;
      wrong += entry.time.ns != static_cast<std::int64_t>(head - back) || entry.value != Sealed::of(head - back);
    }
  }
  writer.join();
  CHECK(wrong == 0);
  // All four left are readable now, so this cannot pass by refusing everything.
  for (std::uint64_t back = 1; back <= 4; ++back) {
    TimedRing<Sealed>::Entry entry;
    CHECK(ring.get(kPushes - back, entry));
    CHECK(entry.value == Sealed::of(kPushes - back));
  }
  CAPTURE(read, refused);
}

TEST_CASE("one writer and one reader: interpolation at a head gives the line, or says overrun") {
  // The value is its own time, so that any mixture of entries would be seen.
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
    const RealTime at{2 * static_cast<std::int64_t>(head) - 5};   // between the entries before the newest
    for (const Reading<double>& reading : {hand.at(at, head), forces.at(at, head)}) {
      if (reading.status == ReadStatus::inside) wrong += reading.value != static_cast<double>(at.ns);
      else wrong += reading.status != ReadStatus::overrun;
    }
  }
  writer.join();
  CHECK(wrong == 0);
}
