// The driver on boards whose firmware reads the standard in its own way. The tests assert what the motors do.
#include <cmath>
#include <random>

#include "catch.h"
#include "evenstep/device/hid/pid_axes.h"
#include "evenstep/device/hid/simulated_board.h"
#include "pid/pid_bench.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;
using Log = std::vector<std::string>;

namespace {

int axes_of(BoardKind kind) { return motors_of(kind); }

/// Those that start() does not refuse.
std::vector<NamedBoard> drivable_boards() {
  std::vector<NamedBoard> boards;
  for (const NamedBoard& board : simulated_boards()) {
    const bool is_refused = board.kind == BoardKind::load_error_first || board.kind == BoardKind::load_never ||
                            board.kind == BoardKind::load_always_1;
    if (!is_refused) boards.push_back(board);
  }
  return boards;
}

/// 10 N over 0.4 m along each axis that has a motor, with the signs that a user would measure on that board.
PidOptions options_for(BoardKind kind) {
  PidOptions options;
  options.travel_m = {0.4, axes_of(kind) > 1 ? 0.4 : 0, 0};
  options.full_scale_N = 10;
  options.gain = 1;
  if (kind == BoardKind::arduino) options.reversed_force = {true, true, false};
  if (kind == BoardKind::no_duration) options.effect_duration.reset();
  return options;
}

PidOptions with_springs(BoardKind kind) {
  PidOptions options = options_for(kind);
  options.springs = true;
  options.reversed_spring = {false, false, std::nullopt};
  if (kind == BoardKind::pxn) options.reversed_spring = {};  // whoever measures its springs feels nothing
  options.full_slope_N_per_m = glm::dvec3(50);
  return options;
}

struct BoardBench {
  BoardBench(BoardKind kind, const PidOptions& driver_options, Motion motion = Still{}, SimulatedBoardOptions options = {})
      : device(clock, ProgrammedMotion{std::move(motion), RealTime{}}, given(kind, driver_options, options)),
        driver(std::make_unique<PidDriver>(transport, layout_of(device), driver_options)) {}
  static SimulatedBoardOptions given(BoardKind kind, const PidOptions& driver, SimulatedBoardOptions options) {
    options.kind = kind;
    options.travel_m = driver.travel_m;
    options.full_slope_N_per_m = driver.full_slope_N_per_m;
    return options;
  }
  DeviceSample tick(std::int64_t k, const glm::dvec3& force_N) {
    clock.wait_until(RealTime{k * kMs});
    const DeviceSample sample = driver->read(clock.now());
    driver->write(force_N);
    return sample;
  }

  VirtualClock clock;
  SimulatedBoard device;
  RecordingTransport transport{device};
  std::unique_ptr<PidDriver> driver;
};

/// Counts are cut off several times on their way. A direction in 8 bits is 0.35 degrees off, so that 0.62 % of a force along
/// X acts along Y and 2e-5 of it is lost.
constexpr double kRounding_N = 10.0 * 4 / 10'000;
double astray(BoardKind kind) { return kind == BoardKind::arduino ? 0.0063 : 0; }

void require_rendered(const glm::dvec3& rendered, const glm::dvec3& wanted, BoardKind kind) {
  const double tolerance = kRounding_N + astray(kind) * (std::abs(wanted.x) + std::abs(wanted.y));
  for (int axis = 0; axis < 3; ++axis) REQUIRE(std::abs(rendered[axis] - wanted[axis]) <= tolerance);
}

}  // namespace

TEST_CASE("on every board the force asked for acts along its axes with its sign and along no other, 200 forces and gains") {
  std::mt19937_64 random(3);
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    for (const double gain : {1.0, 0.25, 0.01}) {
      PidOptions options = options_for(kind);
      options.gain = gain;
      BoardBench bench(kind, options);
      bench.driver->start();
      const double largest_N = bench.driver->largest_force_N();
      CHECK(largest_N == 10 * gain);
      for (std::int64_t k = 0; k < 200; ++k) {
        const auto draw = [&] { return (static_cast<double>(random() >> 11) / (1ll << 52) - 1) * largest_N; };
        glm::dvec3 force{0};
        const auto only = random() % 3;  // 0: along X, 1: along Y, 2: along both
        if (only != 1) force.x = draw();
        if (only != 0 && axes_of(kind) > 1) force.y = draw();
        bench.tick(k, force);
        require_rendered(bench.device.motors().force_N, force, kind);
      }
      bench.tick(200, {1e9, 0, 0});
      require_rendered(bench.device.motors().force_N, {largest_N, 0, 0}, kind);
      bench.driver->stop();
      CHECK(is_still(bench.device.motors()));
    }
  }
}

TEST_CASE("on no board a force along one axis ever acted along another") {
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    BoardBench bench(kind, options_for(kind));
    bench.driver->start();
    for (std::int64_t k = 0; k < 600; ++k) bench.tick(k, {k < 300 ? 8.0 : -8.0, 0, 0});
    const MotorState motors = bench.device.motors();
    CHECK(motors.largest_along_N.x == Approx(8).margin(kRounding_N + 1e-3));
    CHECK(motors.largest_along_N.y <= 8 * astray(kind) + kRounding_N);
    CHECK(motors.largest_along_N.z == 0);
  }
}

TEST_CASE("Set Effect of a force has Direction Enable alone and that of a spring its axis bit beside it") {
  // The axis byte and the first direction: 90 degrees for X, 0 for Y, and 180 for the spring along Y.
  const auto set_effects = [](BoardKind kind, std::size_t axis_byte) {
    BoardBench bench(kind, with_springs(kind));
    bench.driver->start();
    const std::string report = kind == BoardKind::silent_pool ? "w 31 " : "w 01 ";
    Log found;
    for (const std::string& line : bench.transport.log) {
      if (line.rfind(report, 0) == 0) found.push_back(line.substr(2 + 3 * axis_byte, 8));
    }
    return found;
  };
  CHECK(set_effects(BoardKind::openffboard_1, 13) == Log{"02 28 23", "03 28 23"});
  CHECK(set_effects(BoardKind::openffboard_2, 13) == Log{"04 28 23", "04 00 00", "05 28 23", "06 50 46"});
  CHECK(set_effects(BoardKind::arduino, 11) == Log{"04 40 00", "04 00 00", "05 40 00", "06 80 00"});
  CHECK(set_effects(BoardKind::silent_pool, 6) == Log{"04 28 23", "04 00 00", "05 28 23", "06 50 46"});
}

TEST_CASE("a board that never says that its safety switch is closed is driven all the same") {
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    BoardBench bench(kind, options_for(kind));
    bench.driver->start();
    for (std::int64_t k = 0; k < 1000; ++k) REQUIRE(bench.tick(k, {1, 0, 0}).drivable);
    CHECK(bench.driver->pid_counters().unpowered == 0);
    CHECK(bench.driver->silence() == PidSilence::none);
  }
  BoardBench bench(BoardKind::openffboard_2, options_for(BoardKind::openffboard_2));
  bench.driver->start();
  bench.tick(0, {1, 0, 0});
  CHECK(bench.driver->state().safety_switch == false);  // 1A, after each Create New Effect and Set Effect
  CHECK(bench.driver->pid_counters().state_reports == 4);
}

TEST_CASE("a switch that was seen closed cuts when it opens and the driver names it") {
  using Event = PidDeviceEvent::Kind;
  SimulatedBoardOptions options;
  options.events = {{Event::safety_switch, RealTime{10 * kMs}, false},
                    {Event::safety_switch, RealTime{20 * kMs}, true},
                    {Event::actuator_power, RealTime{30 * kMs}, false},
                    {Event::actuator_power, RealTime{40 * kMs}, true}};
  BoardBench bench(BoardKind::silent_pool, options_for(BoardKind::silent_pool), Still{}, options);
  bench.driver->start();
  for (std::int64_t k = 0; k < 50; ++k) {
    const DeviceSample sample = bench.tick(k, {1, 0, 0});
    const PidSilence expected = k >= 10 && k < 20   ? PidSilence::switch_open
                                : k >= 30 && k < 40 ? PidSilence::no_power
                                                    : PidSilence::none;
    REQUIRE(bench.driver->silence() == expected);
    REQUIRE(sample.drivable == (expected == PidSilence::none));
  }
  const PidCounters& counted = bench.driver->pid_counters();
  CHECK((counted.cuts_switch == 1 && counted.cuts_power == 1 && counted.cuts_paused == 0 && counted.cuts_actuators == 0));
  CHECK(bench.driver->own_counters().at("pid_cuts_switch") == 1);
}

TEST_CASE("on every board a spring of a measured sign pulls towards its center with its slope, 600 times along X and Y") {
  std::mt19937_64 random(4);
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    for (int axis = 0; axis < axes_of(kind) && with_springs(kind).reversed_spring[0]; ++axis) {
      glm::dvec3 at{0};
      at[axis] = 0.1;
      BoardBench bench(kind, with_springs(kind), Still{at});
      bench.driver->start();
      // More than 256 reports, because one firmware counts them only that far.
      for (std::int64_t k = 0; k < 600; ++k) {
        bench.tick(k, {0, 0, 0});
        DeviceSpring spring;
        const double stiffness = 5 + static_cast<double>(random() % 40);
        // The Arduino library gives a right spring only at the center.
        if (kind != BoardKind::arduino) spring.center_m[axis] = static_cast<double>(random() % 301) / 1000 - 0.15;
        spring.below_N_per_m[axis] = spring.above_N_per_m[axis] = stiffness;
        spring.limit_N[axis] = 10;
        const DeviceSpring rendered = bench.driver->write_spring(spring);
        REQUIRE(rendered.above_N_per_m[axis] == Approx(stiffness).margin(0.02));
        glm::dvec3 expected{0};
        expected[axis] = std::clamp(stiffness * (spring.center_m[axis] - at[axis]), -10.0, 10.0);
        require_rendered(bench.device.motors().force_N, expected, kind);
      }
      bench.driver->stop();
      CHECK(is_still(bench.device.motors()));
    }
  }
}

TEST_CASE("a spring whose sign nobody measured is rendered along no axis of any board") {
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    PidOptions options = with_springs(kind);
    options.reversed_spring = {};
    BoardBench bench(kind, options, Still{{0.1, 0.1, 0}});
    bench.driver->start();
    bench.tick(0, {0, 0, 0});
    DeviceSpring spring;
    spring.below_N_per_m = spring.above_N_per_m = {20, 20, 0};
    spring.limit_N = {10, 10, 0};
    const DeviceSpring rendered = bench.driver->write_spring(spring);
    CHECK((rendered.above_N_per_m == glm::dvec3(0) && rendered.below_N_per_m == glm::dvec3(0)));
    require_rendered(bench.device.motors().force_N, {0, 0, 0}, kind);
    CHECK(bench.device.motors().effects_playing == axes_of(kind));
  }
}

TEST_CASE("a spring measured as reversed is sent with negative coefficients") {
  PidOptions options = with_springs(BoardKind::openffboard_2);
  options.reversed_spring = {true, true, std::nullopt};
  BoardBench bench(BoardKind::openffboard_2, options, Still{{0.1, -0.05, 0}});
  bench.driver->start();
  bench.tick(0, {0, 0, 0});
  DeviceSpring spring;
  spring.below_N_per_m = spring.above_N_per_m = {20, 20, 0};
  spring.limit_N = {10, 10, 0};
  CHECK(bench.driver->write_spring(spring).above_N_per_m.y == Approx(20).margin(0.01));
  // If the board is not reversed, such a spring pushes away.
  require_rendered(bench.device.motors().force_N, {2, -1, 0}, BoardKind::openffboard_2);
}

TEST_CASE("no board is left with a force when its driver hangs, and each ends it by itself") {
  for (const auto& [name, kind] : drivable_boards()) {
    if (kind == BoardKind::no_duration) continue;  // it is refused for that reason, unless the user says otherwise
    INFO(name);
    BoardBench bench(kind, options_for(kind));
    bench.driver->start();
    for (std::int64_t k = 0; k < 1000; ++k) bench.tick(k, {3, 0, 0});
    require_rendered(bench.device.motors().force_N, {3, 0, 0}, kind);
    // The last Start was at 750 ms. Firmware that counts whole milliseconds ends the effect one millisecond later.
    bench.clock.wait_until(RealTime{1'249 * kMs});
    CHECK(bench.device.motors().force_N.x > 2.9);
    bench.clock.wait_until(RealTime{1'252 * kMs});
    CHECK(bench.device.motors().force_N == glm::dvec3(0));
    CHECK(bench.device.motors().effects_ended == axes_of(kind));
  }
}

TEST_CASE("answers to feature requests may lack their last byte, and a pool may stay silent") {
  for (const BoardKind kind : {BoardKind::short_replies, BoardKind::silent_pool}) {
    BoardBench bench(kind, options_for(kind));
    bench.driver->start();
    const auto asked = [&](const std::string& line) {
      return std::count(bench.transport.log.begin(), bench.transport.log.end(), line);
    };
    CHECK(asked("g 43") == 1);
    CHECK(asked("g 42") == 2);
    CHECK(bench.driver->pid_counters().pool_unknown == (kind == BoardKind::silent_pool));
    bench.tick(0, {1, -1, 0});
    require_rendered(bench.device.motors().force_N, {1, -1, 0}, kind);
  }
}

TEST_CASE("the pool is asked again while it says less than two, twenty times, and then not believed") {
  for (const int unready : {0, 1, 5, 19, 20, 1000}) {
    SimulatedPidOptions device = pid_device(PidFlavour::mask);
    device.pool_unready = unready;
    PidBench bench(device);
    bench.driver->start();
    CHECK(std::count(bench.transport.log.begin(), bench.transport.log.end(), "g 22") == std::min(20, unready + 1));
    CHECK(bench.driver->pid_counters().pool_unknown == (unready >= 20));
    CHECK(bench.device.playing() == 2);
  }
}

TEST_CASE("an axis that Axes Enable does not list has no force and is refused by name") {
  PidOptions options = options_for(BoardKind::openffboard_1);
  options.travel_m.y = 0.4;  // positions have a Y, for example of a pedal
  BoardBench bench(BoardKind::openffboard_1, options);
  CHECK_THROWS_WITH(bench.driver->start(), Contains("no force along Y") && Contains("give it a travel of 0"));
  CHECK(is_still(bench.device.motors()));
}

TEST_CASE("a board whose Block Load tells no block of its own is refused with what to write instead and left still") {
  for (const auto& [kind, says] : {std::pair(BoardKind::load_never, "whether an effect was loaded"),
                                   std::pair(BoardKind::load_always_1, "in which block of its own"),
                                   std::pair(BoardKind::load_error_first, "reports an error on loading an effect")}) {
    BoardBench bench(kind, options_for(kind));
    CHECK_THROWS_WITH(bench.driver->start(), Contains(says));
    if (kind != BoardKind::load_error_first)
      CHECK_THROWS_WITH(bench.driver->start(), Contains("leave out full_scale to read its positions alone"));
    CHECK(is_still(bench.device.motors()));
  }
  // A single effect has no other whose block it could be given.
  PidOptions options = options_for(BoardKind::load_always_1);
  options.travel_m.y = 0;
  BoardBench one(BoardKind::load_always_1, options);
  one.driver->start();
  one.tick(0, {3, 0, 0});
  require_rendered(one.device.motors().force_N, {3, 0, 0}, BoardKind::load_always_1);
}

TEST_CASE("an answer with the block of the effect before is asked again until the effect has its own") {
  BoardBench bench(BoardKind::late_load, with_springs(BoardKind::late_load));
  bench.driver->start();
  CHECK(std::count(bench.transport.log.begin(), bench.transport.log.end(), "g 42") == 4 * 5);
  CHECK(bench.device.motors().effects_allocated == 4);
  CHECK_FALSE(bench.driver->pid_counters().pool_unknown);  // its pool declares no number
}

TEST_CASE("on every board a second run in which Block Load may still tell a block of the first has the same forces") {
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    BoardBench bench(kind, options_for(kind));
    for (std::int64_t k = 0; k < 3; ++k) {
      bench.driver->start();
      const glm::dvec3 force_N{3, axes_of(kind) > 1 ? -2 : 0, 0};
      bench.tick(k, force_N);
      require_rendered(bench.device.motors().force_N, force_N, kind);
      bench.driver->stop();
      CHECK(is_still(bench.device.motors()));
    }
  }
}

TEST_CASE("a block that a late Block Load tells only once is believed when it has been asked often enough") {
  struct Once final : HidTransport {
    explicit Once(HidTransport& below) : device(below) {}
    HidRead read(std::span<std::byte> buffer) override { return device.read(buffer); }
    HidWrite write(std::span<const std::byte> report) override { return device.write(report); }
    HidWrite set_feature(std::span<const std::byte> report) override { return asked = 0, device.set_feature(report); }
    HidFeature get_feature(std::span<std::byte> report) override {
      if (report[0] == std::byte{0x42} && asked++ != 3) return {HidFeature::Status::rejected};
      return device.get_feature(report);
    }
    std::span<const std::byte> report_descriptor() const override { return device.report_descriptor(); }
    const HidDeviceInfo& info() const override { return device.info(); }
    HidTransport& device;
    int asked = 0;
  };
  BoardBench bench(BoardKind::silent_pool, options_for(BoardKind::silent_pool));
  Once once(bench.device);
  PidDriver driver(once, layout_of(bench.device), options_for(BoardKind::silent_pool));
  driver.start();
  driver.read(bench.clock.now());
  driver.write({3, -2, 0});
  require_rendered(bench.device.motors().force_N, {3, -2, 0}, BoardKind::silent_pool);
}

TEST_CASE("what Linux 6.1 requires of a board changes no force of ours") {
  for (const auto& [name, kind] : drivable_boards()) {
    if (kind == BoardKind::openffboard_1 || kind == BoardKind::openffboard_2 || kind == BoardKind::arduino) continue;
    INFO(name);
    SimulatedBoardOptions device;
    device.for_linux_6_1 = true;
    BoardBench bench(kind, with_springs(kind), Still{{0.1, -0.05, 0}}, device);
    bench.driver->start();
    bench.tick(0, {3, -2, 0});
    DeviceSpring spring;
    spring.below_N_per_m = spring.above_N_per_m = {20, 20, 0};
    spring.limit_N = {5, 5, 0};
    bench.driver->write_spring(spring);
    const double has_spring = kind != BoardKind::pxn, has_y = axes_of(kind) > 1;
    require_rendered(bench.device.motors().force_N, {3 - has_spring * 2, has_y * (has_spring * 1 - 2), 0}, kind);
    CHECK(layout_of(bench.device).set_effect.start_delay);
  }
}

TEST_CASE("an effect that would never end is refused unless the user says that it may, and then it lasts") {
  PidOptions options = options_for(BoardKind::no_duration);
  options.effect_duration = Duration{500 * kMs};
  BoardBench refused(BoardKind::no_duration, options);
  CHECK_THROWS_WITH(refused.driver->start(), Contains("no Duration (0x0F0050)") && Contains("effect_duration = \"none\""));
  CHECK(refused.transport.log.empty());
  BoardBench bench(BoardKind::no_duration, options_for(BoardKind::no_duration));
  bench.driver->start();
  bench.tick(0, {2, 0, 0});
  bench.clock.wait_until(RealTime{60'000 * kMs});
  require_rendered(bench.device.motors().force_N, {2, 0, 0}, BoardKind::no_duration);
}

TEST_CASE("0xFFFF ms are 65.5 s on a board that knows no eternity and the driver renews them long before") {
  PidOptions options = options_for(BoardKind::moza);
  options.effect_duration.reset();
  BoardBench bench(BoardKind::moza, options);
  bench.driver->start();
  for (std::int64_t k = 0; k < 70'000; k += 250) bench.tick(k, {1, 0, 0});
  CHECK(bench.device.motors().effects_ended == 0);
  bench.clock.wait_until(RealTime{(70'000 + 65'600) * kMs});
  CHECK(bench.device.motors().effects_ended == 1);
}

TEST_CASE("a spring that is asked for by name and that the device cannot render is refused with what it lacks") {
  using Options = PidDescriptorOptions;
  const auto refusal = [](bool Options::*part) {
    SimulatedPidOptions device = pid_device(PidFlavour::mask);
    device.descriptor.*part = false;
    PidOptions options = pid_options();
    options.springs = true;
    options.reversed_spring = {false, false, std::nullopt};
    PidBench bench(device, options);
    try {
      bench.driver->start();
    } catch (const DeviceError& error) {
      CHECK(bench.transport.log.empty());
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(refusal(&Options::parameter_block),
             Contains("no spring along Y") && Contains("(0x0F0023)") && Contains("leave Y out of 'springs'"));
  CHECK_THAT(refusal(&Options::conditions), Contains("no spring along X") && Contains("Set Condition (0x0F005F)"));
  CHECK(refusal(&Options::dead_band).empty());
}

TEST_CASE("a spring of the board that has one coefficient for both sides is rendered on both or not at all") {
  BoardBench bench(BoardKind::asetek, with_springs(BoardKind::asetek), Still{{-0.1, 0, 0}});
  bench.driver->start();
  bench.tick(0, {0, 0, 0});
  DeviceSpring wall;
  wall.above_N_per_m.x = 20;
  wall.limit_N.x = 10;
  CHECK(bench.driver->write_spring(wall).above_N_per_m.x == 0);
  CHECK(bench.device.motors().force_N == glm::dvec3(0));
  wall.below_N_per_m.x = 20;
  CHECK(bench.driver->write_spring(wall).above_N_per_m.x == Approx(20).margin(0.01));
  require_rendered(bench.device.motors().force_N, {2, 0, 0}, BoardKind::asetek);
}

TEST_CASE("of two commands at once both are the same because 0 is one of them") {
  BoardBench bench(BoardKind::two_commands, options_for(BoardKind::two_commands));
  bench.driver->start();
  bench.driver->stop();
  CHECK(std::count(bench.transport.log.begin(), bench.transport.log.end(), "w 36 03 03") == 2);  // Device Reset
  CHECK(std::count(bench.transport.log.begin(), bench.transport.log.end(), "w 36 01 01") == 1);  // Disable Actuators
  CHECK_FALSE(bench.device.motors().actuators_enabled);
}

TEST_CASE("the axes that have a force are those that Axes Enable lists, or else X, and Y if there is a second direction") {
  using Axes = std::array<bool, pid::kAxes>;
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    BoardBench bench(kind, options_for(kind));
    CHECK(pid_force_axes(layout_of(bench.device)) == Axes{true, axes_of(kind) == 2, false});
  }
  SimulatedPidOptions device = pid_device(PidFlavour::mask);
  device.descriptor.axes = 3;
  CHECK(pid_force_axes(layout_of(PidBench(device).device)) == Axes{true, true, true});
  device.descriptor.axes_enable = false;
  CHECK(pid_force_axes(layout_of(PidBench(device).device)) == Axes{true, true, false});
  device.descriptor.direction = false;
  CHECK(pid_force_axes(layout_of(PidBench(device).device)) == Axes{true, false, false});
}

TEST_CASE("start resets twice, stops all and sets the device's gain to its maximum before it enables the actuators") {
  BoardBench bench(BoardKind::openffboard_2, options_for(BoardKind::openffboard_2));
  bench.driver->start();
  const Log begin(bench.transport.log.begin(), bench.transport.log.begin() + 5);
  CHECK(begin == Log{"w 0C 08", "w 0C 08", "w 0C 04", "w 0D FF", "w 0C 01"});
}

TEST_CASE("a board without room and one that fails to load are errors of their own and are left still") {
  for (const auto& [name, kind] : drivable_boards()) {
    INFO(name);
    SimulatedBoardOptions full, failing;
    full.pool_effects = 0;
    failing.block_load_error_at = 0;
    using Reason = PidBlockLoadError::Reason;
    for (const auto& [options, reason] : {std::pair(full, Reason::full), std::pair(failing, Reason::error)}) {
      BoardBench bench(kind, options_for(kind), Still{}, options);
      try {
        bench.driver->start();
        FAIL("started");
      } catch (const PidBlockLoadError& error) {
        CHECK(error.reason == reason);
      }
      CHECK(is_still(bench.device.motors()));
    }
  }
}

TEST_CASE("on OpenFFBoard a force rises from its attack level and falls to its fade level, and zero times change nothing") {
  VirtualClock clock;
  SimulatedBoardOptions options;
  options.kind = BoardKind::openffboard_2;
  SimulatedBoard device(clock, ProgrammedMotion{Still{}, RealTime{}}, options);
  const auto send = [&](std::initializer_list<int> bytes) {
    std::vector<std::byte> report;
    for (const int byte : bytes) report.push_back(static_cast<std::byte>(byte));
    CHECK(device.write(report) == HidWrite::ok);
  };
  const auto force_at = [&](std::int64_t ms) {
    clock.wait_until(RealTime{ms * kMs});
    return device.motors().force_N.x;
  };
  // Block 1 for 400 ms from 270 degrees, which is towards higher X, with half of the largest magnitude of 10 N.
  send({1, 1, 1, 0x90, 0x01, 0, 0, 0, 0, 0, 0, 255, 0, 4, 0x78, 0x69, 0, 0, 0, 0, 0, 0});
  send({5, 1, 0x00, 0x40});
  send({2, 1, 0x00, 0x20, 0x00, 0x00, 100, 0, 0, 0, 200, 0, 0, 0});
  send({10, 1, 1, 1});
  CHECK(force_at(0) == Approx(2.5).margin(0.01));
  CHECK(force_at(50) == Approx(3.75).margin(0.02));
  CHECK(force_at(150) == Approx(5).margin(0.01));
  CHECK(force_at(300) == Approx(2.5).margin(0.02));
  CHECK(force_at(402) == 0);
  send({2, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  send({10, 1, 1, 1});
  for (const std::int64_t ms : {402, 403, 600, 801}) CHECK(force_at(ms) == Approx(5).margin(0.01));
}

TEST_CASE("random reports to each board end without harm and force along its motors within its full scale") {
  for (const auto& [name, kind] : simulated_boards()) {
    INFO(name);
    std::mt19937_64 random(11);
    VirtualClock clock;
    SimulatedBoardOptions options;
    options.kind = kind;
    SimulatedBoard device(clock, ProgrammedMotion{ConstantVelocity{{0.1, -0.05, 0}, Duration{0}}, RealTime{}}, options);
    const auto draw = [&](std::uint64_t below) { return random() % below; };
    std::array<std::byte, 24> bytes;
    const bool is_strict =
        kind != BoardKind::arduino && kind != BoardKind::openffboard_1 && kind != BoardKind::openffboard_2;
    const std::uint64_t first_id = is_strict ? 0x30 : 0;
    for (int i = 0; i < 10'000; ++i) {
      for (std::byte& byte : bytes) byte = static_cast<std::byte>(draw(256) & (draw(2) == 0 ? 0xFF : 0x07));
      if (draw(4) != 0) bytes[0] = static_cast<std::byte>(first_id + draw(20));
      const auto report = std::span(bytes).first(draw(25));
      const std::uint64_t how = draw(4);
      if (how == 0) device.set_feature(report);
      if (how == 1) device.get_feature(report);
      if (how > 1) device.write(report);
      if (draw(8) == 0)
        clock.wait_until(RealTime{clock.now().ns + static_cast<std::int64_t>(draw(static_cast<std::uint64_t>(kMs)))});
      const glm::dvec3 force_N = device.motors().force_N;
      REQUIRE((std::abs(force_N.x) <= 10 && std::abs(force_N.y) <= (motors_of(kind) > 1 ? 10 : 0) && force_N.z == 0));
    }
  }
}
