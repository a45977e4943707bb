// Devices that the program registers, simulated and real.
#include <atomic>
#include <cmath>

#include "support.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;

namespace {

std::vector<std::string> arm(const std::string& name, std::vector<std::string> more = {}) {
  std::vector<std::string> set{"device.left.driver=\"foreign\"",
                               fmt::format("device.left.foreign={{ name = \"{}\" }}", name)};
  set.insert(set.end(), more.begin(), more.end());
  return set;
}

Registry with_device(const DeviceFactory& make) {
  Registry mine = registry();
  mine.add_device("mine", make);
  return mine;
}

/// A device whose functions the test provides.
struct ToldArm : MyArm {
  explicit ToldArm(SimulatedGrip& grip) : MyArm(grip) {}
  DeviceSample read(RealTime now) override {
    DeviceSample sample = MyArm::read(now);
    if (at_read) at_read(now, sample);
    return sample;
  }
  void write(const glm::dvec3& force_N) override {
    if (at_write) at_write(force_N);
    MyArm::write(force_N);
  }
  void stop() noexcept override {
    if (stops) MyArm::stop();
  }
  std::function<void(RealTime, DeviceSample&)> at_read;
  std::function<void(const glm::dvec3&)> at_write;
  bool stops = true;
};

}  // namespace

TEST_CASE("A simulated device of the program's feels and drives as the reference device, without its rounding") {
  const RunRecord own = record({}), mine = record(arm("my-arm"));
  for (const StrategyRecord& one : own.strategies) {
    INFO(one.name);
    const auto &theirs = one.devices[0].ticks, &ours = strategy(mine, one.name).devices[0].ticks;
    REQUIRE(theirs.size() == ours.size());
    for (std::size_t k = 0; k < ours.size(); ++k) {
      REQUIRE(std::abs(ours[k].position_m[0] - theirs[k].position_m[0]) <= 0.5e-9);  // a report counts nanometres
      REQUIRE(std::abs(ours[k].force_N[0] - theirs[k].force_N[0]) < 1e-6);  // 200 N/m of 1 nm, and extrapolated lines
    }
    CHECK(strategy(mine, one.name).devices[0].counters.at("motors_left") == 0);
    CHECK(strategy(mine, one.name).devices[0].counters.at("motors_max") > 1);
  }
}

TEST_CASE("A hand on a device of the program's feels its force, after the delay of the scenario") {
  const std::string path = R"({ kind = "sine", amplitude = ["2 cm", "0 m", "0 m"], frequency = "1 Hz" })";
  const std::vector<std::string> hand{
      R"(device.left.motion={ kind = "hand", mass = "0.2 kg", damping = "2 N s/m", stiffness = "50 N/m", path = )" + path +
          " }",
      "device.left.delay=\"3 ms\"", R"(run.strategies=["phase_locked"])"};
  const RunRecord own = record(hand), mine = record(arm("my-arm", hand));
  const auto &theirs = own.strategies[0].devices[0].ticks, &ours = mine.strategies[0].devices[0].ticks;
  for (std::size_t k = 0; k < ours.size(); ++k) REQUIRE(std::abs(ours[k].position_m[0] - theirs[k].position_m[0]) < 1e-7);
  // The hand is held back, so it does not follow its path of 2 cm.
  double farthest = 0;
  for (const TickRow& tick : ours) farthest = std::max(farthest, tick.position_m[0]);
  CHECK(farthest < 0.015);
}

TEST_CASE("The guard clamps, slews and cuts before a device of the program's is written to") {
  double most_N = 0, most_change_N = 0;
  glm::dvec3 last{0};
  const Registry mine = with_device([&](const DeviceRequest& request) {
    auto told = std::make_unique<ToldArm>(*request.grip);
    told->at_write = [&](const glm::dvec3& force_N) {
      most_N = std::max(most_N, std::abs(force_N.x));
      most_change_N = std::max(most_change_N, std::abs(force_N.x - last.x));
      last = force_N;
    };
    return told;
  });
  const RunRecord run =
      record(arm("mine", {"device.left.force_limit=\"2 N\"", "device.left.slew_limit=\"50 N/s\"",
                          "device.left.guard={ speed_limit = \"0.05 m/s\" }", R"(run.strategies=["phase_locked"])"}),
             mine);
  CHECK(most_N > 0);
  CHECK(most_N <= 2);
  CHECK(most_change_N <= 50e-3 * (1 + 1e-9));
  CHECK(run.strategies[0].devices[0].counters.at("cuts_speed") >= 1);
  CHECK(run.strategies[0].devices[0].counters.at("motors_max") == Approx(most_N));
}

TEST_CASE("A device of the program's that still drives when it was stopped fails the run") {
  const RunOutcome outcome = run(arm("mine"), with_device([](const DeviceRequest& request) {
                                   auto told = std::make_unique<ToldArm>(*request.grip);
                                   told->stops = false;
                                   return told;
                                 }));
  CHECK(outcome.exit == ExitCode::run_failed);
  CHECK_THAT(outcome.failure, Contains("left: the device still drives after its driver has stopped"));
}

TEST_CASE("A device of the program's that fails stops the run with its name, and is stopped") {
  const auto failure = [](const std::function<void(RealTime, DeviceSample&)>& at_read) {
    const RunOutcome outcome = run(arm("mine"), with_device([&](const DeviceRequest& request) {
                                     auto told = std::make_unique<ToldArm>(*request.grip);
                                     told->at_read = at_read;
                                     return told;
                                   }));
    CHECK(outcome.exit == ExitCode::run_failed);
    return outcome.failure;
  };
  CHECK_THAT(failure([](RealTime now, DeviceSample&) {
               if (now > RealTime{300'000'000}) throw std::runtime_error("cable gone");
             }),
             Contains("left: the driver 'mine': cable gone"));
  CHECK_THAT(failure([](RealTime, DeviceSample& sample) { sample.position_m.y = std::nan(""); }),
             Contains("left: the driver 'mine': gave a position that is not finite at 0 ns"));
  const RunOutcome none = run(arm("mine"), with_device([](const DeviceRequest&) { return nullptr; }));
  CHECK_THAT(none.failure, Contains("left: the driver 'mine': cannot be made: its factory returned nothing"));
}

TEST_CASE("A run with --repeat names a device that is not reproducible") {
  RunOptions twice;
  twice.repeat = true;
  std::atomic<int> made{0};
  const RunOutcome outcome = run(arm("mine"), with_device([&](const DeviceRequest& request) {
                                   auto told = std::make_unique<ToldArm>(*request.grip);
                                   told->at_read = [which = made++](RealTime now, DeviceSample& sample) {
                                     if (now == RealTime{200'000'000}) sample.position_m.x += 1e-9 * which;
                                   };
                                   return told;
                                 }),
                                 twice);
  CHECK(outcome.exit == ExitCode::not_reproducible);
  CHECK_THAT(outcome.repeat_difference, Contains("the driver 'mine' of \"left\" gave another position at tick 200"));
  CHECK(run(arm("my-arm"), registry(), twice).exit == ExitCode::pass);
}

TEST_CASE("On the wall clock a device of the program's runs simulated, and the run replays") {
  RunOptions wall;
  wall.clock = ClockKind::wall;
  const RunRecord run =
      record(arm("my-arm", {"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "run.duration=\"0.4 s\""}), registry(), wall);
  CHECK(strategy(run, "phase_locked").devices[0].counters.at("motors_left") == 0);
  CHECK(strategy(run, "phase_locked").steps.size() > 100);
}

TEST_CASE(
    "The option --device hands the path to a device of the program's, which is driven only with --forces, and gently") {
  struct Real : HapticDevice {
    Real(std::atomic<int>& w, std::atomic<int>& s, double& most) : writes(w), stopped(s), most_N(most) {}
    DeviceSample read(RealTime now) override {
      return {.position_m = {std::sin(5 * seconds(now)) * 0.05, 0, 0}, .fresh = true};
    }
    void write(const glm::dvec3& force_N) override {
      ++writes;
      most_N = std::max(most_N, std::abs(force_N.x));
    }
    void stop() noexcept override { ++stopped; }
    std::atomic<int>&writes, &stopped;
    double& most_N;
  };
  for (const bool forces : {false, true}) {
    std::atomic<int> writes{0}, stopped{0};
    double most_N = 0;
    RunOptions wall;
    wall.clock = ClockKind::wall;
    wall.devices = {{{"left", "my-port"}}, forces};
    const Registry mine = with_device([&](const DeviceRequest& request) {
      CHECK(request.path == "my-port");
      CHECK(request.device == "left");
      CHECK(request.grip == nullptr);
      return std::make_unique<Real>(writes, stopped, most_N);
    });
    record(arm("mine", {"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "run.duration=\"0.4 s\"",
                        R"(run.strategies=["phase_locked"])"}),
           mine, wall);
    CHECK((writes > 0) == forces);
    CHECK(stopped >= (forces ? 1 : 0));
    CHECK(most_N <= 3);  // kLiveLimits
  }
}

TEST_CASE("Keys about reports on a cable are refused for a device of the program's") {
  CHECK_THAT(errors_of(arm("my-arm", {"device.left.queue=\"libusb\""}), registry()),
             Contains("'queue' is about reports on a cable"));
  CHECK_THAT(errors_of(arm("my-arm", {"device.left.faults=[{ kind = \"lost\", at = \"1 s\" }]"}), registry()),
             Contains("'faults' is about reports on a cable"));
}
