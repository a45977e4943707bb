// How long the motors keep a force that nobody wants any more, whatever happens to the reports that should change it.
#include <cmath>

#include "catch.h"
#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_board.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "pid/pid_bench.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;
using Kind = ReportFault::Kind;

namespace {

constexpr std::int64_t kChange = 600;  // the time in ms at which the force rises or is released

/// A device of any kind and its driver, both made by `make`.
struct StaleForceBench {
  VirtualClock clock;
  std::unique_ptr<SimulatedDevice> device;
  std::unique_ptr<HapticDevice> driver;
};

ProgrammedMotion still() { return {Still{}, RealTime{}}; }

PidOptions x_alone() {
  PidOptions options = pid_options();
  options.travel_m.y = 0;
  options.gain = 1;
  return options;
}

void drive(StaleForceBench& bench, const PidOptions& options) {
  bench.driver = std::make_unique<PidDriver>(*bench.device, layout_of(*bench.device), options);
  bench.driver->start();
}

/// A bench for every kind of simulated device.
std::vector<std::pair<std::string, std::unique_ptr<StaleForceBench>>> benches(const std::vector<ReportFault>& faults,
                                                                              std::optional<Duration> effect_duration) {
  std::vector<std::pair<std::string, std::unique_ptr<StaleForceBench>>> all;
  PidOptions options = x_alone();
  options.effect_duration = effect_duration;
  for (const PidFlavour flavour : kFlavours) {
    auto bench = std::make_unique<StaleForceBench>();
    SimulatedPidOptions device = pid_device(flavour);
    device.reports.faults = faults;
    bench->device = std::make_unique<SimulatedPidDevice>(bench->clock, still(), device);
    drive(*bench, options);
    all.emplace_back(flavour == PidFlavour::mask ? "mask" : "array", std::move(bench));
  }
  for (const auto& [name, kind] : simulated_boards()) {
    const bool is_refused = kind == BoardKind::load_error_first || kind == BoardKind::load_never;
    if (is_refused || (kind == BoardKind::no_duration && effect_duration)) continue;
    auto bench = std::make_unique<StaleForceBench>();
    SimulatedBoardOptions board;
    board.kind = kind;
    board.travel_m = options.travel_m;
    board.reports.faults = faults;
    bench->device = std::make_unique<SimulatedBoard>(bench->clock, still(), board);
    PidOptions own = options;
    own.reversed_force[0] = kind == BoardKind::arduino;
    drive(*bench, own);
    all.emplace_back(std::string(name), std::move(bench));
  }
  auto bench = std::make_unique<StaleForceBench>();
  bench->device = std::make_unique<SimulatedTransport>(bench->clock, still(), SimulatedDeviceOptions{.faults = faults});
  bench->driver = std::make_unique<ReferenceDriver>(*bench->device);
  all.emplace_back("reference", std::move(bench));
  return all;
}

/// The number of ticks after the change until the motors do what is wanted and stay so.
std::int64_t ticks_until_right(StaleForceBench& bench, double before_N, double after_N, std::int64_t ticks = 1000) {
  std::int64_t right = -1;
  for (std::int64_t k = 0; k < kChange + ticks; ++k) {
    bench.clock.wait_until(RealTime{k * kMs});
    bench.driver->read(bench.clock.now());
    const double wanted_N = k < kChange ? before_N : after_N;
    bench.driver->write({wanted_N, 0, 0});
    const bool is_right = std::abs(bench.device->motors().force_N.x - wanted_N) < 5e-3;
    if (k < kChange) REQUIRE(is_right);
    if (k >= kChange && is_right && right < 0) right = k - kChange;
    if (k >= kChange && !is_right) right = -1;
  }
  return right;
}

}  // namespace

TEST_CASE(
    "a force whose report is refused at once or later is there a tick after reports are taken again, rise and release") {
  for (const Kind kind : {Kind::write_rejected, Kind::write_refused}) {
    for (const std::int64_t refused : {1, 2, 5, 40}) {
      for (const auto duration : {std::optional(Duration{500 * kMs}), std::optional<Duration>()}) {
        for (const bool release : {false, true}) {
          for (auto& [name, bench] : benches({{kind, kChange, refused}}, duration)) {
            INFO(name << " kind " << static_cast<int>(kind) << " refused " << refused << " release " << release);
            const std::int64_t ticks = ticks_until_right(*bench, release ? 3 : 0, release ? 0 : 3);
            // Each tick sends at least one report, the force. If a later report was refused, the next tick knows it.
            CHECK((ticks >= 0 && ticks <= refused));
            CHECK(bench->driver->counters().write_failures == refused);
          }
        }
      }
    }
  }
}

TEST_CASE("a force whose report is lost on the way is there after half of the effect's duration, without one after 250 ms") {
  for (const auto duration :
       {std::optional(Duration{200 * kMs}), std::optional(Duration{500 * kMs}), std::optional<Duration>()}) {
    for (const bool release : {false, true}) {
      for (auto& [name, bench] : benches({{Kind::write_lost, kChange, 1}}, duration)) {
        INFO(name << " duration " << duration.value_or(Duration{}).ns << " release " << release);
        const std::int64_t ticks = ticks_until_right(*bench, release ? 3 : 0, release ? 0 : 3);
        CHECK((ticks >= 0 && ticks <= duration.value_or(Duration{500 * kMs}).ns / 2 / kMs));
      }
    }
  }
}

TEST_CASE("a device that refuses everything is given up after the effect's duration, when its force has ended by itself") {
  for (const Kind kind : {Kind::write_rejected, Kind::write_refused}) {
    for (const auto duration : {std::optional(Duration{300 * kMs}), std::optional<Duration>()}) {
      for (auto& [name, bench] : benches({{kind, kChange, 1'000'000}}, duration)) {
        if (name == "reference") continue;  // it has no effects that could end, and is sent a force in every tick
        INFO(name);
        const std::int64_t patience_ms = duration.value_or(Duration{500 * kMs}).ns / kMs;
        std::int64_t k = 0;
        try {
          for (; k < kChange + 2000; ++k) {
            bench->clock.wait_until(RealTime{k * kMs});
            bench->driver->read(bench->clock.now());
            bench->driver->write({k < kChange ? 3.0 : 0.0, 0, 0});
          }
          FAIL("went on");
        } catch (const DeviceError& error) {
          CHECK_THAT(error.what(), Contains("has refused reports for") && Contains("switch it off"));
        }
        CHECK(k - kChange <= patience_ms + 2);
        if (duration) CHECK(bench->device->motors().force_N == glm::dvec3(0));
      }
    }
  }
}

TEST_CASE("a request of start that is refused later is tried again, and one that stays refused is an error that names it") {
  for (std::int64_t refused = 1; refused <= 3; ++refused) {
    VirtualClock clock;
    SimulatedPidOptions options = pid_device(PidFlavour::mask);
    options.reports.faults = {{Kind::write_refused, 0, refused}};
    SimulatedPidDevice device(clock, still(), options);
    PidDriver driver(device, layout_of(device), pid_options());
    if (refused == 3) {
      CHECK_THROWS_WITH(driver.start(), Contains("refuses Device Reset"));
      continue;
    }
    driver.start();
    CHECK(device.playing() == 2);
  }
}

TEST_CASE("a stop that is refused later is sent again") {
  for (std::int64_t refused = 1; refused <= 2; ++refused) {
    for (auto& [name, bench] : benches({{Kind::write_refused, 50, refused}}, Duration{500 * kMs})) {
      INFO(name);
      for (std::int64_t k = 0; k <= 50; ++k) {
        bench->clock.wait_until(RealTime{k * kMs});
        bench->driver->read(bench->clock.now());
        if (k < 50) bench->driver->write({3, 0, 0});
      }
      bench->driver->stop();
      const MotorState motors = bench->device->motors();
      CHECK((motors.force_N == glm::dvec3(0) && motors.effects_playing == 0 && motors.effects_allocated == 0));
    }
  }
}
