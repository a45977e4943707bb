/// Every simulated board on USB, as the PID driver of Linux 6.1 takes it, and as ours does: which it refuses and what it
/// says to that, and which forces the motors make. A board is plugged in as it is, and with all that this kernel requires of
/// any device (SimulatedBoardOptions::for_linux_6_1), so that what it meets is the board's own fault.

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "catch.h"
#include "kernel_log.h"
#include "two_ways.h"

using namespace evenstep;
using Catch::Contains;
using Kind = BoardKind;

namespace {

const std::string kAccepted = "Force feedback for USB HID PID devices";
const std::string kSetEffect = "unknown set_effect report layout";

constexpr glm::dvec3 kHand_m{0.1, -0.05, 0};
constexpr double kTolerance_N = 2e-4 * kFull_N;

/// What Linux 6.1 makes of a board that has all that it requires.
struct Row {
  Kind kind;
  std::string says;  // on refusing it, or on taking it
  bool springs = true, one_block = false;
  bool is_taken() const { return says == kAccepted; }
};
const std::vector<Row> kRows{
    {Kind::openffboard_1, kAccepted},
    {Kind::openffboard_2, kAccepted},
    {Kind::arduino, kSetEffect},
    {Kind::silent_pool, "device does not support device managed pool"},
    {Kind::short_replies, "pid_block_load failed 60 times"},  // it drops answers that are too short
    {Kind::vrs, "direction field not found"},
    {Kind::asetek, kAccepted, false},
    {Kind::moza, kAccepted},
    {Kind::pxn, kAccepted},
    {Kind::fixed_direction, kAccepted},
    {Kind::two_commands, "logical_minimum is not 1 as it should be"},
    {Kind::late_load, kAccepted, true, true},
    {Kind::no_duration, kSetEffect},
    {Kind::load_error_first, kAccepted},
    {Kind::load_never, "pid_block_load failed 60 times"},
    {Kind::load_always_1, kAccepted, true, true},
};

bool is_missing_usbip() {
  const std::string refusal = UsbipPidDevice::refusal();
  if (!refusal.empty()) WARN("no USB/IP here: " << refusal);
  return !refusal.empty();
}

std::string name_of(Kind kind) {
  const auto& all = simulated_boards();
  return std::string(std::find_if(all.begin(), all.end(), [&](const NamedBoard& one) { return one.kind == kind; })->name);
}

SimulatedBoardOptions for_linux(Kind kind) {
  SimulatedBoardOptions options = firmware(kind);
  options.for_linux_6_1 = true;
  return options;
}

/// 0, or why the kernel does not take a constant force for the device.
int upload_error(const UsbipPidDevice& device) {
  EvdevFile file(device.event_node());
  EvdevEffect effect;
  return file.upload(effect);
}

bool is_listed(const UsbipPidDevice& device) {
  const auto all = evdev_devices();
  return std::any_of(all.begin(), all.end(),
                     [node = device.event_node()](const auto& one) { return one.info.path == node; });
}

/// A direction of the Arduino library has 8 bits: 0.62 % of a force along X acts along Y.
bool is_near(const glm::dvec3& felt_N, const glm::dvec3& wanted_N, Kind kind) {
  const double astray = kind == Kind::arduino ? 0.0063 * (std::abs(wanted_N.x) + std::abs(wanted_N.y)) : 0;
  return std::abs(felt_N.x - wanted_N.x) < kTolerance_N + astray && std::abs(felt_N.y - wanted_N.y) < kTolerance_N + astray;
}

/// All forces, and one spring along each axis that has a motor.
void check_forces(const UsbipPidDevice& device, HapticDevice& driver, Kind kind, bool springs) {
  const double has_y = motors_of(kind) > 1;
  driver.start();
  for (const glm::dvec3& force_N : kForces_N) {
    const glm::dvec3 felt_N = rendered(device, driver, force_N);
    CAPTURE(force_N.x, force_N.y, felt_N.x, felt_N.y);
    CHECK(is_near(felt_N, {force_N.x, has_y * force_N.y, 0}, kind));
  }
  if (springs) {
    const DeviceSpring spring{.below_N_per_m = {20, 20, 0}, .above_N_per_m = {20, 20, 0}, .limit_N = {5, 5, 0}};
    const glm::dvec3 felt_N = rendered(device, driver, glm::dvec3(0), spring);
    CAPTURE(felt_N.x, felt_N.y);
    const double feels = kind != Kind::pxn;
    CHECK(is_near(felt_N, {feels * -20 * kHand_m.x, feels * has_y * -20 * kHand_m.y, 0}, kind));
  }
  driver.stop();
  pause(50'000);
  CHECK(device.force_N() == glm::dvec3(0));
}

/// Our own driver takes the board, or refuses it for its answers to Block Load.
void check_ours(const UsbipPidDevice& device, Kind kind) {
  INFO("ours");
  PidOptions options = told<PidOptions>(kind, true);
  if (kind == Kind::no_duration) options.effect_duration.reset();
  Direct ours(device, options);
  if (kind == Kind::load_error_first || kind == Kind::load_never || kind == Kind::load_always_1)
    CHECK_THROWS_AS(ours.driver->start(), PidBlockLoadError);
  else
    check_forces(device, *ours.driver, kind, true);
}

/// Late and constant answers to Block Load give the kernel the block of X for Y, too. All forces then act along Y, whose
/// direction was sent last, and the one that was sent last counts.
void check_one_block(const UsbipPidDevice& device, Kind kind) {
  ByKernel kernel(device, told<EvdevOptions>(kind));
  kernel.driver->start();
  CHECK(is_near(rendered(device, *kernel.driver, {0, 0, 0}), {0, 0, 0}, kind));
  CHECK(is_near(rendered(device, *kernel.driver, {1, 0, 0}), {0, -1, 0}, kind));
  CHECK(is_near(rendered(device, *kernel.driver, {-2, 0, 0}), {0, 2, 0}, kind));
  CHECK(is_near(rendered(device, *kernel.driver, {-2, 3, 0}), {0, 3, 0}, kind));
}

/// What it renders of one effect, half of the largest, that points to `direction` as Linux counts.
double felt_x_N(const UsbipPidDevice& device, std::uint16_t type, std::uint16_t direction) {
  EvdevFile file(device.event_node());
  EvdevEffect effect{.type = type, .direction = direction, .level = 0x4000};
  effect.conditions[0] = {
      .right_saturation = 0xFFFF, .left_saturation = 0xFFFF, .right_coefficient = 0x4000, .left_coefficient = 0x4000};
  REQUIRE(file.upload(effect) == 0);
  REQUIRE(file.write({evdev::kFf, static_cast<std::uint16_t>(effect.id), 1}) == 0);
  pause(20'000);
  const double felt_N = device.force_N().x;
  REQUIRE(file.erase(effect.id) == 0);
  return felt_N;
}

}  // namespace

TEST_CASE(
    "usbip: boards as they are are refused by the kernel for Set Effect, all but OpenFFBoard, and ours makes the forces") {
  if (is_missing_usbip()) return;
  for (const Row& row : kRows) {
    if (row.kind == Kind::openffboard_1 || row.kind == Kind::openffboard_2) continue;  // below: they have what it requires
    INFO(name_of(row.kind));
    const KernelLog log;
    UsbipPidDevice device(a_clock(), firmware(row.kind), Still{kHand_m});
    REQUIRE(!device.hidraw_node().empty());
    CHECK_THAT(log.said(), Contains(kSetEffect));
    CHECK(upload_error(device) == ENOSYS);
    CHECK_FALSE(is_listed(device));
    check_ours(device, row.kind);
  }
}

TEST_CASE("usbip: boards with all that the kernel requires: refused with its reason, or the same forces in both ways") {
  if (is_missing_usbip()) return;
  REQUIRE(kRows.size() == simulated_boards().size());
  for (const Row& row : kRows) {
    INFO(name_of(row.kind));
    const KernelLog log;
    UsbipPidDevice device(a_clock(), for_linux(row.kind), Still{kHand_m});
    REQUIRE(!device.hidraw_node().empty());
    const std::string said = log.said();
    CHECK_THAT(said, Contains(row.says));
    CHECK((said.find("unknown condition effect layout") == std::string::npos) == row.springs);
    CHECK(upload_error(device) == (row.is_taken() ? 0 : ENOSYS));
    CHECK(is_listed(device) == row.is_taken());
    if (row.is_taken()) {
      INFO("by the kernel");
      CHECK(EvdevFile(device.event_node()).has_feedback(evdev::kSpring) == row.springs);
      if (row.one_block)
        check_one_block(device, row.kind);
      else
        check_forces(device, *ByKernel(device, told<EvdevOptions>(row.kind, row.springs)).driver, row.kind, row.springs);
    }
    check_ours(device, row.kind);
  }
  std::printf("%zu boards met the kernel's PID driver and ours\n", kRows.size());
  std::fflush(stdout);
}

TEST_CASE("usbip: the direction that the kernel sends with a spring turns its sign on moza, and a fixed one ignores it") {
  if (is_missing_usbip()) return;
  struct Felt {
    std::uint16_t direction;
    double sign;
  };
  const auto check = [](Kind kind, const std::vector<Felt>& expected) {
    INFO(name_of(kind));
    UsbipPidDevice device(a_clock(), for_linux(kind), Still{kHand_m});
    REQUIRE(!device.hidraw_node().empty());
    for (const auto& [direction, sign] : expected) {
      CAPTURE(direction);
      CHECK(felt_x_N(device, evdev::kConstant, direction) == Approx(sign * kFull_N / 2).margin(kTolerance_N));
      CHECK(felt_x_N(device, evdev::kSpring, direction) ==
            Approx(sign * kFullSlope_N_per_m / 2 * kHand_m.x).margin(kTolerance_N));
    }
  };
  check(Kind::moza, {{evdev::kLeft, -1}, {evdev::kDown, 0}, {0xC000, 1}});
  check(Kind::fixed_direction, {{evdev::kLeft, -1}, {evdev::kDown, -1}, {0xC000, -1}});
}
