// A device that was unplugged and has come back: what its driver says of it, and what it makes it do, is what a driver
// says and does that was started on it when it came back. Property: random lives before that, and random reports after it.

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "cases.h"
#include "catch.h"
#include "evdev/evdev_bench.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/device/evdev/simulated_evdev.h"
#include "evenstep/device/inverse3/inverse3_driver.h"
#include "evenstep/device/inverse3/simulated_inverse3.h"
#include "evenstep/device/looked_for.h"
#include "pid/pid_bench.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::int64_t kAfter = 300;  // ms that are compared

/// A life: when the device goes and is found again, where the hand is, which reports fail and what force is wanted.
struct DeviceLife {
  explicit DeviceLife(std::uint64_t seed) : random(seed) {
    unplug = between(50, 400);
    returns = unplug + between(1, 700);
    found = found_again(RealTime{unplug * kMs}, RealTime{returns * kMs})->ns / kMs;
    motion = between(0, 2) == 0 ? Motion{Still{}} : Motion{ConstantVelocity{{0.0001 * between(-500, 500), 0.03, 0.01}}};
    for (std::int64_t n = between(0, 5); n > 0; --n)
      before.push_back({ReportFault::Kind(between(0, 10)), between(1, unplug + 200), between(1, 3)});
    for (std::int64_t tick = 0, lost = between(0, 60); tick < lost; ++tick)
      after.push_back({ReportFault::Kind::lost, tick, 1});
    for (std::int64_t ms = 0; ms <= found + kAfter; ++ms) {
      const bool kept = !forces_N.empty() && between(0, 3) > 0;
      forces_N.push_back(kept ? forces_N.back() : glm::dvec3{0.001 * between(-2400, 2400), 0.001 * between(-2400, 2400), 0});
    }
  }
  std::int64_t between(std::int64_t least, std::int64_t most) {
    return least + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most - least + 1));
  }
  /// Of the device that goes and comes back, or of one that is plugged in then.
  SimulatedDeviceOptions device(bool is_new) const {
    SimulatedDeviceOptions options;
    std::vector<ReportFault> faults = after;
    if (is_new) {
      options.first_tick = RealTime{found * kMs};
    } else {
      options.unplug_at_tick = unplug;
      options.return_at_tick = returns;
      for (ReportFault& fault : faults) fault.tick += found;
      for (const ReportFault& fault : before)
        if (fault.tick < found) faults.push_back(fault);
      std::sort(faults.begin(), faults.end(), [](const auto& a, const auto& b) { return a.tick < b.tick; });
    }
    options.faults = faults;
    return options;
  }
  HeldBy hand() const { return ProgrammedMotion{motion, RealTime{}}; }

  std::mt19937_64 random;
  std::int64_t unplug = 0, returns = 0, found = 0;  // ms
  Motion motion;
  std::vector<ReportFault> before, after;
  std::vector<glm::dvec3> forces_N;  // of each ms
};

struct AfterReturn {
  DeviceSample sample;
  DeviceCounters counters;
  glm::dvec3 force_N;
};

/// Ticks of 1 ms from the clock's now to the end of the life; what is seen after the device was found. Nothing is wanted
/// while it is away.
std::vector<AfterReturn> lived(const DeviceLife& life, VirtualClock& clock, HapticDevice& driver, SimulatedMotors& motors) {
  std::vector<AfterReturn> out;
  for (std::int64_t ms = clock.now().ns / kMs; ms <= life.found + kAfter; ++ms) {
    clock.wait_until(RealTime{ms * kMs});
    const DeviceSample sample = driver.read(clock.now());
    driver.write(sample.away || ms == life.found ? glm::dvec3(0) : life.forces_N[static_cast<std::size_t>(ms)]);
    if (ms > life.found) out.push_back({sample, driver.counters(), motors.motors().force_N});
  }
  return out;
}

/// `driven`: false if the one that has come back is to render nothing.
void check_equal(const std::vector<AfterReturn>& old, const std::vector<AfterReturn>& fresh, bool driven = true) {
  REQUIRE(old.size() == fresh.size());
  bool known = false;  // its position
  for (std::size_t n = 0; n < old.size(); ++n) {
    INFO(n + 1 << " ms after it was found");
    const DeviceSample &a = old[n].sample, &b = fresh[n].sample;
    REQUIRE_FALSE(a.away);
    REQUIRE(a.fresh == b.fresh);
    REQUIRE(a.drivable == (driven && b.drivable));
    REQUIRE(a.at_range == b.at_range);
    known = known || b.fresh;
    REQUIRE((!known || a.position_m == b.position_m));
    REQUIRE(a.sequence - old[0].sample.sequence == b.sequence - fresh[0].sample.sequence);
    REQUIRE(old[n].counters.reports - old[0].counters.reports == fresh[n].counters.reports - fresh[0].counters.reports);
    REQUIRE(old[n].counters.stale - old[0].counters.stale == fresh[n].counters.stale - fresh[0].counters.stale);
    REQUIRE(old[n].counters.lost - old[0].counters.lost == fresh[n].counters.lost - fresh[0].counters.lost);
    const glm::dvec3 expected_N = driven ? fresh[n].force_N : glm::dvec3(0);
    REQUIRE(glm::length(old[n].force_N - expected_N) < 1e-3);  // evdev: a count of the level
  }
}

}  // namespace

TEST_CASE("evdev: a device that has come back is read and driven as by a driver that was started then, 300 random lives") {
  std::int64_t unknown = 0;
  for (std::uint64_t seed = 1; seed <= evenstep::testing::cases(300); ++seed) {
    DeviceLife life(seed);
    INFO("seed " << seed << ", unplugged at " << life.unplug << " ms, found at " << life.found << " ms");
    SimulatedEvdevOptions device;
    device.minimum = life.between(0, 1) == 0 ? 0 : -32767;
    EvdevOptions options = evdev_options();
    options.update_rate = {life.between(1, 3) == 1 ? life.between(1, 8) : 1000, 1};
    options.effect_duration = Duration{life.between(50, 500) * kMs};
    const auto seen = [&](bool is_new) {
      VirtualClock clock;
      if (is_new) clock.wait_until(RealTime{life.found * kMs});
      device.reports = life.device(is_new);
      SimulatedEvdev node(clock, life.hand(), device);
      EvdevDriver driver(node, options);
      driver.start();
      return lived(life, clock, driver, node);
    };
    const std::vector<AfterReturn> fresh = seen(true);
    unknown += !fresh.front().sample.fresh;
    check_equal(seen(false), fresh);
  }
  CHECK(unknown > 0);
}

TEST_CASE(
    "inverse3: a device that has come back is read and driven as by a driver that was started then, from its first "
    "position on, 100 random lives") {
  std::int64_t compared = 0;
  for (std::uint64_t seed = 1; seed <= evenstep::testing::cases(100); ++seed) {
    DeviceLife life(seed);
    INFO("seed " << seed << ", unplugged at " << life.unplug << " ms, found at " << life.found << " ms");
    const auto seen = [&](bool is_new) {
      VirtualClock clock;
      if (is_new) clock.wait_until(RealTime{life.found * kMs});
      SimulatedInverse3Options device;
      device.reports = life.device(is_new);
      SimulatedInverse3 service(clock, life.hand(), device);
      Inverse3Driver driver(service, Inverse3Options{});
      driver.start();
      std::vector<AfterReturn> out = lived(life, clock, driver, service);
      std::size_t first = 0;
      while (first < out.size() && !out[first].sample.fresh) {
        if (!is_new) CHECK_FALSE(out[first].sample.drivable);
        if (!is_new) CHECK(out[first].force_N == glm::dvec3(0));
        ++first;
      }
      out.erase(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(first));
      return out;
    };
    const std::vector<AfterReturn> fresh = seen(true);
    compared += std::ssize(fresh);
    check_equal(seen(false), fresh);
  }
  CHECK(compared > evenstep::testing::cases(20'000));
}

namespace {

/// The first device until it is unplugged, and another one from when it is found.
class Replugged final : public HidTransport {
 public:
  Replugged(const Clock& clock, HidTransport& first, RealTime unplugged, RealTime found)
      : clock_(clock), now_(&first), unplugged_(unplugged), found_(found) {}
  void plug_in(HidTransport& second) { now_ = &second, returned_ = true; }
  HidRead read(std::span<std::byte> buffer) override {
    if (is_away()) return {HidRead::Status::away};
    if (std::exchange(returned_, false)) return {HidRead::Status::returned};
    return now_->read(buffer);
  }
  HidWrite write(std::span<const std::byte> report) override { return is_away() ? HidWrite::ok : now_->write(report); }
  HidFeature get_feature(std::span<std::byte> report) override { return now_->get_feature(report); }
  HidWrite set_feature(std::span<const std::byte> report) override { return now_->set_feature(report); }
  std::span<const std::byte> report_descriptor() const override { return now_->report_descriptor(); }
  const HidDeviceInfo& info() const override { return now_->info(); }
  std::int64_t refused_later() const override { return 0; }

 private:
  bool is_away() const { return clock_.now() >= unplugged_ && clock_.now() < found_; }
  const Clock& clock_;
  HidTransport* now_;
  RealTime unplugged_, found_;
  bool returned_ = false;
};

}  // namespace

TEST_CASE(
    "PID: a device that has come back is read as by a driver that was started then, and never driven, 300 random lives") {
  for (std::uint64_t seed = 1; seed <= evenstep::testing::cases(300); ++seed) {
    DeviceLife life(seed);
    INFO("seed " << seed << ", unplugged at " << life.unplug << " ms, found at " << life.found << " ms");
    SimulatedPidOptions options = pid_device(kFlavours[seed % 2]);
    const RealTime found{life.found * kMs};
    VirtualClock clock, fresh_clock;
    fresh_clock.wait_until(found);
    options.reports = life.device(true);
    SimulatedPidDevice fresh_device(fresh_clock, life.hand(), options);
    PidDriver fresh(fresh_device, layout_of(fresh_device), pid_options());
    fresh.start();

    SimulatedPidOptions first_options = options;
    first_options.reports = {};
    SimulatedPidDevice first(clock, life.hand(), first_options);
    std::optional<SimulatedPidDevice> second;
    Replugged transport(clock, first, RealTime{life.unplug * kMs}, found);
    PidDriver driver(transport, layout_of(first), pid_options());
    driver.start();
    for (std::int64_t ms = 1; ms < life.found; ++ms) {
      clock.wait_until(RealTime{ms * kMs});
      const DeviceSample sample = driver.read(clock.now());
      driver.write(sample.away ? glm::dvec3(0) : life.forces_N[static_cast<std::size_t>(ms)]);
    }
    clock.wait_until(found);
    transport.plug_in(second.emplace(clock, life.hand(), options));
    check_equal(lived(life, clock, driver, *second), lived(life, fresh_clock, fresh, fresh_device), false);
    CHECK(is_still(second->motors()));
  }
}
