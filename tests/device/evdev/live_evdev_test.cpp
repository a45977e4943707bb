// Uploads by their own thread, and a device that is unplugged and comes back. The node is scripted and the thread is real.
// The driver's times are made up.

#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "catch.h"
#include "evdev_bench.h"
#include "evenstep/device/evdev/live_evdev.h"
#include "evenstep/device/force_guard.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

const WallClock& wall() {
  static const WallClock clock(WallEpoch::in(Duration{0}));
  return clock;
}

template <class Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 20'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// A node that LiveEvdev owns. It passes every call on to a node that the test keeps.
struct Passed final : EvdevNode {
  explicit Passed(ScriptedNode& to) : node(to) {}
  EvdevRead read(std::span<EvdevEvent> events) override { return node.read(events); }
  int write(const EvdevEvent& event) override { return node.write(event); }
  int upload(EvdevEffect& effect) override { return node.upload(effect); }
  int erase(int id) override { return node.erase(id); }
  int grab() override { return node.grab(); }
  int effect_count(int& count) override { return node.effect_count(count); }
  bool has_axis(std::uint16_t code) override { return node.has_axis(code); }
  bool has_feedback(std::uint16_t code) override { return node.has_feedback(code); }
  int axis(std::uint16_t code, EvdevAxis& axis) override { return node.axis(code, axis); }
  int set_axis(std::uint16_t code, const EvdevAxis& axis) override { return node.set_axis(code, axis); }
  const EvdevInfo& info() const override { return node.info(); }
  ScriptedNode& node;
};

struct LiveBench {
  explicit LiveBench(
      std::function<EvdevNodes()> find = [] { return EvdevNodes(); }, Duration patience = {})
      : live(std::make_unique<Passed>(node), std::move(find), wall(), patience), driver(live, options()) {
    driver.start();
  }
  static EvdevOptions options() {
    EvdevOptions options = evdev_options();
    options.travel_m.y = 0;
    return options;
  }
  DeviceSample tick(double force_N) {
    now = now + Duration{1'000'000};
    const DeviceSample sample = driver.read(now);
    driver.write({force_N, 0, 0});
    return sample;
  }
  int level() {
    return node.look([&] { return node.effects.empty() ? 0 : node.effects.begin()->second.level; });
  }
  bool renders(double force_N) { return std::abs(level() + force_N / 10 * 0x7FFF) < 2; }

  ScriptedNode node;
  RealTime now;
  LiveEvdev live;
  EvdevDriver driver;
};

EvdevNodes one(ScriptedNode& node) {
  EvdevNodes nodes;
  nodes.push_back(std::make_unique<Passed>(node));
  return nodes;
}

}  // namespace

TEST_CASE(
    "live evdev: ticks do not wait for an upload that takes long, and the newest force takes the place of older ones") {
  LiveBench bench;
  bench.node.change([&] { bench.node.is_slow = true; });
  for (int tick = 0; tick < 3; ++tick) bench.tick(0.5);
  bench.node.wait_for_upload(2);  // the one of start() was the first
  for (int tick = 1; tick <= 100; ++tick) bench.tick(0.01 * tick);
  CHECK(bench.node.look([&] { return bench.node.uploading; }) == 2);
  bench.node.change([&] { bench.node.is_slow = false; });
  CHECK(eventually([&] { return bench.renders(1); }));
  CHECK(bench.node.look([&] { return bench.node.uploads.size(); }) == 3);
  CHECK(bench.live.write_times().overtaken >= 99);
  CHECK(bench.driver.counters().write_failures == 0);
}

TEST_CASE("live evdev: an upload that is refused after its tick is counted and repeated, and for ever ends the run") {
  LiveBench bench;
  bench.node.change([&] { bench.node.refuses_with = EIO; });
  for (int tick = 0; tick < 3; ++tick) bench.tick(1);
  CHECK(eventually([&] { return bench.live.write_times().rejected > 0; }));
  bench.tick(1);
  CHECK(bench.driver.counters().write_failures > 0);
  bench.node.change([&] { bench.node.refuses_with = 0; });
  CHECK(eventually([&] { return bench.tick(1), bench.renders(1); }));

  bench.node.change([&] { bench.node.refuses_with = EIO; });
  std::string error;
  for (int tick = 0; tick < 20'000 && error.empty(); ++tick) {
    error = device_error_of([&] { bench.tick(2 + 1e-3 * (tick % 1000)); });
    if (tick % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  CHECK_THAT(error, Contains("has refused an effect for 500 ms"));
}

TEST_CASE("live evdev: where the hand is after lost events is asked when no upload is under way, and not before") {
  LiveBench bench;
  bench.tick(0);
  bench.node.change([&] { bench.node.is_slow = true; });
  for (int tick = 0; tick < 3; ++tick) bench.tick(0.5);
  bench.node.wait_for_upload(2);
  bench.node.change([&] {
    bench.node.events = {{evdev::kSyn, evdev::kSynDropped, 0}, {evdev::kSyn, evdev::kSynReport, 0}};
    bench.node.x = 50;
  });
  const std::int64_t before = bench.driver.counters().reports;
  for (int tick = 0; tick < 10; ++tick) CHECK(bench.tick(0.5).position_m.x == 0);
  CHECK(bench.driver.counters().reports == before);
  bench.node.change([&] { bench.node.is_slow = false; });
  CHECK(eventually([&] { return bench.tick(0.5).position_m.x == Approx(0.1); }));
  CHECK(bench.driver.counters().reports == before + 1);
}

TEST_CASE("live evdev: a device that was unplugged and is back has its effects anew and its forces rise from zero") {
  ScriptedNode others, back;
  others.is_held = true;
  back.first_id = 7;
  back.x = 25;
  back.refuses_with = ENOSYS;  // as long as its force feedback is not there
  LiveBench bench(
      [&] {
        EvdevNodes nodes = one(others);
        nodes.push_back(std::make_unique<Passed>(back));
        return nodes;
      },
      Duration{10'000'000'000});
  ForceLimits limits;
  limits.cut.ramp_up = Duration{100'000'000};
  limits.cut.ramp_down = Duration{10'000'000};
  limits.cut.stale_force = Duration{1'000'000'000'000};
  ForceGuard guard(limits);
  const auto guarded = [&] {
    const DeviceSample sample = bench.driver.read(bench.now);
    const glm::dvec3 passed_N = guard.pass(bench.now, {2, 0, 0}, {sample, bench.now});
    bench.driver.write(passed_N);
    bench.now = bench.now + Duration{1'000'000};
    return std::pair(sample, passed_N.x);
  };
  for (int tick = 0; tick < 150; ++tick) guarded();
  CHECK(guarded().second == Approx(2));
  bench.node.change([&] { bench.node.gone = true; });
  for (int tick = 0; tick < 50; ++tick) {
    const auto [sample, force_N] = guarded();
    CHECK_FALSE(sample.drivable);
    CHECK_FALSE(sample.fresh);
    if (tick >= 12) CHECK(force_N == 0);
  }
  CHECK(bench.live.times_unplugged() == 1);
  back.change([&] { back.refuses_with = 0; });
  REQUIRE(eventually([&] { return guarded().first.fresh; }));
  CHECK(guarded().first.position_m.x == Approx(0.05));
  double last_N = 0;
  for (int tick = 0; tick < 120; ++tick) {
    const auto [sample, force_N] = guarded();
    CHECK(sample.drivable);
    CHECK(force_N - last_N <= 2.0 / 100 * 3.001);
    last_N = force_N;
  }
  CHECK(last_N == Approx(2));
  CHECK(eventually([&] { return guarded(), std::abs(back.look([&] { return back.effects[7].level; }) + 6553) <= 1; }));
  CHECK(back.look([&] { return back.uploads.front().level; }) == 0);
  CHECK(back.look([&] { return back.written[7]; }) == 1);
  CHECK(back.look([&] { return back.written[evdev::kGain]; }) == evdev::kFullGain);
  bench.driver.stop();
  CHECK(back.look([&] { return back.effects.empty() && back.written[7] == 0; }));
  CHECK(others.look([&] { return others.uploads.empty(); }));
}

TEST_CASE("live evdev: a device that does not come back in time, or need not, ends the run") {
  for (const std::int64_t patience_ns : {0, 1}) {
    LiveBench bench([] { return EvdevNodes(); }, Duration{patience_ns});
    bench.tick(1);
    bench.node.change([&] { bench.node.gone = true; });
    std::string error;
    CHECK(eventually([&] { return !(error = device_error_of([&] { bench.tick(1); })).empty(); }));
    CHECK_THAT(error, Contains("device 'a node' is gone"));
    bench.driver.stop();
  }
}
