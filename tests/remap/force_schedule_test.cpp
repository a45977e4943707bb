#include "evenstep/remap/force_schedule.h"

#include "catch.h"

using namespace evenstep;

TEST_CASE("a force schedule plays held and interpolated forces: every time around every fill of capacities 2..6") {
  for (const Emission emission : {Emission::hold, Emission::linear}) {
    for (std::size_t capacity = 2; capacity <= 6; ++capacity) {
      ForceSchedule<double> forces(capacity, emission);
      for (int entries = 0; entries <= 14; ++entries) {
        const int oldest = std::max(1, entries - static_cast<int>(capacity) + 1);
        for (std::int64_t at = 0; at <= 10 * entries + 12; ++at) {
          const Reading<double> reading = forces.at(RealTime{at});
          if (entries == 0 || (at < 10 && oldest == 1)) {
            REQUIRE(reading.status == ReadStatus::empty);
            REQUIRE(reading.value == 0);
          } else if (at < 10 * oldest) {
            REQUIRE(reading.status == ReadStatus::overrun);
          } else if (at > 10 * entries) {
            REQUIRE(reading.status == (emission == Emission::linear ? ReadStatus::underrun : ReadStatus::inside));
            REQUIRE(reading.value == 100.0 * entries);
          } else {
            REQUIRE(reading.status == ReadStatus::inside);
            const double held = 100.0 * static_cast<double>(at / 10), line = 10.0 * static_cast<double>(at);
            if (emission == Emission::hold || at % 10 == 0)
              REQUIRE(reading.value == held);
            else
              REQUIRE(reading.value == Approx(line).epsilon(1e-15));
          }
          if (entries > 0) REQUIRE(reading.newest.ns == 10 * entries);
        }
        forces.push(RealTime{10 * (entries + 1)}, 100.0 * (entries + 1));
      }
    }
  }
}

TEST_CASE("a force read at a head does not see what came later") {
  ForceSchedule<double> forces(6, Emission::linear);
  forces.push(RealTime{10}, 1);
  forces.push(RealTime{20}, 2);
  CHECK(forces.at(RealTime{25}, 2).status == ReadStatus::underrun);
  for (int i = 3; i <= 6; ++i) {
    forces.push(RealTime{10 * i}, i);
    CHECK(forces.at(RealTime{25}, 2).status == ReadStatus::underrun);
    CHECK(forces.at(RealTime{25}, 2).value == 2);
    CHECK(forces.at(RealTime{15}, 2).value == 1.5);
  }
  CHECK(forces.at(RealTime{25}).value == 2.5);
  CHECK(forces.at(RealTime{25}, 0).status == ReadStatus::empty);
  forces.push(RealTime{70}, 7);
  CHECK(forces.at(RealTime{15}, 2).status == ReadStatus::overrun);
  forces.push(RealTime{80}, 8);
  CHECK(forces.at(RealTime{25}, 2).status == ReadStatus::overrun);  // even the newest entry of that head has left
}
