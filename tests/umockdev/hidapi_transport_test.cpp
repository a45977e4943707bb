/// The real transport, with the unmodified libhidapi below it and a hidraw node that umockdev makes up. The tests assert
/// bytes, order, counts and errors, but never how long something took.

#include "evenstep/device/hid/hidapi_transport.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <numeric>
#include <thread>

#include "catch.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/reference_driver.h"
#include "mocked_hidraw.h"

using namespace evenstep;

namespace {

Bytes bytes(std::span<const std::byte> span) { return {span.begin(), span.end()}; }

MockedHidraw::Spec reference(MockedHidraw::Node node = MockedHidraw::Node::fifo) {
  MockedHidraw::Spec spec;
  spec.report_descriptor = bytes(reference_device::report_descriptor());
  spec.node = node;
  return spec;
}

/// Output reports 5 (2 bytes after the id) and 12 (1 byte), feature reports 0x11 (2 bytes) and 0x13 (4 bytes).
MockedHidraw::Spec with_features() {
  MockedHidraw::Spec spec;
  for (const int b : {0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,  //
                      0x85, 0x01, 0x95, 0x14, 0x09, 0x02, 0x81, 0x02,                                      //
                      0x85, 0x05, 0x95, 0x02, 0x09, 0x03, 0x91, 0x02,                                      //
                      0x85, 0x0C, 0x95, 0x01, 0x09, 0x04, 0x91, 0x02,                                      //
                      0x85, 0x11, 0x95, 0x02, 0x09, 0x05, 0xB1, 0x02,                                      //
                      0x85, 0x13, 0x95, 0x04, 0x09, 0x06, 0xB1, 0x02, 0xC0})
    spec.report_descriptor.push_back(static_cast<std::byte>(b));
  return spec;
}

Bytes output(std::uint32_t sequence) {
  const auto encoded = reference_device::encode(reference_device::OutputReport{sequence, {4, 5, 6}});
  return {encoded.begin(), encoded.end()};
}

Bytes input(std::uint32_t sequence) {
  const auto encoded = reference_device::encode(reference_device::InputReport{sequence, sequence * 1000, {1, 2, 3}});
  return {encoded.begin(), encoded.end()};
}

/// Waits until the condition holds. Other threads have a generous minute to make it true.
template <class Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 60'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

const WallClock& a_clock() {
  static const WallClock clock(WallEpoch::in(Duration{0}));
  return clock;
}

std::string error_of_opening(const std::string& path) {
  try {
    const HidapiTransport transport(path, a_clock());
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "opened";
}

}  // namespace

TEST_CASE("a device is listed once with its strings and descriptor") {
  MockedHidraw device(reference());
  const std::vector<HidListing> found = hid_devices();
  REQUIRE(found.size() == 1);
  CHECK(found[0].info.path == "/dev/hidraw0");
  CHECK(found[0].info.vendor_id == reference_device::kVendorId);
  CHECK(found[0].info.product_id == reference_device::kProductId);
  CHECK(found[0].info.product == "evenstep reference device");
  CHECK(found[0].info.serial == "SN0001");
  CHECK(found[0].report_descriptor == bytes(reference_device::report_descriptor()));
  CHECK(found[0].refusal.empty());
  CHECK(found[0].force_feedback_node.empty());
  CHECK(udev_rule(found[0].info) == R"(KERNEL=="hidraw*", KERNELS=="*:1209:0E57.*", TAG+="uaccess")");
}

TEST_CASE("a device's name cannot control the terminal that it is printed to") {
  MockedHidraw::Spec spec = reference();
  spec.name =
      "a\x1B[2Jb\x7F\xC2\x9B"
      "c\xC3\xA9";
  spec.serial =
      "1\x07"
      "2";
  MockedHidraw device(spec);
  REQUIRE(hid_devices().size() == 1);
  CHECK(hid_devices()[0].info.product == "a?[2Jb???c\xC3\xA9");
  CHECK(hid_devices()[0].info.serial == "1?2");
}

TEST_CASE("a device that the kernel drives too is listed with the input node that does") {
  MockedHidraw::Spec spec = reference();
  spec.force_feedback = "3000";
  MockedHidraw device(spec);
  REQUIRE(hid_devices().size() == 1);
  CHECK(hid_devices()[0].force_feedback_node == "/dev/input/event7");
}

TEST_CASE("what is no hidraw device is refused with the remedy and never reaches hidapi") {
  MockedHidraw device(reference());
  for (const std::string path : {"/dev/null", ""})
    CHECK(error_of_opening(path) == path + ": not a hidraw device; `evenstep devices` lists those that are there");
  for (const std::string path : {"/dev/hidraw1", "/dev/hidraw", "/nowhere/hidraw0"})
    CHECK(error_of_opening(path) == path + ": no such file; `evenstep devices` lists the devices that are there");
  CHECK(error_of_opening("/dev/hidraw0") == "opened");
}

TEST_CASE("input reports arrive byte for byte in order and none twice") {
  MockedHidraw device(reference());
  HidapiTransport transport("/dev/hidraw0", a_clock());
  std::array<std::byte, 64> buffer;
  CHECK(transport.read(buffer).status == HidRead::Status::nothing);
  for (std::uint32_t burst = 0, sequence = 1; burst < 20; ++burst) {
    const std::uint32_t first = sequence;
    for (; sequence < first + burst; ++sequence) REQUIRE(device.send(input(sequence)));
    for (std::uint32_t expected = first; expected < sequence; ++expected) {
      const HidRead got = transport.read(buffer);
      REQUIRE(got.status == HidRead::Status::report);
      REQUIRE(Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(got.size)) == input(expected));
    }
    REQUIRE(transport.read(buffer).status == HidRead::Status::nothing);
  }
}

TEST_CASE("a report longer than the buffer says its true size and does not spill into the next") {
  MockedHidraw device(reference());
  HidapiTransport transport("/dev/hidraw0", a_clock());
  Bytes long_report(40, std::byte{7});
  REQUIRE(device.send(long_report));
  REQUIRE(device.send(input(1)));
  std::array<std::byte, 10> small;
  CHECK(transport.read(small).size == 40);
  std::array<std::byte, 64> buffer;
  CHECK(transport.read(buffer).size == reference_device::kInputSize);
  CHECK(reference_device::decode_input(buffer)->sequence == 1);
}

TEST_CASE("the driver above real hidapi sees what a full queue dropped") {
  MockedHidraw device(reference());
  HidapiTransport transport("/dev/hidraw0", a_clock());
  ReferenceDriver driver(transport);
  std::uint32_t kept = 0;
  for (std::uint32_t sequence = 1; sequence <= 200; ++sequence) kept += device.send(input(sequence));
  CHECK(kept == 64);  // the kernel itself keeps 63
  DeviceSample sample = driver.read(RealTime{0});
  CHECK(sample.fresh);
  CHECK(sample.sequence == kept);
  REQUIRE(device.send(input(201)));
  sample = driver.read(RealTime{1'000'000});
  CHECK(sample.sequence == 201);
  CHECK(sample.position_m == glm::dvec3(1e-9, 2e-9, 3e-9));
  CHECK(driver.counters().lost == 200 - kept);
  CHECK(driver.counters().malformed == 0);
}

TEST_CASE("output reports arrive in order and each write is timed") {
  MockedHidraw device(with_features());
  HidapiTransport transport("/dev/hidraw0", a_clock());
  std::vector<Bytes> sent;
  for (unsigned char i = 0; i < 50; ++i) {
    sent.push_back({std::byte{5}, std::byte{i}, std::byte{0xAA}});
    REQUIRE(transport.write(sent.back()) == HidWrite::ok);
  }
  REQUIRE(eventually([&] { return device.outputs().size() == sent.size(); }));
  CHECK(device.outputs() == sent);
  REQUIRE(eventually([&] { return transport.write_times().taken.count() == 50; }));
  CHECK(transport.write_times().taken.largest().ns > 0);
  CHECK(transport.write_times().overtaken == 0);
  CHECK(transport.write_times().rejected == 0);
}

TEST_CASE("of forces that wait only the newest of each block is sent and never across a report that must keep its place") {
  MockedHidraw device(with_features());
  device.take_time_to_write(Duration{200'000'000});
  HidapiTransport transport("/dev/hidraw0", a_clock());
  const auto force = [](unsigned char block, unsigned char value) {
    return Bytes{std::byte{5}, std::byte{block}, std::byte{value}};
  };
  const Bytes stop{std::byte{12}, std::byte{3}};
  REQUIRE(transport.write(stop) == HidWrite::ok);
  REQUIRE(eventually([&] { return !device.outputs().empty() || transport.write(stop) == HidWrite::ok; }));
  for (unsigned char value = 1; value <= 9; ++value) {
    for (unsigned char block = 1; block <= 2; ++block) REQUIRE(transport.write_newest(force(block, value)) == HidWrite::ok);
  }
  REQUIRE(transport.write(stop) == HidWrite::ok);
  REQUIRE(transport.write_newest(force(1, 10)) == HidWrite::ok);
  REQUIRE(transport.write_newest(force(1, 11)) == HidWrite::ok);
  REQUIRE(eventually([&] { return device.outputs().size() >= 6; }));
  const std::vector<Bytes> all = device.outputs();
  const std::vector<Bytes> last(all.end() - 4, all.end());
  CHECK(last == std::vector<Bytes>{force(1, 9), force(2, 9), stop, force(1, 11)});
  CHECK(transport.write_times().overtaken == 17);
}

TEST_CASE("the 65th report that waits is rejected and what waits is sent before the handle closes") {
  MockedHidraw device(with_features());
  const Bytes report{std::byte{12}, std::byte{1}};
  {
    device.take_time_to_write(Duration{100'000'000});
    HidapiTransport transport("/dev/hidraw0", a_clock());
    int taken = 0;
    while (transport.write(report) == HidWrite::ok) ++taken;
    CHECK(taken >= 64);  // and the one or more that were sent meanwhile
    CHECK(transport.write_times().rejected == 1);
    device.take_time_to_write(Duration{0});
  }
  const std::size_t sent = device.outputs().size();
  CHECK(sent >= 64);
}

TEST_CASE("feature reports are asked for by id and an unknown one is rejected") {
  MockedHidraw device(with_features());
  const Bytes pool{std::byte{0x13}, std::byte{0x10}, std::byte{0x00}, std::byte{4}, std::byte{1}};
  device.answer_feature(pool);
  HidapiTransport transport("/dev/hidraw0", a_clock());
  Bytes report(64);
  report[0] = std::byte{0x13};
  const HidFeature got = transport.get_feature(report);
  REQUIRE(got.status == HidFeature::Status::ok);
  CHECK(Bytes(report.begin(), report.begin() + static_cast<std::ptrdiff_t>(got.size)) == pool);
  report[0] = std::byte{0x14};
  CHECK(transport.get_feature(report).status == HidFeature::Status::rejected);
  const Bytes create{std::byte{0x11}, std::byte{1}, std::byte{0}};
  CHECK(transport.set_feature(create) == HidWrite::ok);
  CHECK(device.features_set() == std::vector<Bytes>{create});
}

TEST_CASE("a feature report never overtakes an output report that was written before it") {
  MockedHidraw device(with_features());
  device.answer_feature(Bytes(5, std::byte{0x13}));
  device.take_time_to_write(Duration{50'000'000});
  HidapiTransport transport("/dev/hidraw0", a_clock());
  const Bytes written{std::byte{12}, std::byte{1}};
  Bytes report(5, std::byte{0x13});
  for (std::size_t sent = 2; sent <= 8; sent += 2) {
    REQUIRE(transport.write(written) == HidWrite::ok);
    REQUIRE(transport.write(written) == HidWrite::ok);
    if (sent % 4 == 0)
      REQUIRE(transport.get_feature(report).status == HidFeature::Status::ok);
    else
      REQUIRE(transport.set_feature(Bytes(3, std::byte{0x11})) == HidWrite::ok);
    CHECK(device.outputs().size() == sent);
  }
}

TEST_CASE("a report that the descriptor does not declare never reaches the device") {
  MockedHidraw device(with_features());
  HidapiTransport transport("/dev/hidraw0", a_clock());
  for (const std::size_t size : {0, 1, 2, 4, 40, 20'000})
    CHECK(transport.write(Bytes(size, std::byte{5})) == HidWrite::rejected);
  CHECK(transport.write(Bytes(3, std::byte{6})) == HidWrite::rejected);
  CHECK(transport.set_feature(Bytes(3, std::byte{5})) == HidWrite::rejected);
  CHECK(transport.set_feature(Bytes(4, std::byte{0x11})) == HidWrite::rejected);
  CHECK(transport.write_times().rejected == 7);
  REQUIRE(transport.write(Bytes(3, std::byte{5})) == HidWrite::ok);
  REQUIRE(eventually([&] { return device.outputs().size() == 1; }));
  CHECK(device.features_set().empty());
}

TEST_CASE("an unplugged device is gone for reads and writes and for ever") {
  MockedHidraw device(reference(MockedHidraw::Node::pty));
  HidapiTransport transport("/dev/hidraw0", a_clock());
  std::array<std::byte, 64> buffer;
  REQUIRE(device.send(input(1)));
  REQUIRE(eventually([&] { return transport.read(buffer).status == HidRead::Status::report; }));
  device.unplug();
  REQUIRE(eventually([&] { return transport.read(buffer).status == HidRead::Status::gone; }));
  REQUIRE(eventually([&] { return transport.write_newest(output(2)) == HidWrite::gone; }));
  for (int i = 0; i < 100; ++i) {
    REQUIRE(transport.read(buffer).status == HidRead::Status::gone);
    REQUIRE(transport.write(output(2)) == HidWrite::gone);
    REQUIRE(transport.get_feature(buffer).status != HidFeature::Status::ok);
  }
  CHECK(hid_devices().empty());
}

TEST_CASE("a device that comes back within the patience is found again and says so once") {
  MockedHidraw device(reference(MockedHidraw::Node::pty));
  HidapiTransport transport("/dev/hidraw0", a_clock(), Duration{60'000'000'000});
  std::array<std::byte, 64> buffer;
  for (int round = 0; round < 3; ++round) {
    REQUIRE(device.send(input(1)));
    REQUIRE(eventually([&] { return transport.read(buffer).status == HidRead::Status::report; }));
    device.unplug();
    REQUIRE(eventually([&] {
      REQUIRE(transport.read(buffer).status != HidRead::Status::gone);
      return transport.times_unplugged() == round + 1;
    }));
    CHECK(transport.read(buffer).status == HidRead::Status::away);
    CHECK(transport.write_newest(output(2)) == HidWrite::rejected);
    device.plug_in();
    REQUIRE(eventually([&] { return transport.read(buffer).status == HidRead::Status::returned; }));
    CHECK(transport.read(buffer).status == HidRead::Status::nothing);
    const std::size_t before = device.outputs().size();
    transport.write(output(7));
    REQUIRE(eventually([&] { return device.outputs().size() == before + 1; }));
  }
}

TEST_CASE("a device that does not come back within the patience is gone") {
  MockedHidraw device(reference(MockedHidraw::Node::pty));
  HidapiTransport transport("/dev/hidraw0", a_clock(), Duration{300'000'000});
  std::array<std::byte, 64> buffer;
  device.unplug();
  REQUIRE(eventually([&] { return transport.read(buffer).status == HidRead::Status::gone; }));
  CHECK(transport.write(output(1)) == HidWrite::gone);
  CHECK(transport.times_unplugged() == 1);
}
