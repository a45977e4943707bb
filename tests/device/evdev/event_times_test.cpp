// When the positions of an event device were taken, for events whose times can be believed and for others.

#include <cerrno>
#include <limits>
#include <memory>
#include <vector>

#include "../units.h"
#include "catch.h"
#include "evdev_bench.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/evdev/event_times.h"
#include "evenstep/device/evdev/live_evdev.h"
#include "evenstep/device/evdev/simulated_evdev.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::int64_t kHour = 3'600'000 * kMs;
constexpr Duration kUnchanged{2 * kMs};

RealTime ms(double at) { return RealTime{static_cast<std::int64_t>(at * kMs)}; }

EvdevOptions timed() {
  EvdevOptions options = evdev_options();
  options.travel_m = {0.2, 0, 0};  // a count of the scripted node is 1 mm
  options.unchanged_age = kUnchanged;
  return options;
}

const EvdevEvent kDropped{evdev::kSyn, evdev::kSynDropped, 0};

std::vector<EvdevEvent> position(std::int32_t x, RealTime at) {
  return {{evdev::kAbs, 0, x, at}, {evdev::kSyn, evdev::kSynReport, 0, at}};
}

struct TimedNode : ScriptedNode {
  bool tells_times() const override { return tells; }
  int axis(std::uint16_t code, EvdevAxis& axis) override { return is_busy ? EAGAIN : ScriptedNode::axis(code, axis); }
  bool tells = true, is_busy = false;
};

}  // namespace

TEST_CASE(
    "event times: a position is of its event, and one that nothing changes holds until the last report that is missing") {
  EventTimes times(kUnchanged);
  CHECK(times.taken(ms(10)) < ms(-1000));
  CHECK(times.unchanged(ms(10)));
  CHECK(times.taken(ms(10)) == ms(8));
  times.changed(ms(10.3), ms(11));
  CHECK(times.taken(ms(11)) == ms(10.3));
  CHECK_FALSE(times.unchanged(ms(12)));  // a report may have been made at 12.2 and still be on its way
  CHECK(times.taken(ms(12)) == ms(10.3));
  CHECK(times.unchanged(ms(13)));
  CHECK(times.taken(ms(13)) == ms(11));
  times.changed(ms(13.2), ms(14));
  CHECK(times.taken(ms(14)) == ms(13.2));
  CHECK(times.ages().ages.count() == 2);
  CHECK(times.ages().ages.largest() == Duration{8 * kMs / 10});
  CHECK((times.ages().ahead == 0 && times.ages().capped == 0));
}

TEST_CASE("event times: one from the future is that of the read, and the most that is counted of it is an hour") {
  EventTimes times(kUnchanged);
  times.changed(ms(10.25), ms(10));
  CHECK(times.taken(ms(10)) == ms(10));
  CHECK(times.ages().ahead_max == Duration{kMs / 4});
  for (const std::int64_t ns : {5 * kHour, std::numeric_limits<std::int64_t>::max()}) times.changed(RealTime{ns}, ms(11));
  CHECK(times.taken(ms(11)) == ms(11));
  CHECK(times.ages().ahead == 3);
  CHECK(times.ages().ahead_max == Duration{kHour});
}

TEST_CASE("event times: zero, and one of hours ago, are counted and taken for one that is not known") {
  EventTimes times(kUnchanged);
  times.changed(ms(7000), ms(7000.5));
  for (const std::int64_t ns : {std::int64_t{0}, -5 * kHour, std::numeric_limits<std::int64_t>::min()}) {
    CAPTURE(ns);
    times.changed(RealTime{ns}, ms(7010));
    CHECK(times.taken(ms(7010)) >= ms(7008));
    CHECK(times.taken(ms(7010)) <= ms(7008) + Duration{2});
  }
  CHECK(times.ages().capped == 3);
  CHECK(times.ages().ages.largest() == kUnchanged);
}

TEST_CASE("event times: one that goes back is a nanosecond after the time before it, and counted") {
  EventTimes times(kUnchanged);
  times.changed(ms(10.5), ms(11));
  times.changed(ms(10.4), ms(12));
  CHECK(times.taken(ms(12)) == ms(10.5) + Duration{1});
  times.changed(ms(10.4), ms(12));
  CHECK(times.taken(ms(12)) == ms(10.5) + Duration{2});
  CHECK(times.ages().capped == 2);
}

TEST_CASE("event times: whatever events say, a time is within a second of its read and none goes back") {
  std::uint64_t state = 1;
  const auto random = [&](std::uint64_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::int64_t>((state >> 20) % below);
  };
  EventTimes times(kUnchanged);
  RealTime read, last = times.taken(read);
  std::int64_t said = 0, wrong = 0;
  for (int i = 0; i < 100'000; ++i) {
    read = read + Duration{random(3) * random(2 * kMs)};
    if (random(3) == 0) {
      times.unchanged(read);
    } else {
      const std::int64_t kinds[] = {read.ns - random(3 * kMs),
                                    read.ns + random(5 * kMs),
                                    random(2) * read.ns,
                                    read.ns - 10 * kHour,
                                    std::numeric_limits<std::int64_t>::max() - random(9),
                                    std::numeric_limits<std::int64_t>::min() + random(9)};
      const std::int64_t event = kinds[static_cast<std::size_t>(random(6))];
      wrong += event > read.ns || event < read.ns - 1'000'000'000;
      times.changed(RealTime{event}, read);
      ++said;
    }
    const RealTime taken = times.taken(read);
    REQUIRE(taken <= read);
    REQUIRE(taken >= read - Duration{1'000'000'000});
    REQUIRE(taken >= last);
    last = taken;
  }
  CHECK(times.ages().ages.count() == said);
  CHECK(times.ages().ahead + times.ages().capped >= wrong);
}

TEST_CASE("evdev: a sample has the time of its event, and one that comes after the tick's time is the next tick's") {
  TimedNode node;
  EvdevDriver driver(node, timed());
  const auto read = [&](double at, std::vector<EvdevEvent> events) {
    node.events = std::move(events);
    return driver.read(ms(at));
  };
  std::vector<EvdevEvent> two = position(10, ms(10.2));
  for (const EvdevEvent& event : position(11, ms(10.9))) two.push_back(event);
  DeviceSample sample = read(11, two);
  CHECK((sample.fresh && sample.taken_at == ms(10.9) && sample.read_at == ms(11)));
  CHECK(sample.position_m.x == Approx(0.011));

  std::vector<EvdevEvent> late = position(12, ms(11.5));
  for (const EvdevEvent& event : position(13, ms(12.01))) late.push_back(event);
  sample = read(12, late);
  CHECK((sample.fresh && sample.taken_at == ms(11.5)));
  CHECK(sample.position_m.x == Approx(0.012));
  sample = read(13, {});
  CHECK((sample.fresh && sample.taken_at == ms(12.01)));
  CHECK(sample.position_m.x == Approx(0.013));
  CHECK(driver.ages()->ahead == 0);

  // An event with a time in the future waits for one tick and then counts as taken when it was read.
  sample = read(14, position(14, RealTime{kHour}));
  CHECK((!sample.fresh && sample.taken_at == ms(12.01)));
  sample = read(15, {});
  CHECK((sample.fresh && sample.taken_at == ms(15) && sample.position_m.x == Approx(0.014)));
  CHECK(driver.ages()->ahead == 1);
}

TEST_CASE("evdev: between two events nothing is new, and a hand that holds still is as old as its unchanged age") {
  TimedNode node;
  EvdevDriver driver(node, timed());
  CHECK(driver.read(ms(1)).taken_at == ms(-1));  // start() has asked where the axes are
  node.events = position(10, ms(9.6));
  CHECK(driver.read(ms(10)).taken_at == ms(9.6));
  DeviceSample sample = driver.read(ms(11));
  CHECK((!sample.fresh && sample.taken_at == ms(9.6)));
  for (int tick = 12; tick <= 1000; ++tick) {
    sample = driver.read(ms(tick));
    REQUIRE((sample.fresh && sample.taken_at == ms(tick - 2)));
  }
  sample = driver.read(ms(1011));  // `still` has passed
  CHECK((!sample.fresh && sample.taken_at == ms(998)));
  CHECK(driver.ages()->ages.count() == 1);
  node.events = position(11, ms(1011.5));
  CHECK(driver.read(ms(1012)).taken_at == ms(1011.5));
}

TEST_CASE(
    "evdev: a position that is asked for after lost events has the time of the report that ends the loss, or later none") {
  TimedNode node;
  EvdevDriver driver(node, timed());
  node.events = position(10, ms(9.6));
  driver.read(ms(10));
  node.x = 50;
  node.events = {kDropped, {evdev::kAbs, 0, 40, ms(20)}, {evdev::kSyn, evdev::kSynReport, 0, ms(20.5)}};
  const DeviceSample sample = driver.read(ms(21));
  CHECK((sample.fresh && sample.taken_at == ms(20.5) && sample.position_m.x == Approx(0.05)));

  // A node that cannot be asked at once is asked in the next tick. The answer then is as old as an unchanged position.
  node.x = 60;
  node.is_busy = true;
  node.events = {kDropped, {evdev::kSyn, evdev::kSynReport, 0, ms(30.5)}};
  const DeviceSample busy = driver.read(ms(31));
  CHECK((!busy.fresh && busy.taken_at == ms(20.5) && busy.position_m.x == Approx(0.05)));
  node.is_busy = false;
  const DeviceSample asked = driver.read(ms(40));
  CHECK((asked.fresh && asked.taken_at == ms(38) && asked.position_m.x == Approx(0.06)));
}

TEST_CASE("evdev: where the kernel refuses to tell times, or they are not asked for, a sample has none") {
  TimedNode node;
  node.tells = false;
  EvdevDriver refused(node, timed());
  node.events = position(10, ms(0.5));
  const DeviceSample sample = refused.read(ms(1));
  CHECK((sample.fresh && !sample.taken_at && sample.time() == ms(1)));
  CHECK(refused.ages() == nullptr);
  CHECK(refused.own_counters().at("evdev_untimed") == 1);

  EvdevOptions arrival = timed();
  arrival.unchanged_age.reset();
  EvdevDriver plain(node, arrival);
  CHECK_FALSE(plain.read(ms(2)).taken_at);
  CHECK(plain.own_counters().at("evdev_untimed") == 0);
  arrival.unchanged_age = Duration{0};
  CHECK_FALSE(device_error_of([&] { EvdevDriver none(node, arrival); }).empty());
}

TEST_CASE("live evdev: times of events are by the clock of the run, from CLOCK_MONOTONIC, by which the node has them") {
  const WallClock clock(WallEpoch{5'000 * kMs});
  auto scripted = std::make_unique<TimedNode>();
  TimedNode& node = *scripted;
  LiveEvdev live(
      std::move(scripted), [] { return EvdevNodes(); }, clock);
  CHECK(live.tells_times());
  node.tells = false;
  CHECK_FALSE(live.tells_times());
  node.tells = true;
  EvdevDriver driver(live, timed());
  node.change([&] { node.events = position(10, ms(5'010.25)); });
  const DeviceSample sample = driver.read(ms(11));
  CHECK((sample.fresh && sample.taken_at == ms(10.25)));
  // The earliest and the latest time stay as they are.
  using Limits = std::numeric_limits<std::int64_t>;
  CHECK(clock.at(Limits::min()).ns == Limits::min());
  CHECK(WallClock(WallEpoch{-1}).at(Limits::max()).ns == Limits::max());
}

TEST_CASE("evdev: a simulated device stamps an event with its report's tick, however late the event is") {
  SimulatedEvdevOptions options;
  options.fuzz = 0;
  options.reports.rate = {3000, 1};  // its ticks are not at whole microseconds
  options.reports.age = [](std::int64_t tick) { return Duration{tick % 7 * 300'000}; };
  VirtualClock clock;
  SimulatedEvdev device(clock, ProgrammedMotion{ConstantVelocity{{0.1, 0, 0}}, RealTime{}}, options);
  std::vector<EvdevEvent> events(64);
  std::int64_t tick = 0, late = 0;
  for (int read = 1; read <= 200; ++read) {
    clock.wait_until(ms(read));
    const std::size_t count = device.read(events).count;
    for (std::size_t i = 0; i < count; ++i) {
      if (events[i].type != evdev::kSyn) continue;
      // The first report has no events, because the axis is at 0 already.
      const RealTime at = tick_time(options.reports.rate, ++tick, RealTime{});
      CHECK(events[i].at.ns == at.ns / 1000 * 1000);
      CHECK(events[i - 1].at == events[i].at);
      late += ms(read) - at > Duration{kMs};
    }
  }
  CHECK(tick > 550);
  CHECK(late > 50);
}
