/// The transport and the driver on the kernel's own HID core and hidraw.

#include <array>

#include "catch.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/reference_driver.h"
#include "kernel_bench.h"
#include "uhid_device.h"

using namespace evenstep;

namespace {

Bytes bytes(std::span<const std::byte> span) { return {span.begin(), span.end()}; }

UhidDevice::Spec reference() {
  UhidDevice::Spec spec;
  spec.report_descriptor = bytes(reference_device::report_descriptor());
  return spec;
}

Bytes input(std::uint32_t sequence) {
  return bytes(reference_device::encode(reference_device::InputReport{sequence, sequence, {1, 2, 3}}));
}
Bytes output(std::uint32_t sequence) {
  return bytes(reference_device::encode(reference_device::OutputReport{sequence, {4, 5, 6}}));
}

}  // namespace

TEST_CASE("the kernel lists the device and its descriptor byte for byte") {
  UhidDevice device(reference());
  const std::string node = device.node();
  REQUIRE(!node.empty());
  bool found = false;
  for (const HidListing& listing : hid_devices()) {
    if (listing.info.path != node) continue;
    found = true;
    CHECK(listing.info.vendor_id == reference_device::kVendorId);
    CHECK(listing.info.product_id == reference_device::kProductId);
    CHECK(listing.info.product == "evenstep reference device");
    CHECK(listing.info.serial == "SN0001");
    CHECK(listing.report_descriptor == bytes(reference_device::report_descriptor()));
    CHECK(listing.refusal.empty());
  }
  CHECK(found);
}

TEST_CASE("a thousand reports that are read in time all arrive in order") {
  UhidDevice device(reference());
  HidapiTransport transport(device.node(), a_clock());
  std::array<std::byte, 64> buffer;
  for (std::uint32_t sequence = 1; sequence <= 1000; ++sequence) {
    device.send(input(sequence));
    HidRead got;
    REQUIRE(eventually([&] { return (got = transport.read(buffer)).status != HidRead::Status::nothing; }));
    REQUIRE(got.status == HidRead::Status::report);
    REQUIRE(Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(got.size)) == input(sequence));
  }
}

TEST_CASE("a reader that stalls finds the first 63 reports and the driver counts the rest as lost") {
  UhidDevice device(reference());
  HidapiTransport transport(device.node(), a_clock());
  ReferenceDriver driver(transport);
  for (std::uint32_t sequence = 1; sequence <= 200; ++sequence) device.send(input(sequence));
  settle();
  CHECK(driver.read(RealTime{0}).sequence == 63);
  device.send(input(201));
  DeviceSample sample;
  REQUIRE(eventually([&] { return (sample = driver.read(RealTime{0})).fresh; }));
  CHECK(sample.sequence == 201);
  CHECK(driver.counters().lost == 137);
  CHECK(driver.counters().malformed == 0);
}

TEST_CASE("of reports that are wrong the kernel passes on only the long one and the driver takes its head") {
  UhidDevice device(reference());
  HidapiTransport transport(device.node(), a_clock());
  ReferenceDriver driver(transport);
  Bytes report = input(1);
  report.pop_back();
  device.send(report);  // too short
  report = input(2);
  report[0] = std::byte{9};
  device.send(report);  // with an id that is not declared
  report = input(3);
  report.resize(40, std::byte{0xEE});
  device.send(report);  // too long
  settle();
  const DeviceSample sample = driver.read(RealTime{0});
  CHECK(sample.sequence == 3);
  CHECK(driver.counters().reports == 1);
}

TEST_CASE("forces arrive at the device in order") {
  UhidDevice device(reference());
  HidapiTransport transport(device.node(), a_clock());
  std::vector<Bytes> sent;
  for (std::uint32_t sequence = 1; sequence <= 100; ++sequence) {
    sent.push_back(output(sequence));
    REQUIRE(transport.write(sent.back()) == HidWrite::ok);
    REQUIRE(eventually([&] { return device.outputs().size() == sequence; }));  // the queue of uhid holds 32
  }
  CHECK(device.outputs() == sent);
  REQUIRE(eventually([&] { return transport.write_times().taken.count() == 100; }));
}

TEST_CASE("an unplugged device is gone, or away and found again") {
  UhidDevice device(reference());
  std::array<std::byte, 64> buffer;
  {
    HidapiTransport transport(device.node(), a_clock());
    device.unplug();
    REQUIRE(eventually([&] { return transport.read(buffer).status == HidRead::Status::gone; }));
    CHECK(transport.write(output(1)) == HidWrite::gone);
    device.plug_in();
  }
  HidapiTransport patient(device.node(), a_clock(), Duration{30'000'000'000});
  device.unplug();
  REQUIRE(
      eventually([&] { return patient.read(buffer).status == HidRead::Status::away && patient.times_unplugged() == 1; }));
  device.plug_in();
  REQUIRE(eventually([&] { return patient.read(buffer).status == HidRead::Status::returned; }));
  REQUIRE(patient.write(output(2)) == HidWrite::ok);
  REQUIRE(eventually([&] { return !device.outputs().empty() && device.outputs().back() == output(2); }));
}

TEST_CASE("feature reports pass through the kernel both ways") {
  UhidDevice::Spec spec;
  for (const int b : {0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08,  //
                      0x85, 0x01, 0x95, 0x02, 0x09, 0x02, 0x81, 0x02,                                      //
                      0x85, 0x11, 0x95, 0x02, 0x09, 0x05, 0xB1, 0x02,                                      //
                      0x85, 0x13, 0x95, 0x04, 0x09, 0x06, 0xB1, 0x02, 0xC0})
    spec.report_descriptor.push_back(static_cast<std::byte>(b));
  UhidDevice device(spec);
  const Bytes pool{std::byte{0x13}, std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}};
  device.answer_feature(pool);
  HidapiTransport transport(device.node(), a_clock());
  Bytes report(16);
  report[0] = std::byte{0x13};
  const HidFeature got = transport.get_feature(report);
  REQUIRE(got.status == HidFeature::Status::ok);
  CHECK(Bytes(report.begin(), report.begin() + static_cast<std::ptrdiff_t>(got.size)) == pool);
  report[0] = std::byte{0x11};
  CHECK(transport.get_feature(report).status == HidFeature::Status::rejected);
  const Bytes create{std::byte{0x11}, std::byte{7}, std::byte{8}};
  CHECK(transport.set_feature(create) == HidWrite::ok);
  CHECK(device.features_set() == std::vector<Bytes>{create});
}
