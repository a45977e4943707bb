#include "evenstep/remap/sample_buffer.h"

#include "catch.h"

using namespace evenstep;

TEST_CASE("a sample buffer answers inside, underrun, overrun or empty: every time around every fill of capacities 2..6") {
  for (std::size_t capacity = 2; capacity <= 6; ++capacity) {
    for (int entries = 0; entries <= 14; ++entries) {
      SampleBuffer<double> buffer(capacity);
      for (int i = 1; i <= entries; ++i) buffer.push(RealTime{10 * i}, 100.0 * i);
      const int oldest = std::max(1, entries - static_cast<int>(capacity) + 1);
      for (std::int64_t at = 0; at <= 10 * entries + 12; ++at) {
        const Reading<double> reading = buffer.at(RealTime{at});
        if (entries == 0) {
          REQUIRE(reading.status == ReadStatus::empty);
          REQUIRE(reading.value == 0);
          continue;
        }
        REQUIRE(reading.newest.ns == 10 * entries);
        if (at > 10 * entries) {
          REQUIRE(reading.status == ReadStatus::underrun);
          REQUIRE(reading.value == 100.0 * entries);
        } else if (at < 10) {  // before the very first entry: nothing was lost if that entry is still there
          REQUIRE(reading.status == (oldest == 1 ? ReadStatus::inside : ReadStatus::overrun));
          REQUIRE(reading.value == 100.0 * oldest);
        } else if (at < 10 * oldest) {
          REQUIRE(reading.status == ReadStatus::overrun);
        } else {
          REQUIRE(reading.status == ReadStatus::inside);
          REQUIRE(reading.value == Approx(10.0 * static_cast<double>(at)).epsilon(1e-15));
          if (at % 10 == 0) REQUIRE(reading.value == 10.0 * static_cast<double>(at));  // on an entry: the same bits
        }
      }
    }
  }
}

TEST_CASE("a read at a head does not see what came later, for as long as the ring holds it") {
  SampleBuffer<double> buffer(8);
  for (int i = 1; i <= 4; ++i) buffer.push(RealTime{10 * i}, 100.0 * i);
  const Reading<double> then = buffer.at(RealTime{33}, 4), past = buffer.at(RealTime{45}, 4);
  CHECK(past.status == ReadStatus::underrun);
  for (int i = 5; i <= 10; ++i) {
    buffer.push(RealTime{10 * i}, 100.0 * i);
    const Reading<double> now = buffer.at(RealTime{33}, 4);
    CHECK(now.status == then.status);
    CHECK(now.value == then.value);
    CHECK(now.newest == then.newest);
    CHECK(buffer.at(RealTime{45}, 4).value == past.value);
    CHECK(buffer.newest(4).value == 400);
  }
  buffer.push(RealTime{110}, 0);  // 30 leaves the ring: entries 4..11 are left
  CHECK(buffer.at(RealTime{33}, 4).status == ReadStatus::overrun);
  CHECK(buffer.newest(4).status == ReadStatus::inside);
  buffer.push(RealTime{120}, 0);  // now the newest entry of that head has left, too
  CHECK(buffer.at(RealTime{45}, 4).status == ReadStatus::overrun);
  CHECK(buffer.newest(4).status == ReadStatus::overrun);
  CHECK(buffer.newest(0).status == ReadStatus::empty);
}

TEST_CASE("lerp is exact at both entries of binary fractions, constant where they agree, and works for arrays") {
  const std::array<double, 3> a{0, -1, 0.1}, b{1, 1, 0.1};
  for (int i = 0; i <= 64; ++i) {
    const double w = i / 64.0;
    const std::array<double, 3> r = lerp(a, b, w);
    CHECK(r[0] == w);
    CHECK(r[1] == -1 + 2 * w);
    CHECK(r[2] == 0.1);
  }
  for (int i = 0; i <= 97; ++i) CHECK(lerp(0.1, 0.1, i / 97.0) == 0.1);  // these weights are rounded
  static_assert(lerp(3.0, 7.0, 0.0) == 3.0);
  static_assert(lerp(3.0f, 7.0f, 0.5) == 5.0f);
}

TEST_CASE("the weight of a read is the correctly rounded ratio of two durations") {
  for (std::int64_t whole = 1; whole <= 300; ++whole) {
    for (std::int64_t part = 0; part <= whole; ++part) {
      REQUIRE(ratio({part}, {whole}) == static_cast<double>(part) / static_cast<double>(whole));
      SampleBuffer<double> buffer(2);
      buffer.push(RealTime{1'000'000'000}, 0);
      buffer.push(RealTime{1'000'000'000 + whole}, 1);
      REQUIRE(buffer.at(RealTime{1'000'000'000 + part}).value == static_cast<double>(part) / static_cast<double>(whole));
    }
  }
}

TEST_CASE("of several samples with one time the newest counts") {
  SampleBuffer<double> buffer(4);
  buffer.push(RealTime{10}, 1);
  buffer.push(RealTime{20}, 2);
  buffer.push(RealTime{20}, 3);
  CHECK(buffer.at(RealTime{20}).value == 3);
  buffer.push(RealTime{30}, 4);
  CHECK(buffer.at(RealTime{20}).value == 3);
  CHECK(buffer.at(RealTime{25}).value == 3.5);
  CHECK(buffer.at(RealTime{15}).value == 1.5);
}
