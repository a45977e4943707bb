#include "evenstep/remap/slot_map.h"

#include "catch.h"
#include "schedules.h"

using namespace evenstep;
using testing::asserts;

namespace {

/// Gives slots from a list; nullopt means acquiring.
class ListedMap final : public SlotMap {
 public:
  ListedMap(Duration lead, Duration latency, std::vector<std::optional<RealTime>> slots)
      : SlotMap(lead, latency), slots_(std::move(slots)) {}
  void boundary(std::int64_t, RealTime) override {}

 protected:
  std::optional<RealTime> slot(std::int64_t n) override { return slots_.at(static_cast<std::size_t>(n)); }

 private:
  std::vector<std::optional<RealTime>> slots_;
};

}  // namespace

TEST_CASE("a mapped step reads at slot - lead and emits at read + latency, whatever lead and latency are") {
  for (std::int64_t lead = -3; lead <= 3; ++lead) {
    for (std::int64_t latency = -3; latency <= 20; ++latency) {
      ListedMap map({lead}, {latency}, {RealTime{100}, RealTime{200}});
      for (std::int64_t n = 0; n < 2; ++n) {
        const Slot slot = map.read(n, RealTime{7});
        CHECK(slot.kind == SlotKind::mapped);
        CHECK(slot.read.ns == 100 * (n + 1) - lead);
        CHECK(map.emission(n, RealTime{9999}).ns == slot.read.ns + latency);
      }
      CHECK(map.emission_repairs() == 0);
    }
  }
}

TEST_CASE("while acquiring and for direct a step reads at its begin and emits at its end") {
  ListedMap acquiring({5}, {50}, {std::nullopt, std::nullopt});
  DirectMap direct;
  for (std::int64_t n = 0; n < 2; ++n) {
    const RealTime began{1000 * n}, ended{1000 * n + 300};
    const Slot slot = acquiring.read(n, began);
    CHECK(slot.kind == SlotKind::acquiring);
    CHECK(slot.read == began);
    CHECK(acquiring.emission(n, ended) == ended);
    const Slot newest = direct.read(n, began);
    CHECK(newest.kind == SlotKind::newest);
    CHECK(newest.read == began);
    CHECK(direct.emission(n, ended) == ended);
  }
}

TEST_CASE("emission times increase by at least 1 ns, and every repair is counted, all orders of four slots out of 0..3") {
  for (int code = 0; code < 256; ++code) {
    std::vector<std::optional<RealTime>> slots;
    for (int i = 0; i < 4; ++i) slots.push_back(RealTime{(code >> (2 * i)) & 3});
    ListedMap map({0}, {10}, slots);
    std::int64_t last = -1, repairs = 0;
    for (std::int64_t n = 0; n < 4; ++n) {
      map.read(n, {});
      const std::int64_t wanted = slots[static_cast<std::size_t>(n)]->ns + 10;
      const std::int64_t expected = n == 0 ? wanted : std::max(wanted, last + 1);
      repairs += expected != wanted;
      REQUIRE(map.emission(n, {}).ns == expected);
      last = expected;
    }
    REQUIRE(map.emission_repairs() == repairs);
  }
}

TEST_CASE("read and emission out of order stop on an assertion") {
  const auto fresh = [] { return ListedMap({0}, {0}, {RealTime{1}, RealTime{2}, RealTime{3}}); };
  CHECK(asserts([&] { fresh().read(1, {}); }));      // a step is skipped
  CHECK(asserts([&] { fresh().emission(0, {}); }));  // emission without a read
  CHECK(asserts([&] {
    auto map = fresh();
    map.read(0, {});
    map.read(0, {});
  }));  // read twice
  CHECK(asserts([&] {
    auto map = fresh();
    map.read(0, {});
    map.read(1, {});
  }));  // emission missed
  CHECK(asserts([&] {
    auto map = fresh();
    map.read(0, {});
    map.emission(1, {});
  }));  // emission of another step
  CHECK(asserts([&] {
    auto map = fresh();
    map.read(0, {});
    map.emission(0, {});
    map.emission(0, {});
  }));
  CHECK_FALSE(asserts([&] {
    auto map = fresh();
    map.read(0, {});
    map.emission(0, {});
    map.read(1, {});
  }));
}

TEST_CASE("boundaries that run backwards stop on an assertion") {
  const auto backwards = [](auto map) {
    map.boundary(5, RealTime{100});
    return asserts([&] { map.boundary(4, RealTime{200}); }) && asserts([&] { map.boundary(6, RealTime{99}); }) &&
           !asserts([&] { map.boundary(5, RealTime{100}); });
  };
  CHECK(backwards(PaperMap({}, {}, 0.1)));
  CHECK(backwards(PhaseLockedMap({}, {})));
}

TEST_CASE("the even map is the tick line of the step rate, a million slots on without drift") {
  EvenMap map(RealTime{77}, {450, 1}, {5}, {9});
  for (std::int64_t n = 0; n < 1'000'000; ++n) {
    REQUIRE(map.read(n, {}).read.ns == 77 - 5 + n * 1'000'000'000 / 450);
    map.emission(n, {});
  }
}
