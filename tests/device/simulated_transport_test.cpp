
#include <array>
#include <deque>
#include <random>
#include <vector>

#include "catch.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "units.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const ConstantVelocity kSteadyHand{{0.1, -0.05, 0}, Duration{0}};

struct TransportBench {
  explicit TransportBench(SimulatedDeviceOptions options, Motion motion = kSteadyHand)
      : transport(clock, ProgrammedMotion{std::move(motion), RealTime{0}}, options) {}
  DeviceSample read_at(std::int64_t ns) {
    clock.wait_until(RealTime{ns});
    return driver.read(clock.now());
  }
  VirtualClock clock;
  SimulatedTransport transport;
  ReferenceDriver driver{transport};
};

/// The sequence numbers of all reports that are queued now.
std::vector<std::uint32_t> drain(SimulatedTransport& transport) {
  std::vector<std::uint32_t> sequences;
  std::array<std::byte, 64> buffer;
  for (;;) {
    const HidRead got = transport.read(buffer);
    if (got.status != HidRead::Status::report) return sequences;
    sequences.push_back(reference_device::decode_input(std::span(buffer).first(got.size))->sequence);
  }
}

std::vector<std::uint32_t> from_to(std::uint32_t first, std::uint32_t last) {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t n = first; n <= last; ++n) numbers.push_back(n);
  return numbers;
}

}  // namespace

TEST_CASE("read at every tick, each position arrives exactly, at every rate, phase and policy") {
  for (const Rate rate : {Rate{1000, 1}, Rate{4000, 1}, Rate{1, 3}, Rate{1000, 3}, Rate{450, 1}}) {
    for (const std::int64_t phase : {std::int64_t{0}, std::int64_t{123'457}, kSecond}) {
      for (const QueuePolicy policy : {QueuePolicy::hidraw, QueuePolicy::libusb}) {
        TransportBench bench({rate, RealTime{phase}, policy});
        for (std::int64_t k = 0; k < 1000; ++k) {
          const RealTime at = tick_time(rate, k, RealTime{phase});
          const DeviceSample sample = bench.read_at(at.ns);
          const auto nm = reference_device::to_nm(position_m(kSteadyHand, at));
          REQUIRE((sample.fresh && sample.sequence == k + 1 && sample.read_at == at));
          for (int axis = 0; axis < 3; ++axis) REQUIRE(sample.position_m[axis] == nm[static_cast<std::size_t>(axis)] / 1e9);
        }
        CHECK((bench.driver.counters().reports == 1000 && bench.driver.counters().lost == 0 &&
               bench.driver.counters().stale == 0));
        CHECK(bench.transport.dropped() == 0);
      }
    }
  }
}

TEST_CASE("at 1 kHz a hand of 0.1 m/s moves by exactly 100,000 nm per report") {
  TransportBench bench({});
  for (std::int64_t k = 0; k < 20'000; ++k)
    REQUIRE(bench.read_at(k * kMs).position_m.x == static_cast<double>(100'000 * k) / 1e9);
}

TEST_CASE("a tick reports at its very nanosecond, not before") {
  TransportBench bench({{3, 1}, RealTime{500}});
  CHECK_FALSE(bench.read_at(499).fresh);
  CHECK(bench.read_at(500).sequence == 1);
  CHECK_FALSE(bench.read_at(333'333'832).fresh);
  CHECK(bench.read_at(333'333'833).sequence == 2);
}

TEST_CASE("a reader that sleeps 100 ms sees the oldest 63 reports under hidraw and the newest 32 under libusb") {
  TransportBench hidraw({{1000, 1}, RealTime{0}, QueuePolicy::hidraw});
  TransportBench libusb({{1000, 1}, RealTime{0}, QueuePolicy::libusb});
  std::uint32_t reported = 0;
  for (std::int64_t nap = 1; nap <= 50; ++nap) {
    const std::uint32_t first = reported + 1;
    reported = static_cast<std::uint32_t>(100 * nap + 1);
    for (TransportBench* bench : {&hidraw, &libusb}) bench->clock.wait_until(RealTime{nap * 100 * kMs});
    CHECK(drain(hidraw.transport) == from_to(first, first + 62));
    CHECK(drain(libusb.transport) == from_to(reported - 31, reported));
  }
  CHECK(hidraw.transport.dropped() == 5001 - 50 * 63);
  CHECK(libusb.transport.dropped() == 5001 - 50 * 32);
}

TEST_CASE("after a stall the hand is 37 ms old under hidraw and fresh under libusb, and the driver counts the loss") {
  TransportBench hidraw({{1000, 1}, RealTime{0}, QueuePolicy::hidraw});
  TransportBench libusb({{1000, 1}, RealTime{0}, QueuePolicy::libusb});
  for (TransportBench* bench : {&hidraw, &libusb}) bench->read_at(0);
  CHECK(hidraw.read_at(100 * kMs).position_m.x == 63 * 100'000 / 1e9);
  CHECK(libusb.read_at(100 * kMs).position_m.x == 100 * 100'000 / 1e9);
  CHECK((hidraw.driver.counters().lost == 0 && libusb.driver.counters().lost == 68));
  // With hidraw the gap lies behind the queued reports, so it shows with the next report.
  CHECK(hidraw.read_at(101 * kMs).position_m.x == 101 * 100'000 / 1e9);
  CHECK(hidraw.driver.counters().lost == 37);
}

TEST_CASE("the queue is full at its depth and drops from one more on") {
  const std::array<std::pair<QueuePolicy, std::int64_t>, 2> depths{{{QueuePolicy::hidraw, 63}, {QueuePolicy::libusb, 32}}};
  for (const auto& [policy, depth] : depths) {
    for (std::int64_t reports = 1; reports <= 200; ++reports) {
      TransportBench bench({{1000, 1}, RealTime{kMs}, policy});
      bench.clock.wait_until(RealTime{reports * kMs});
      CHECK(static_cast<std::int64_t>(drain(bench.transport).size()) == std::min(reports, depth));
      CHECK(bench.transport.dropped() == std::max<std::int64_t>(0, reports - depth));
    }
  }
}

TEST_CASE("pauses and partial reads give what a queue filled report by report would hold, 20,000 random calls") {
  for (const QueuePolicy policy : {QueuePolicy::hidraw, QueuePolicy::libusb}) {
    std::mt19937_64 random(1);
    TransportBench bench({{1000, 1}, RealTime{0}, policy});
    std::deque<std::uint32_t> queue;
    std::int64_t dropped = 0, next_tick = 0, now_ns = 0;
    for (int call = 0; call < 20'000; ++call) {
      if (random() % 3 == 0) now_ns += static_cast<std::int64_t>(random() % (random() % 4 ? 10 : 150)) * kMs / 2;
      bench.clock.wait_until(RealTime{now_ns});
      for (; next_tick * kMs <= now_ns; ++next_tick) {
        if (policy == QueuePolicy::hidraw && queue.size() == 63) {
          ++dropped;
          continue;
        }
        queue.push_back(static_cast<std::uint32_t>(next_tick + 1));
        if (policy == QueuePolicy::hidraw || queue.size() <= 32) continue;
        queue.pop_front();
        ++dropped;
      }
      std::array<std::byte, 21> buffer;
      const HidRead got = bench.transport.read(buffer);
      REQUIRE((got.status == HidRead::Status::report) == !queue.empty());
      REQUIRE(bench.transport.dropped() == dropped);
      if (queue.empty()) continue;
      REQUIRE(reference_device::decode_input(buffer)->sequence == queue.front());
      queue.pop_front();
    }
    CHECK(dropped > 1000);
  }
}

TEST_CASE("a stall of thirty years costs one queue of work") {
  // A loop over these 1e12 reports would not return before the test's time-out.
  const std::int64_t ticks = 1'000'000'000'000;
  TransportBench hidraw({{1000, 1}, RealTime{kMs}, QueuePolicy::hidraw});
  TransportBench libusb({{1000, 1}, RealTime{kMs}, QueuePolicy::libusb});
  for (TransportBench* bench : {&hidraw, &libusb}) bench->clock.wait_until(RealTime{ticks * kMs});
  CHECK(drain(hidraw.transport) == from_to(1, 63));
  const auto newest = static_cast<std::uint32_t>(ticks);
  CHECK(drain(libusb.transport) == from_to(newest - 31, newest));
  CHECK((hidraw.transport.dropped() == ticks - 63 && libusb.transport.dropped() == ticks - 32));
}

TEST_CASE("from its tick on an unplugged device is gone, with reports queued or not, for reads and writes") {
  const auto force = reference_device::encode(reference_device::OutputReport{1, {}});
  std::array<std::byte, 21> buffer;
  for (std::int64_t tick = 0; tick < 200; ++tick) {
    TransportBench bench({{1000, 1}, RealTime{kMs}, QueuePolicy::hidraw, tick});
    bench.clock.wait_until(RealTime{(tick + 1) * kMs - 1});
    CHECK(bench.transport.read(buffer).status == (tick > 0 ? HidRead::Status::report : HidRead::Status::nothing));
    CHECK(bench.transport.write(force) == HidWrite::ok);
    bench.clock.wait_until(RealTime{(tick + 1) * kMs});
    CHECK(bench.transport.write(force) == HidWrite::gone);
    CHECK(bench.transport.read(buffer).status == HidRead::Status::gone);
    CHECK_THROWS_AS(bench.driver.read(bench.clock.now()), DeviceError);
    CHECK_THROWS_AS(bench.driver.write(glm::dvec3(0)), DeviceError);
  }
}

TEST_CASE("the device renders the last force it was sent, and a malformed one changes nothing") {
  TransportBench bench({});
  CHECK(bench.transport.output().sequence == 0);
  for (int i = 1; i <= 1000; ++i) {
    bench.driver.write({i * 0.001, -i * 0.002, 0});
    CHECK(bench.transport.output().sequence == static_cast<std::uint32_t>(i));
    CHECK(bench.transport.output().force_uN == std::array<std::int32_t, 3>{i * 1000, -i * 2000, 0});
  }
  const auto whole = reference_device::encode(reference_device::OutputReport{7, {1, 2, 3}});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CHECK(bench.transport.write(std::span(whole).first(size)) == HidWrite::rejected);
  }
  CHECK(bench.transport.output().sequence == 1000);
}

TEST_CASE("a short buffer takes the head of a report and learns its whole size") {
  for (std::size_t size = 0; size <= 21; ++size) {
    TransportBench bench({});
    std::vector<std::byte> buffer(size);
    const HidRead got = bench.transport.read(buffer);
    CHECK((got.status == HidRead::Status::report && got.size == 21));
    const auto whole = reference_device::encode(reference_device::InputReport{1, 0, {}});
    CHECK(std::equal(buffer.begin(), buffer.end(), whole.begin()));
    CHECK(bench.transport.read(buffer).status == HidRead::Status::nothing);
  }
}

TEST_CASE("device time is the tick's time in whole microseconds, floored, modulo 2^32") {
  const Rate rate{3, 1};
  std::array<std::byte, 21> buffer;
  // 2^32 us are reached at tick 12,884.9, within this sweep.
  for (std::int64_t tick = 12'800; tick < 13'000; ++tick) {
    TransportBench bench({rate, RealTime{}, QueuePolicy::libusb});
    bench.clock.wait_until(tick_time(rate, tick));
    reference_device::InputReport newest;
    while (bench.transport.read(buffer).status == HidRead::Status::report) newest = *reference_device::decode_input(buffer);
    CHECK(newest.sequence == tick + 1);
    CHECK(newest.device_time_us == tick * 1'000'000 / 3 % (std::int64_t{1} << 32));
  }
}

TEST_CASE("the simulated device says what it is") {
  TransportBench bench({});
  CHECK((bench.transport.info().vendor_id == 0x1209 && bench.transport.info().product_id == 0x0E57));
  CHECK(bench.transport.report_descriptor().data() == reference_device::report_descriptor().data());
}
