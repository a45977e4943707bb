/// A live run through the unmodified libhidapi, on a device that this process makes up: a thread reports a hand that moves
/// slowly.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "catch.h"
#include "evenstep/device/hid/pid_descriptors.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/run.h"
#include "mocked_hidraw.h"

using namespace evenstep;

namespace {

MockedHidraw::Spec reference() {
  MockedHidraw::Spec spec;
  spec.report_descriptor.assign(reference_device::report_descriptor().begin(), reference_device::report_descriptor().end());
  return spec;
}

Bytes reference_report(std::uint32_t sequence) {
  const auto encoded = reference_device::encode(
      reference_device::InputReport{sequence, sequence * 4000, {static_cast<std::int32_t>(sequence) * 40'000, 0, 0}});
  return {encoded.begin(), encoded.end()};
}

/// A report of the PID device of flavour `mask`: buttons, X and Y. X grows by 100 counts each time.
Bytes pid_report(std::uint32_t sequence) {
  const std::uint32_t x = sequence * 100;
  return {std::byte{1}, std::byte{0}, static_cast<std::byte>(x), static_cast<std::byte>(x >> 8), std::byte{0}, std::byte{0}};
}

/// Sends reports at some 250 Hz. It does not matter how late the thread is.
class Reporter {
 public:
  explicit Reporter(MockedHidraw& device, Bytes (*report)(std::uint32_t) = reference_report)
      : thread_([this, &device, report] {
          for (std::uint32_t sequence = 1; !stopped_; ++sequence) {
            device.send(report(sequence));
            std::this_thread::sleep_for(std::chrono::milliseconds(4));
          }
        }) {}
  ~Reporter() {
    stopped_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> stopped_{false};
  std::thread thread_;
};

RunOutcome live_run(bool forces, const std::atomic<bool>* interrupted = nullptr, std::vector<std::string> more = {}) {
  ReadOptions set{
      {"run.duration=\"1 s\"", "run.warmup=\"0.3 s\"", "device.0.rate=\"250 Hz\"", "device.0.guard={ramp_up=\"0.1 s\"}",
       "remap.lead=\"60 ms\"", "remap.latency=\"200 ms\"", "expect=[]", "run.strategies=[\"direct\", \"phase_locked\"]"},
      std::nullopt};
  set.set.insert(set.set.end(), more.begin(), more.end());
  const ReadResult read = read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/live/figure-1-spring.toml", set);
  for (const Diagnostic& error : read.error_or({})) FAIL(text(error));
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  options.control.interrupted = interrupted;
  options.devices = {{{"left", "/dev/hidraw0"}}, forces};
  return run_scenario(*read, options);
}

}  // namespace

TEST_CASE("a live run on a real transport renders forces and replays and ends with none") {
  MockedHidraw device(reference());
  const Reporter hand(device);
  const RunOutcome outcome = live_run(true);
  INFO(outcome.failure);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  const auto& force = outcome.metrics.at("left.force.phase_locked");
  CHECK(force.at("writes") > 0);
  CHECK(force.at("write_time_max") > 0);
  CHECK(force.at("malformed") == 0);
  const std::vector<Bytes> outputs = device.outputs();
  REQUIRE_FALSE(outputs.empty());
  bool any_force = false;
  for (const Bytes& bytes : outputs) any_force = any_force || reference_device::decode_output(bytes)->force_uN[0] != 0;
  CHECK(any_force);
  CHECK(reference_device::decode_output(outputs.back())->force_uN == std::array<std::int32_t, 3>{});
}

TEST_CASE("a run that is interrupted ends with no force") {
  MockedHidraw device(reference());
  const Reporter hand(device);
  std::atomic<bool> interrupted{false};
  std::thread person([&] {
    for (int i = 0; i < 60'000 && device.outputs().size() < 20; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    interrupted = true;
  });
  const RunOutcome outcome = live_run(true, &interrupted);
  person.join();
  CHECK(outcome.exit == ExitCode::interrupted);
  const std::vector<Bytes> outputs = device.outputs();
  REQUIRE(outputs.size() >= 20);
  CHECK(reference_device::decode_output(outputs.back())->force_uN == std::array<std::int32_t, 3>{});
}

TEST_CASE("a live run drives a PID device from its descriptor and leaves its actuators off") {
  MockedHidraw::Spec spec;
  spec.vendor_product = "00001209:0000F1D0";
  spec.report_descriptor = pid_descriptor({});
  MockedHidraw device(spec);
  device.answer_feature(
      {std::byte{0x21}, std::byte{1}, std::byte{1}, std::byte{0xFF}, std::byte{0}});  // Block Load: block 1, success
  device.answer_feature(
      {std::byte{0x22}, std::byte{0xFF}, std::byte{0}, std::byte{40}, std::byte{1}});  // Pool: device-managed
  const Reporter hand(device, pid_report);
  const RunOutcome outcome =
      live_run(true, nullptr,
               {"device.0.driver=\"pid\"", "device.0.pid={travel=[\"200 mm\", \"0 mm\", \"0 mm\"], full_scale=\"20 N\"}"});
  INFO(outcome.failure);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  CHECK(outcome.metrics.at("left.force.phase_locked").at("malformed") == 0);
  REQUIRE(device.features_set().size() == 1);  // Create New Effect
  const std::vector<Bytes> outputs = device.outputs();
  const auto sent = [&](unsigned id) {
    return std::count_if(outputs.begin(), outputs.end(), [&](const Bytes& bytes) { return bytes[0] == std::byte(id); });
  };
  CHECK(sent(0x10) == 1);  // Set Effect
  CHECK(sent(0x14) > 1);   // Set Constant Force: zero, and what came
  CHECK(sent(0x16) > 1);   // Effect Operation: start, again, and stop
  // Device Control: reset and enable; at the end stop all and disable (bit 2).
  const auto control = [](const Bytes& bytes) { return bytes[0] == std::byte{0x18}; };
  REQUIRE(sent(0x18) >= 4);
  CHECK(*std::find_if(outputs.rbegin(), outputs.rend(), control) == Bytes{std::byte{0x18}, std::byte{0x02}});
}

TEST_CASE("without forces a live run sends nothing at all") {
  MockedHidraw device(reference());
  const Reporter hand(device);
  const RunOutcome outcome = live_run(false);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  CHECK(device.outputs().empty());
}

// A report that finds no room is sent again, so that only reports before the run are lost.
TEST_CASE("what the kernel had no room for before a live run begins to read is not counted as lost to it") {
  MockedHidraw device(reference());
  std::uint32_t sequence = 1;
  while (device.send(reference_report(sequence))) ++sequence;
  CHECK(sequence == 65);
  sequence += 100;
  std::atomic<bool> stopped{false};
  std::thread hand([&] {
    for (; !stopped; std::this_thread::sleep_for(std::chrono::milliseconds(4))) {
      if (device.send(reference_report(sequence))) ++sequence;
    }
  });
  const RunOutcome outcome = live_run(false);
  stopped = true;
  hand.join();
  INFO(outcome.failure);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.metrics.at("left.force.phase_locked").at("reports") > 0);
  CHECK(outcome.metrics.at("left.force.phase_locked").at("lost") == 0);
}

TEST_CASE("a device that is unplugged while it is driven is waited for and the run goes on without force") {
  MockedHidraw::Spec spec = reference();
  spec.node = MockedHidraw::Node::pty;
  MockedHidraw device(spec);
  std::thread person([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    device.unplug();
  });
  const RunOutcome outcome = live_run(true);
  person.join();
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  CHECK(outcome.metrics.at("left.force.phase_locked").at("unplugged") == 1);
}
