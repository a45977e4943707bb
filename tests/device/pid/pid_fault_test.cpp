// What can go wrong between a device and its driver: for the reference device and for both flavours of PID devices.
#include <cmath>
#include <deque>
#include <map>
#include <random>

#include "cases.h"
#include "catch.h"
#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "pid_bench.h"

using namespace evenstep;
using namespace evenstep::test;
using Kind = ReportFault::Kind;

namespace {

const ConstantVelocity kMovingHand{{0.1, -0.05, 0}, Duration{0}};
constexpr std::array<QueuePolicy, 2> kPolicies{QueuePolicy::hidraw, QueuePolicy::libusb};

struct ReferenceBench {
  explicit ReferenceBench(std::vector<ReportFault> faults, QueuePolicy policy = QueuePolicy::hidraw)
      : transport(clock, ProgrammedMotion{kMovingHand, RealTime{}},
                  SimulatedDeviceOptions{.queue = policy, .faults = std::move(faults)}) {}
  DeviceSample read_at(std::int64_t tick) {
    clock.wait_until(RealTime{tick * kMs});
    return driver.read(clock.now());
  }
  VirtualClock clock;
  SimulatedTransport transport;
  ReferenceDriver driver{transport};
};

/// From call `from` on, `count` requests to the device end as `how` says.
class FailingTransport final : public HidTransport {
 public:
  FailingTransport(HidTransport& device, int from, int count, HidWrite how)
      : device_(device), from_(from), count_(count), how_(how) {}
  HidRead read(std::span<std::byte> buffer) override { return device_.read(buffer); }
  HidWrite write(std::span<const std::byte> report) override { return fails() ? how_ : device_.write(report); }
  HidWrite set_feature(std::span<const std::byte> report) override { return fails() ? how_ : device_.set_feature(report); }
  HidFeature get_feature(std::span<std::byte> report) override {
    using Status = HidFeature::Status;
    return fails() ? HidFeature{how_ == HidWrite::gone ? Status::gone : Status::rejected} : device_.get_feature(report);
  }
  std::span<const std::byte> report_descriptor() const override { return device_.report_descriptor(); }
  const HidDeviceInfo& info() const override { return device_.info(); }
  int calls = 0;

 private:
  bool fails() {
    const int call = calls++;
    return call >= from_ && call < from_ + count_;
  }
  HidTransport& device_;
  int from_, count_;
  HidWrite how_;
};

enum class State { before_start, at_rest, playing, stopped };

}  // namespace

TEST_CASE("reference device: each fault at each of 50 ticks shows in its counter alone and the next report is right") {
  struct Row {
    Kind kind;
    std::int64_t amount;
    DeviceCounters expected;  // reports: the difference from 100
  };
  const std::array<Row, 9> rows{{{Kind::lost, 1, {-1, 1, 0, 1}},
                                 {Kind::duplicated, 3, {3, 0, 0, 0}},
                                 {Kind::late, 2, {0, 1, 0, 1}},
                                 {Kind::cut, 20, {-1, 1, 1, 1}},
                                 {Kind::cut, 0, {-1, 1, 1, 1}},
                                 {Kind::longer, 19, {0, 0, 0, 0}},
                                 {Kind::longer, 4000, {0, 0, 0, 0}},
                                 {Kind::unknown_id, 1, {-1, 1, 1, 1}},
                                 {Kind::interrupted, 5, {0, 0, 0, 0}}}};
  for (const Row& row : rows) {
    for (std::int64_t at = 1; at <= 50; ++at) {
      for (const QueuePolicy policy : kPolicies) {
        ReferenceBench bench({{row.kind, at, row.amount}}, policy);
        for (std::int64_t tick = 0; tick < 100; ++tick) {
          const DeviceSample sample = bench.read_at(tick);
          // Whatever came is the newest report that existed, never an older one.
          const bool missing = tick == at && row.expected.stale > 0;
          REQUIRE(sample.fresh == !missing);
          REQUIRE(sample.position_m.x == static_cast<double>(100'000 * (tick - missing)) / 1e9);
        }
        const DeviceCounters& counted = bench.driver.counters();
        REQUIRE(counted.reports == 100 + row.expected.reports);
        REQUIRE((counted.lost == row.expected.lost && counted.malformed == row.expected.malformed &&
                 counted.stale == row.expected.stale));
      }
    }
  }
}

TEST_CASE("reference device: an output that is lost leaves the old force and one that is rejected is counted") {
  ReferenceBench bench({{Kind::write_lost, 10, 2}, {Kind::write_rejected, 20, 3}});
  for (std::int64_t tick = 0; tick < 40; ++tick) {
    bench.read_at(tick);
    bench.driver.write({tick * 0.001, 0, 0});
    const std::int64_t taken = tick >= 10 && tick < 12 ? 9 : tick >= 20 && tick < 23 ? 19 : tick;
    CHECK(bench.transport.output().force_uN[0] == taken * 1000);
    CHECK(bench.transport.output().sequence == static_cast<std::uint32_t>(taken + 1));
  }
  CHECK(bench.driver.counters().write_failures == 3);
}

TEST_CASE("faults on one tick add up and a lost report has no copies") {
  ReferenceBench bench({{Kind::duplicated, 5, 2}, {Kind::late, 5, 3}, {Kind::lost, 7, 1}, {Kind::duplicated, 7, 9}});
  std::vector<std::uint32_t> sequences;
  std::array<std::byte, 64> buffer;
  bench.clock.wait_until(RealTime{10 * kMs});
  while (bench.transport.read(buffer).status == HidRead::Status::report)
    sequences.push_back(reference_device::decode_input(buffer)->sequence);
  CHECK(sequences == std::vector<std::uint32_t>{1, 2, 3, 4, 5, 7, 9, 6, 6, 6, 10, 11});
}

TEST_CASE("random faults and pauses give what a queue filled report by report would hold in 20000 calls") {
  for (const QueuePolicy policy : kPolicies) {
    std::mt19937_64 random(5);
    std::vector<ReportFault> faults;
    for (std::int64_t tick = 0; tick < 40'000; tick += 1 + static_cast<std::int64_t>(random() % 40)) {
      const auto kind = std::array{Kind::lost, Kind::duplicated, Kind::late}[random() % 3];
      faults.push_back({kind, tick, 1 + static_cast<std::int64_t>(random() % 70)});
    }
    ReferenceBench bench(faults, policy);
    std::deque<std::uint32_t> queue;
    std::multimap<std::int64_t, std::uint32_t> late;
    std::int64_t dropped = 0, tick = 0, now = 0;
    const auto arrive = [&](std::uint32_t sequence) {
      if (policy == QueuePolicy::hidraw && queue.size() == 63) return static_cast<void>(++dropped);
      queue.push_back(sequence);
      if (policy == QueuePolicy::libusb && queue.size() > 32) queue.pop_front(), ++dropped;
    };
    std::size_t fault = 0;
    for (int call = 0; call < 20'000; ++call) {
      if (random() % 3 == 0) now += static_cast<std::int64_t>(random() % (random() % 4 ? 4 : 70));
      bench.clock.wait_until(RealTime{now * kMs});
      for (; tick <= now; ++tick) {
        const auto sequence = static_cast<std::uint32_t>(tick + 1);
        const bool faulty = fault < faults.size() && faults[fault].tick == tick;
        if (!faulty) arrive(sequence);
        if (faulty && faults[fault].kind == Kind::duplicated) {
          for (std::int64_t copy = 0; copy <= faults[fault].amount; ++copy) arrive(sequence);
        }
        if (faulty && faults[fault].kind == Kind::late) late.emplace(tick + faults[fault].amount, sequence);
        for (auto due = late.begin(); due != late.end() && due->first == tick; due = late.erase(due)) arrive(due->second);
        fault += faulty;
      }
      std::array<std::byte, 21> buffer;
      const HidRead got = bench.transport.read(buffer);
      REQUIRE((got.status == HidRead::Status::report) == !queue.empty());
      REQUIRE(bench.transport.dropped() == dropped);
      if (queue.empty()) continue;
      REQUIRE(reference_device::decode_input(buffer)->sequence == queue.front());
      queue.pop_front();
    }
    CHECK((dropped > 1000 && fault > 500));
  }
}

TEST_CASE("PID: whatever report fault in whatever state of the driver the force is as told and the position follows") {
  for (const PidFlavour flavour : kFlavours) {
    for (const QueuePolicy policy : kPolicies) {
      for (const State state : {State::before_start, State::at_rest, State::playing, State::stopped}) {
        for (int kind = 0; kind <= static_cast<int>(Kind::write_rejected); ++kind) {
          for (const std::int64_t amount : {1, 3, 40}) {
            INFO("kind " << kind << " amount " << amount << " state " << static_cast<int>(state));
            SimulatedPidOptions device = pid_device(flavour);
            device.reports.queue = policy;
            device.reports.faults = {{static_cast<Kind>(kind), 50, amount}};
            const bool hurts_writes =
                static_cast<Kind>(kind) == Kind::write_lost || static_cast<Kind>(kind) == Kind::write_rejected;
            PidBench bench(device, pid_options(), kMovingHand);
            const glm::dvec3 force{state == State::playing ? 1.0 : 0.0, 0.5 * (state == State::playing), 0};
            const std::int64_t start = state == State::before_start ? 120 : 0, stop = state == State::stopped ? 40 : 1000;
            // Before the start there are only reads. So a fault of writes cannot happen there and would hit the start.
            if (state == State::before_start && hurts_writes) continue;
            const double count_m = 0.4 / (flavour == PidFlavour::mask ? 65'534 : 4095);
            for (std::int64_t tick = 0; tick < 500; ++tick) {
              bench.clock.wait_until(RealTime{tick * kMs});
              if (tick == start) bench.driver->start();
              if (tick == stop) bench.driver->stop();
              const DeviceSample sample = bench.driver->read(bench.clock.now());
              if (tick >= start && tick < stop) bench.driver->write(force);
              if (sample.fresh && tick > 100) REQUIRE(std::abs(sample.position_m.x - tick * 1e-4) <= count_m);
              // The device never renders more than it was told, and exactly that when the fault is over.
              const glm::dvec3 rendered = bench.device.force_N();
              REQUIRE((rendered.x <= force.x + 3e-4 && rendered.x >= 0));
              const bool over = tick < 50 || tick > 350;
              if (over) REQUIRE(std::abs(rendered.x - (tick >= start && tick < stop ? force.x : 0)) <= 3e-4);
            }
            const DeviceCounters& counted = bench.driver->counters();
            const Kind hit = static_cast<Kind>(kind);
            const bool cuts = hit == Kind::cut && amount < (flavour == PidFlavour::mask ? 6 : 5);
            REQUIRE(counted.malformed == (cuts || hit == Kind::unknown_id ? 1 : 0));
            REQUIRE(counted.stale <= 1);
          }
        }
      }
    }
  }
}

TEST_CASE("PID: a rejected force is counted and sent again in the next tick and a lost one comes with the refresh") {
  for (const PidFlavour flavour : kFlavours) {
    SimulatedPidOptions device = pid_device(flavour);
    device.reports.faults = {{Kind::write_rejected, 20, 3}, {Kind::write_lost, 30, 1}};
    PidOptions options = pid_options();
    options.travel_m.y = 0;
    PidBench bench(device, options);
    bench.driver->start();
    for (std::int64_t tick = 0; tick < 300; ++tick) {
      const double force_N = tick < 20 ? 1 : tick < 30 ? 2 : 1.5;
      bench.tick_at(tick * kMs, {force_N, 0, 0});
      const double expected_N = tick >= 20 && tick < 23 ? 1 : tick >= 30 && tick < 250 ? 2 : force_N;
      REQUIRE(bench.device.force_N().x == Approx(expected_N).margin(3e-4));
    }
    CHECK(bench.driver->counters().write_failures == 3);
  }
}

TEST_CASE("PID: a refresh that is refused is tried again in the next tick before the effect ends") {
  SimulatedPidOptions device = pid_device(PidFlavour::mask);
  device.reports.faults = {{Kind::write_rejected, 50, 40}};
  PidOptions options = pid_options();
  options.travel_m.y = 0;
  options.effect_duration = Duration{100 * kMs};
  PidBench bench(device, options);
  bench.driver->start();
  for (std::int64_t tick = 0; tick < 120; ++tick) {
    bench.tick_at(tick * kMs, {1, 0, 0});
    REQUIRE(bench.device.playing() == 1);
    // Force and Start are refused for 20 ticks.
    REQUIRE(bench.driver->pid_counters().refreshes == (tick < 70 ? 1 : 2));
  }
  CHECK(bench.driver->counters().write_failures == 40);
}

TEST_CASE("PID: unplugged at any tick in any state it is an error that names the device and stop is quiet") {
  for (const PidFlavour flavour : kFlavours) {
    for (std::int64_t unplug = 0; unplug < 30; ++unplug) {
      for (const QueuePolicy policy : kPolicies) {
        SimulatedPidOptions device = pid_device(flavour);
        device.reports.unplug_at_tick = unplug;
        device.reports.queue = policy;
        PidBench bench(device);
        std::int64_t tick = 0;
        try {
          for (; tick < 40; ++tick) {
            bench.clock.wait_until(RealTime{tick * kMs});
            if (tick == 10) bench.driver->start();
            if (tick != 20) bench.driver->read(bench.clock.now());  // at tick 20 the write is the first call that notices
            if (tick >= 10) bench.driver->write({1, 0, 0});
          }
          FAIL("nobody noticed");
        } catch (const DeviceError& error) {
          CHECK_THAT(error.what(), Catch::Contains("simulated: device 'evenstep PID device' is gone"));
          // A tick that writes nothing new notices with the next read.
          CHECK((tick == unplug || (unplug == 20 && tick == 21)));
        }
        bench.driver->stop();
        CHECK(bench.device.force_N() == glm::dvec3(0));
        CHECK_THROWS_AS(bench.driver->read(bench.clock.now()), DeviceError);
      }
    }
  }
}

TEST_CASE("PID: whichever request of start fails nothing is left on the device") {
  for (const PidFlavour flavour : kFlavours) {
    for (const bool springs : {false, true}) {
      for (const HidWrite how : {HidWrite::rejected, HidWrite::gone}) {
        for (int call = 0;; ++call) {
          VirtualClock clock;
          SimulatedPidDevice device(clock, ProgrammedMotion{Still{}, RealTime{}}, pid_device(flavour));
          FailingTransport transport(device, call, how == HidWrite::gone ? 1 : 1000, how);
          PidOptions options = pid_options();
          options.springs = springs;
          if (springs) options.reversed_spring[0] = false;
          PidDriver driver(transport, layout_of(device), options);
          bool failed = false;
          try {
            driver.start();
          } catch (const DeviceError&) {
            failed = true;
          }
          const int made = transport.calls;
          if (!failed && made <= call) break;  // `call` is after the last request of start()
          REQUIRE(failed);
          // With `gone`, one request failed and those of stop() after it did not. With requests that are rejected for good,
          // the device cannot be stopped either.
          if (how == HidWrite::gone) REQUIRE((device.playing() == 0 && device.allocated() == 0));
          REQUIRE_THROWS_AS(driver.write({0, 0, 0}), DeviceError);
          REQUIRE(call < 100);
        }
      }
    }
  }
}

TEST_CASE("PID: a stop that is rejected twice is tried again") {
  for (const PidFlavour flavour : kFlavours) {
    for (int request = 0; request < 6; ++request) {
      VirtualClock clock;
      SimulatedPidDevice device(clock, ProgrammedMotion{Still{}, RealTime{}}, pid_device(flavour));
      FailingTransport counting(device, 1000, 0, HidWrite::ok);
      {
        PidDriver driver(counting, layout_of(device), pid_options());
        driver.start();
      }
      const int of_start = counting.calls - 6;
      FailingTransport transport(device, of_start + request, 2, HidWrite::rejected);
      PidDriver driver(transport, layout_of(device), pid_options());
      driver.start();
      driver.stop();
      CHECK((device.playing() == 0 && device.allocated() == 0 && !device.actuators_enabled()));
      CHECK(transport.calls == of_start + 8);
    }
  }
}

TEST_CASE("PID: interrupted feature requests are asked again") {
  SimulatedPidOptions device = pid_device(PidFlavour::mask);
  device.feature_interruptions = 30;
  PidBench bench(device);
  bench.driver->start();
  CHECK(bench.device.playing() == 2);
}

TEST_CASE("PID: a stall of 100 ms leaves the oldest 63 reports under hidraw and the newest 32 under libusb") {
  for (const PidFlavour flavour : kFlavours) {
    for (const QueuePolicy policy : kPolicies) {
      SimulatedPidOptions device = pid_device(flavour);
      device.reports.queue = policy;
      PidBench bench(device, pid_options(), kMovingHand);
      bench.clock.wait_until(RealTime{99 * kMs});
      const DeviceSample sample = bench.driver->read(bench.clock.now());
      const bool hidraw = policy == QueuePolicy::hidraw;
      CHECK(bench.driver->counters().reports == (hidraw ? 63 : 32));
      CHECK(sample.position_m.x == Approx((hidraw ? 62 : 99) * 1e-4).margin(6e-5));
      CHECK(bench.device.dropped() == (hidraw ? 37 : 68));
    }
  }
}

TEST_CASE("PID: malformed output reports are rejected and change nothing") {
  PidBench bench(pid_device(PidFlavour::mask));
  bench.driver->start();
  bench.tick_at(0, {1, 0, 0});
  const double before_N = bench.device.force_N().x;
  const std::array<std::byte, 22> bytes{};
  CHECK(bench.device.write({}) == HidWrite::rejected);
  const PidLayout layout = layout_of(bench.device);
  for (const PidReport& report :
       {layout.set_effect.report, layout.set_constant.report, layout.operation.report, layout.device_control->report}) {
    for (std::size_t size = 1; size < report.size; ++size) {
      std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      cut[0] = std::byte{report.id};
      CHECK(bench.device.write(cut) == HidWrite::rejected);
    }
  }
  CHECK(bench.device.force_N().x == before_N);
}

TEST_CASE("PID: 200000 random reports to the firmware end without harm and force within its full scale") {
  for (const PidFlavour flavour : kFlavours) {
    std::mt19937_64 random(7);
    PidBench bench(pid_device(flavour));
    std::array<std::byte, 24> bytes;
    for (int i = 0; i < evenstep::testing::cases(100'000); ++i) {
      for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() >> 20 & (random() % 2 ? 0x07 : 0xFF));
      if (random() % 4) bytes[0] = static_cast<std::byte>((flavour == PidFlavour::mask ? 0x10 : 0) + random() % 10);
      const auto report = std::span(bytes).first(random() % 25);
      switch (random() % 4) {
        case 0:
          bench.device.set_feature(report);
          break;
        case 1:
          bench.device.get_feature(report);
          break;
        default:
          bench.device.write(report);
      }
      if (random() % 8 == 0)
        bench.clock.wait_until(RealTime{bench.clock.now().ns + static_cast<std::int64_t>(random() % kMs)});
      const glm::dvec3 force = bench.device.force_N();
      for (int axis = 0; axis < 3; ++axis) REQUIRE(std::abs(force[axis]) <= 10);
    }
  }
}
