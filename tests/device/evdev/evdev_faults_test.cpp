// Nodes that refuse what a driver needs, and what the kernel says of devices.
#include <cerrno>
#include <map>

#include "catch.h"
#include "evdev/evdev_listing.h"
#include "evdev_bench.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

/// A node of which some calls fail with these errors.
struct RefusingNode final : ScriptedNode {
  EvdevRead read(std::span<EvdevEvent> into) override {
    return statuses.empty() ? ScriptedNode::read(into) : EvdevRead{take_status()};
  }
  EvdevRead::Status take_status() {
    const EvdevRead::Status first = statuses.front();
    statuses.erase(statuses.begin());
    return first;
  }
  int write(const EvdevEvent& event) override { return write_error != 0 ? write_error : ScriptedNode::write(event); }
  int upload(EvdevEffect& effect) override {
    return effect.type == refused_type ? upload_error : ScriptedNode::upload(effect);
  }
  int grab() override { return grab_error; }
  bool has_axis(std::uint16_t) override { return true; }
  bool has_feedback(std::uint16_t code) override { return code != lacks; }
  int axis(std::uint16_t, EvdevAxis& axis) override {
    axis = {0, minimum, 100, fuzz};
    return axis_calls++ < good_axis_calls ? 0 : axis_error;
  }
  int set_axis(std::uint16_t, const EvdevAxis& wanted) override {
    fuzz = set_axis_error == 0 ? wanted.fuzz : fuzz;
    return set_axis_error;
  }

  std::vector<EvdevRead::Status> statuses;  // of the next reads; afterwards there is nothing
  int write_error = 0, upload_error = 0, grab_error = 0, axis_error = 0, set_axis_error = 0;
  std::uint16_t refused_type = 0, lacks = 0;
  int minimum = -100, fuzz = 0, axis_calls = 0, good_axis_calls = 0;
};

EvdevOptions along_x() {
  EvdevOptions options = evdev_options();
  options.travel_m.y = 0;
  return options;
}

}  // namespace

TEST_CASE("evdev: a node that refuses what the driver needs at its start says what, with the path of the device") {
  const auto refusal = [](auto change, EvdevOptions options = along_x()) {
    RefusingNode node;
    change(node);
    return device_error_of([&] { EvdevDriver(node, options).start(); });
  };
  CHECK(refusal([](RefusingNode&) {}).empty());
  CHECK(refusal([](RefusingNode& node) { node.grab_error = EIO; }) ==
        "/dev/input/event7: it cannot be taken for evenstep alone: Input/output error");
  CHECK_THAT(refusal([](RefusingNode& node) { node.lacks = evdev::kConstant; }), Contains("plays no constant forces"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.minimum = 100; }), Contains("axis X says that it goes from 100 to 100"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.fuzz = 3, node.set_axis_error = EACCES; }),
             Contains("the kernel smooths axis X and cannot be told not to"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.axis_error = EACCES; }), Contains("event7: Permission denied"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.good_axis_calls = 1, node.axis_error = EIO; }),
             Contains("it does not say where its axes are"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.good_axis_calls = 1, node.axis_error = ENODEV; }),
             Contains("device 'a node' is gone (unplugged or reset); plug it in and run again"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.write_error = ENODEV; }), Contains("device 'a node' is gone"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.write_error = ENODEV, node.lacks = evdev::kGain; }),
             Contains("device 'a node' is gone"));
  const auto refusing = [](std::uint16_t type, int error) {
    return [=](RefusingNode& node) { node.refused_type = type, node.upload_error = error; };
  };
  EvdevOptions springs = along_x();
  springs.springs = true;
  springs.reversed_spring[0] = false;
  CHECK_THAT(refusal(refusing(evdev::kConstant, EIO)), Contains("it refuses a constant force: Input/output error"));
  CHECK_THAT(refusal(refusing(evdev::kSpring, EIO), springs), Contains("it refuses a spring: Input/output error"));
  CHECK_THAT(refusal(refusing(evdev::kSpring, ENODEV), springs), Contains("device 'a node' is gone"));
  CHECK_THAT(refusal([](RefusingNode& node) { node.lacks = evdev::kSpring; }, springs), Contains("plays no springs"));
  EvdevOptions along_z = evdev_options();
  along_z.travel_m = {0, 0, 0.1};
  CHECK_THAT(refusal([](RefusingNode&) {}, along_z), Contains("it has forces along X and Y only, and neither has a travel"));
}

TEST_CASE("evdev: what the kernel smoothed before the run it smooths again after it") {
  RefusingNode node;
  node.fuzz = 7;
  {
    const EvdevDriver driver(node, along_x());
    CHECK(node.fuzz == 0);
  }
  CHECK(node.fuzz == 7);
}

TEST_CASE("evdev: a device that is gone when a force is written, or before the first read, is an error with its name") {
  RefusingNode node;
  EvdevDriver driver(node, along_x());
  driver.start();
  driver.read(RealTime{1'000'000});
  node.write_error = ENODEV;
  CHECK_THAT(device_error_of([&] { driver.write({1, 0, 0}); }), Contains("device 'a node' is gone"));
  node.statuses = {EvdevRead::Status::gone};
  CHECK_THAT(device_error_of([&] { driver.forget_queued(); }), Contains("device 'a node' is gone"));
}

TEST_CASE("evdev: a device that was back and went again at once is away, and its forces are asked for once it is back") {
  RefusingNode node;
  node.good_axis_calls = 1000;
  EvdevDriver driver(node, along_x());
  driver.start();
  node.statuses = {EvdevRead::Status::away};
  CHECK(driver.read(RealTime{1'000'000}).away);
  node.statuses = {EvdevRead::Status::returned};
  node.good_axis_calls = 0, node.axis_error = ENXIO;
  DeviceSample sample = driver.read(RealTime{2'000'000});
  CHECK(sample.away);
  CHECK_FALSE(sample.drivable);
  driver.write({1, 0, 0});
  CHECK(node.written.count(0) == 0);  // effect 0 is not played
  node.axis_error = 0;
  node.statuses = {EvdevRead::Status::returned};
  CHECK(driver.read(RealTime{3'000'000}).away);  // for one tick more, so that forces rise from zero
  sample = driver.read(RealTime{4'000'000});
  CHECK_FALSE(sample.away);
  driver.write({1, 0, 0});
  CHECK(node.written.at(0) == 1);
}

TEST_CASE("evdev: a spring of a device that pushes the other way is sent with negative coefficients") {
  RefusingNode node;
  EvdevOptions options = along_x();
  options.springs = true;
  options.reversed_spring[0] = true;
  EvdevDriver driver(node, options);
  driver.start();
  DeviceSpring spring, rendered;
  spring.above_N_per_m.x = 10;
  spring.below_N_per_m.x = 5;
  spring.limit_N.x = 2;
  for (int tick = 1; tick < 20; ++tick) {
    driver.read(RealTime{tick * 1'000'000});
    rendered = driver.write_spring(spring);
  }
  CHECK(rendered.above_N_per_m.x == Approx(10).margin(0.01));
  const EvdevCondition& sent = node.effects.at(1).conditions[0];
  CHECK(sent.right_coefficient < 0);
  CHECK(std::abs(sent.right_coefficient - 2 * sent.left_coefficient) <= 1);
  spring.center_m.x = 0.21;  // outside of the travel, where no device can have its center
  CHECK(driver.write_spring(spring).above_N_per_m.x == 0);
}

TEST_CASE("evdev: a spring along Y points up and all else left or down, as through hidraw") {
  RefusingNode node;
  EvdevOptions options = along_x();
  options.travel_m = {0.4, 0.4, 0};
  options.springs = true;
  options.reversed_spring = {false, false};
  EvdevDriver driver(node, options);
  driver.start();
  for (const auto& [effect, direction] : std::map<int, int>{{0, 0x4000}, {1, 0}, {2, 0x4000}, {3, 0x8000}}) {
    INFO(effect);
    CHECK(node.effects.at(effect).direction == direction);
  }
}

TEST_CASE("evdev: what sysfs says of a device is read from words of 64 bits, and its name cannot control a terminal") {
  // A wheel with FF_CONSTANT, FF_SPRING and FF_GAIN (bits 0x52, 0x53, 0x60), the axes X and Z, and EV_FF (bit 0x15); masks
  // as Linux prints them.
  internal::EvdevTexts texts{"Wheel \x1b[2J\xc2\x9b", "046d", "c24f", "serial\n", "1000c0000 0", "5", "20001b"};
  EvdevListing listing = internal::evdev_listing(texts);
  CHECK(listing.info.name == "Wheel ?[2J??");
  CHECK(listing.info.serial == "serial?");
  CHECK(listing.info.vendor_id == 0x046D);
  CHECK(listing.info.product_id == 0xC24F);
  CHECK(listing.constant);
  CHECK(listing.spring);
  CHECK(listing.gain);
  CHECK(listing.has_axis == std::array{true, false, true});
  CHECK(internal::has_effects(texts));
  texts.effects = "40000 0";  // FF_CONSTANT alone
  listing = internal::evdev_listing(texts);
  CHECK(listing.constant);
  CHECK_FALSE(listing.spring);
  CHECK_FALSE(listing.gain);
  for (const char* none : {"", "0", "0 0", " ", "wheel"}) {
    INFO(none);
    texts.effects = texts.axes = texts.vendor = none;
    listing = internal::evdev_listing(texts);
    CHECK_FALSE(listing.constant);
    CHECK_FALSE(listing.has_axis[0]);
    CHECK(listing.info.vendor_id == 0);
  }
  texts.effects = "1000c0000";  // one word: bits 0x12, 0x13 and 0x20 are other effects
  CHECK_FALSE(internal::evdev_listing(texts).constant);
  CHECK(internal::has_effects(texts));
  texts.effects = "1000c0000 0";
  texts.types = "1b";  // what hid-pidff leaves of a device that it has given up
  CHECK_FALSE(internal::has_effects(texts));
  listing = internal::evdev_listing(texts);
  CHECK_FALSE((listing.constant || listing.spring || listing.gain));
}
