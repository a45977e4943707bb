/// The live run through unmodified libhidapi, on a device that this process makes up: a hand in slow motion, reported by a thread.

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "evenstep/device/hid/reference_device.h"
#include "evenstep/harness/run.h"
#include "evenstep/harness/scenario.h"
#include "mocked_hidraw.h"

using namespace evenstep;

namespace {

MockedHidraw::Spec reference() {
  MockedHidraw::Spec spec;
  spec.report_descriptor.assign(reference_device::report_descriptor().begin(), reference_device::report_descriptor().end());
  return spec;
}

/// Reports at some 250 Hz: how late the thread is asserts nothing.
class Reporter {
 public:
  explicit Reporter(MockedHidraw& device) : thread_([this, &device] {
    for (std::uint32_t sequence = 1; !stopped_; ++sequence) {
      const reference_device::InputReport report{sequence, sequence * 4000, {static_cast<std::int32_t>(sequence) * 40'000, 0, 0}};
      device.send(reference_device::encode(report));
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

RunOutcome live_run(bool forces, const std::atomic<bool>* interrupted = nullptr) {
  const ReadResult read =
      read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/live/figure-1-spring.toml",
                    {{"run.duration=\"1 s\"", "run.warmup=\"0.3 s\"", "device.0.rate=\"250 Hz\"", "device.0.guard={ramp_up=\"0.1 s\"}",
                      "remap.lead=\"60 ms\"", "remap.latency=\"200 ms\"", "expect=[]", "run.strategies=[\"direct\", \"phase_locked\"]"},
                     std::nullopt});
  for (const Diagnostic& error : read.errors) FAIL(text(error));
  RunOptions options;
  options.clock = ClockKind::wall;
  options.control.interrupted = interrupted;
  options.devices = {{{"left", "/dev/hidraw0"}}, forces};
  return run_scenario(*read.scenario, options);
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
    for (int i = 0; i < 60'000 && device.outputs().size() < 20; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    interrupted = true;
  });
  const RunOutcome outcome = live_run(true, &interrupted);
  person.join();
  CHECK(outcome.exit == ExitCode::interrupted);
  const std::vector<Bytes> outputs = device.outputs();
  REQUIRE(outputs.size() >= 20);
  CHECK(reference_device::decode_output(outputs.back())->force_uN == std::array<std::int32_t, 3>{});
}

TEST_CASE("without forces a live run sends nothing at all") {
  MockedHidraw device(reference());
  const Reporter hand(device);
  const RunOutcome outcome = live_run(false);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  CHECK(device.outputs().empty());
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
