
#include <algorithm>
#include <deque>
#include <limits>
#include <random>
#include <vector>

#include "cases.h"
#include "catch.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/reference_driver.h"

using namespace evenstep;
using reference_device::InputReport;

namespace {

using Bytes = std::vector<std::byte>;

/// Plays back its script. After that it has nothing, or repeats the last entry for ever.
class ScriptedTransport final : public HidTransport {
 public:
  void say(HidRead::Status status, Bytes bytes = {}) { script_.push_back({status, std::move(bytes)}); }
  void report(std::uint32_t sequence, std::int32_t x_nm = 0) {
    const auto bytes = reference_device::encode(InputReport{sequence, 0, {x_nm, 0, 0}});
    say(HidRead::Status::report, Bytes(bytes.begin(), bytes.end()));
  }

  HidRead read(std::span<std::byte> buffer) override {
    ++reads;
    if (script_.empty()) return {HidRead::Status::nothing};
    const auto [status, bytes] = script_.front();
    if (!endless) script_.pop_front();
    std::copy_n(bytes.begin(), std::min(bytes.size(), buffer.size()), buffer.begin());
    return {status, bytes.size()};
  }
  HidWrite write(std::span<const std::byte> report) override {
    written.emplace_back(report.begin(), report.end());
    return write_result;
  }
  std::span<const std::byte> report_descriptor() const override { return reference_device::report_descriptor(); }
  const HidDeviceInfo& info() const override { return info_; }

  bool endless = false;
  int reads = 0;
  HidWrite write_result = HidWrite::ok;
  std::vector<Bytes> written;

 private:
  std::deque<std::pair<HidRead::Status, Bytes>> script_;
  HidDeviceInfo info_{"/dev/hidraw7", 0x1209, 0x0E57, "scripted", ""};
};

struct ReferenceDriverBench {
  ScriptedTransport transport;
  ReferenceDriver driver{transport};
};

}  // namespace

TEST_CASE("a read drains the queue and the newest report wins") {
  for (std::uint32_t queued = 1; queued <= 100; ++queued) {
    ReferenceDriverBench bench;
    for (std::uint32_t i = 1; i <= queued; ++i) bench.transport.report(i, static_cast<std::int32_t>(i) * 1000 + 1);
    const DeviceSample sample = bench.driver.read(RealTime{17});
    CHECK((sample.fresh && sample.sequence == queued && sample.read_at == RealTime{17}));
    CHECK(sample.position_m == glm::dvec3((queued * 1000 + 1) / 1e9, 0, 0));
    CHECK((bench.driver.counters().reports == queued && bench.driver.counters().lost == 0 &&
           bench.driver.counters().stale == 0));
    CHECK_FALSE(bench.driver.read(RealTime{18}).fresh);
  }
}

TEST_CASE("every missing sequence number is counted as lost, over the wrap-around too, 100,000 reports") {
  std::mt19937_64 random(1);
  ReferenceDriverBench bench;
  std::uint32_t sequence = static_cast<std::uint32_t>(-50'000);
  bench.transport.report(sequence);
  bench.driver.read(RealTime{0});
  CHECK(bench.driver.counters().lost == 0);  // the first report is the base, whatever its number
  std::int64_t lost = 0;
  for (int i = 0; i < 100'000; ++i) {
    const std::uint32_t gap = random() % 4 ? 0 : static_cast<std::uint32_t>(random() % (random() % 100 ? 5 : 1'000'000));
    sequence += 1 + gap;
    lost += gap;
    bench.transport.report(sequence);
    if (random() % 3) continue;
    REQUIRE(bench.driver.read(RealTime{i}).sequence == sequence);
    REQUIRE(bench.driver.counters().lost == lost);
  }
}

TEST_CASE("late and repeated reports change nothing and are not lost, for every distance a queue can have") {
  for (const std::uint32_t base : {100u, 0u, 63u, 0xFFFFFFFFu}) {
    for (std::uint32_t behind = 0; behind <= 64; ++behind) {
      ReferenceDriverBench bench;
      bench.transport.report(base, 5000);
      bench.driver.read(RealTime{0});
      bench.transport.report(base - behind, 9000);
      const DeviceSample sample = bench.driver.read(RealTime{1});
      CHECK((!sample.fresh && sample.sequence == base && sample.position_m.x == 5000 / 1e9));
      CHECK(
          (bench.driver.counters().lost == 0 && bench.driver.counters().stale == 1 && bench.driver.counters().reports == 2));
    }
  }
}

TEST_CASE("a device that counts anew is followed, without a loss") {
  for (const std::uint32_t base : {66u, 1000u, 0x7FFFFFFFu}) {
    ReferenceDriverBench bench;
    bench.transport.report(base, 5000);
    bench.driver.read(RealTime{0});
    bench.transport.report(1, 9000);
    bench.transport.report(2, 9001);
    const DeviceSample sample = bench.driver.read(RealTime{1});
    CHECK((sample.fresh && sample.sequence == 2 && sample.position_m.x == 9001 / 1e9));
    CHECK(bench.driver.counters().lost == 0);
  }
}

TEST_CASE("a driver whose device returns reads it as a new one does: 500 random pasts, with a clock and without") {
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(500); ++seed) {
    std::mt19937_64 random(seed);
    const auto clock = [&] { return seed % 2 == 0 ? std::optional<DeviceClock>(DeviceClock()) : std::nullopt; };
    ScriptedTransport old_transport, new_transport;
    ReferenceDriver old_driver(old_transport, clock()), new_driver(new_transport, clock());
    auto sequence = static_cast<std::uint32_t>(random());
    auto stamp_us = static_cast<std::uint32_t>(random());
    const auto report = [&] {
      const auto x_nm = static_cast<std::int32_t>(random() % 50 == 0 ? 0x7FFF'FFFF : random() % 1'000'000);
      const auto bytes = reference_device::encode(InputReport{sequence, stamp_us, {x_nm, 0, 0}});
      sequence += 1 + static_cast<std::uint32_t>(random() % 20 == 0 ? random() % 5 : 0);
      stamp_us += 1000;
      return Bytes(bytes.begin(), bytes.end());
    };
    std::int64_t tick = 0;
    for (auto k = static_cast<std::int64_t>(random() % 200); k > 0; --k) {
      if (random() % 10 != 0) old_transport.say(HidRead::Status::report, report());
      old_driver.read(RealTime{++tick * 1'000'000});
    }
    old_transport.say(HidRead::Status::away);
    CHECK(old_driver.read(RealTime{++tick * 1'000'000}).away);
    old_transport.say(HidRead::Status::returned);
    CHECK(old_driver.read(RealTime{++tick * 1'000'000}).away);
    if (random() % 4 != 0) sequence = static_cast<std::uint32_t>(random());  // or one that goes on as if nothing had been
    stamp_us = static_cast<std::uint32_t>(random());
    const DeviceCounters before = old_driver.counters();
    for (int k = 0; k < 100; ++k) {
      if (k == 0 || random() % 10 != 0) {
        const Bytes bytes = report();
        old_transport.say(HidRead::Status::report, bytes);
        new_transport.say(HidRead::Status::report, bytes);
      }
      const RealTime now{++tick * 1'000'000};
      const DeviceSample a = old_driver.read(now), b = new_driver.read(now);
      INFO("seed " << seed << ", read " << k);
      REQUIRE((a.fresh == b.fresh && a.drivable == b.drivable && a.away == b.away && a.at_range == b.at_range));
      REQUIRE((a.sequence == b.sequence && a.position_m == b.position_m && a.taken_at == b.taken_at));
    }
    REQUIRE(old_driver.counters().lost - before.lost == new_driver.counters().lost);
    REQUIRE(old_driver.counters().stale - before.stale == new_driver.counters().stale);
  }
}

TEST_CASE("malformed reports are counted and skipped: every wrong length and every wrong id") {
  ReferenceDriverBench bench;
  std::int64_t malformed = 0;
  const auto whole = reference_device::encode(InputReport{1, 2, {3, 4, 5}});
  for (std::size_t size = 0; size < whole.size(); ++size, ++malformed) {
    bench.transport.say(HidRead::Status::report, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
  }
  for (int id = 0; id < 256; ++id) {
    if (id == 1) continue;
    Bytes bytes(whole.begin(), whole.end());
    bytes[0] = static_cast<std::byte>(id);
    bench.transport.say(HidRead::Status::report, bytes);
    ++malformed;
  }
  bench.transport.report(1, 77);
  CHECK(bench.driver.read(RealTime{0}).position_m.x == 77 / 1e9);
  CHECK((bench.driver.counters().malformed == malformed && bench.driver.counters().reports == 1));
}

TEST_CASE("a report longer than ours, even than the buffer, is read from its head") {
  for (const std::size_t size : {22, 64, 65, 4096}) {
    ReferenceDriverBench bench;
    const auto whole = reference_device::encode(InputReport{3, 0, {-12, 0, 0}});
    Bytes bytes(whole.begin(), whole.end());
    bytes.resize(size, std::byte{0xAA});
    bench.transport.say(HidRead::Status::report, bytes);
    CHECK(bench.driver.read(RealTime{0}).position_m.x == -12 / 1e9);
    CHECK(bench.driver.counters().malformed == 0);
  }
}

TEST_CASE("an interrupted read is repeated at once") {
  ReferenceDriverBench bench;
  for (std::uint32_t i = 1; i <= 20; ++i) {
    bench.transport.say(HidRead::Status::interrupted);
    bench.transport.report(i);
  }
  CHECK(bench.driver.read(RealTime{0}).sequence == 20);
}

TEST_CASE("a device that never stops talking, or interrupts for ever, cannot hang a tick") {
  ReferenceDriverBench babbling;
  babbling.transport.endless = true;
  babbling.transport.report(1);
  CHECK(babbling.driver.read(RealTime{0}).fresh);
  CHECK(babbling.transport.reads == 1024);
  ReferenceDriverBench interrupted;
  interrupted.transport.endless = true;
  interrupted.transport.say(HidRead::Status::interrupted);
  CHECK_FALSE(interrupted.driver.read(RealTime{0}).fresh);
  CHECK(interrupted.transport.reads == 1024);
}

TEST_CASE("what one read leaves is there for the next: 1025 reports") {
  ReferenceDriverBench bench;
  for (std::uint32_t i = 1; i <= 1025; ++i) bench.transport.report(i);
  CHECK(bench.driver.read(RealTime{0}).sequence == 1024);
  CHECK(bench.driver.read(RealTime{1}).sequence == 1025);
  CHECK(bench.driver.counters().lost == 0);
}

TEST_CASE("without a fresh report the last position holds, at the new time, and stale counts") {
  ReferenceDriverBench bench;
  CHECK(bench.driver.read(RealTime{1}).position_m == glm::dvec3(0));
  bench.transport.report(9, 123'456'789);
  bench.driver.read(RealTime{2});
  for (std::int64_t i = 3; i < 10; ++i) {
    const DeviceSample sample = bench.driver.read(RealTime{i});
    CHECK((!sample.fresh && sample.sequence == 9 && sample.read_at == RealTime{i}));
    CHECK(sample.position_m.x == 123'456'789 / 1e9);
    CHECK(bench.driver.counters().stale == i - 1);
  }
}

TEST_CASE("a device that is gone is an error that names it, on read and on write") {
  ReferenceDriverBench bench;
  bench.transport.report(1);
  bench.transport.say(HidRead::Status::gone);
  CHECK_THROWS_AS(bench.driver.read(RealTime{0}), DeviceError);
  bench.transport.write_result = HidWrite::gone;
  CHECK_THROWS_WITH(bench.driver.write(glm::dvec3(0)), Catch::Contains("/dev/hidraw7") && Catch::Contains("scripted"));
}

TEST_CASE("forces go out in micronewtons, numbered from 1, saturated") {
  ReferenceDriverBench bench;
  const std::vector<glm::dvec3> forces{{1, -2, 0.000001}, {0, 0, 0}, {1e9, -1e9, 2147.483647}};
  for (const glm::dvec3& force : forces) bench.driver.write(force);
  const std::vector<std::array<std::int32_t, 3>> expected{
      {1'000'000, -2'000'000, 1}, {0, 0, 0}, {INT32_MAX, INT32_MIN, INT32_MAX}};
  REQUIRE(bench.transport.written.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto report = reference_device::decode_output(bench.transport.written[i]);
    REQUIRE((report && bench.transport.written[i].size() == reference_device::kOutputSize));
    CHECK((report->sequence == i + 1 && report->force_uN == expected[i]));
  }
}

TEST_CASE("a rejected write is counted and leaves a gap in the numbers, not an error") {
  ReferenceDriverBench bench;
  bench.transport.write_result = HidWrite::rejected;
  for (int i = 0; i < 5; ++i) bench.driver.write({1, 0, 0});
  bench.transport.write_result = HidWrite::ok;
  bench.driver.write({1, 0, 0});
  CHECK(bench.driver.counters().write_failures == 5);
  CHECK(reference_device::decode_output(bench.transport.written.back())->sequence == 6);
}

TEST_CASE("a driver that stops says no force, three times where the device does not take it, and is silent about it") {
  for (const auto& [result, times] : {std::pair{HidWrite::ok, 1u}, {HidWrite::rejected, 3u}, {HidWrite::gone, 1u}}) {
    ReferenceDriverBench bench;
    bench.driver.write({1, 2, 3});
    bench.transport.write_result = result;
    bench.driver.stop();
    REQUIRE(bench.transport.written.size() == 1 + times);
    for (std::size_t i = 1; i <= times; ++i)
      CHECK(reference_device::decode_output(bench.transport.written[i])->force_uN == std::array<std::int32_t, 3>{});
    CHECK(bench.driver.counters().write_failures == 0);
  }
}

TEST_CASE("a position at either end of what a report can carry is marked, and one count less is not") {
  using Limits = std::numeric_limits<std::int32_t>;
  for (const auto& [nm, is_end] :
       {std::pair(Limits::max(), true), std::pair(Limits::max() - 1, false), std::pair(Limits::min(), true),
        std::pair(Limits::min() + 1, false), std::pair(0, false)}) {
    ReferenceDriverBench bench;
    bench.transport.report(1, nm);
    CHECK(bench.driver.read(RealTime{}).at_range == is_end);
    CHECK(bench.driver.read(RealTime{1}).at_range == is_end);  // still there: no new report
    bench.transport.report(2, 5);
    CHECK_FALSE(bench.driver.read(RealTime{2}).at_range);
  }
}

TEST_CASE("with a clock a sample says when it was taken, and a stale one says when the last one was") {
  ScriptedTransport transport;
  ReferenceDriver driver(transport, DeviceClock{});
  const auto report = [&](std::uint32_t sequence, std::uint32_t stamp_us) {
    const auto bytes = reference_device::encode(InputReport{sequence, stamp_us, {}});
    transport.say(HidRead::Status::report, Bytes(bytes.begin(), bytes.end()));
  };
  const auto read_ms = [&](double ms) { return driver.read(RealTime{static_cast<std::int64_t>(ms * 1e6)}); };
  const DeviceSample before = read_ms(0);
  CHECK((!before.fresh && before.taken_at < RealTime{-1'000'000'000}));  // older than any report can be
  report(1, 0xFFFFFFFF - 999);
  CHECK(read_ms(10).taken_at == RealTime{10'000'000});
  report(2, 0);  // the clock has wrapped around after 1 ms, and the report is read 0.7 ms late
  CHECK(read_ms(11.7).taken_at == RealTime{11'000'000});
  const DeviceSample stale = read_ms(12);
  CHECK((!stale.fresh && stale.read_at == RealTime{12'000'000} && stale.taken_at == RealTime{11'000'000}));
  report(4, 2'000);
  report(3, 1'000);  // this one came late, so the newer one counts
  CHECK(read_ms(13.5).taken_at == RealTime{13'000'000});
  REQUIRE(driver.ages());
  CHECK((driver.ages()->ages.count() == 3 && driver.ages()->ages.largest() == Duration{700'000}));
  CHECK((driver.ages()->restarts == 0 && driver.ages()->capped == 0 && !driver.ages()->clock_rate_error));

  report(1000, 5);  // a device that was reset goes on counting its reports, or does not: times begin again with both
  CHECK(read_ms(20).taken_at == RealTime{20'000'000});
  report(1, 7);
  CHECK(read_ms(30).taken_at == RealTime{30'000'000});
  CHECK(driver.ages()->restarts == 2);
}

TEST_CASE("without a clock nothing says how old a sample is") {
  ReferenceDriverBench bench;
  bench.transport.report(1);
  CHECK_FALSE(bench.driver.read(RealTime{5}).taken_at);
  CHECK(bench.driver.ages() == nullptr);
}
