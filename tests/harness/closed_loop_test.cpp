// Hands that feel the force: the loop is closed.

#include <fmt/format.h>

#include <cmath>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

std::string stiffness(double N_per_m) { return fmt::format("scene.stiffness=\"{} N/m\"", N_per_m); }

/// An arm grips each of two devices. One has an odd rate, phase and delay, and drops reports that were not read.
const std::vector<std::string> kTwoHands{
    "run.duration=\"2 s\"", "expect=[]", "scene.stiffness=\"40 N/m\"",
    "device=[{ name = \"left\", rate = \"1 kHz\", queue = \"libusb\", motion = { kind = \"hand\", mass = \"0.2 kg\", "
    "damping = \"1 N s/m\", "
    "offset = [\"5 mm\", \"0 mm\", \"-3 mm\"] } }, "
    "{ name = \"right\", rate = \"1000/3 Hz\", phase = \"0.7 ms\", delay = \"1.3 ms\", motion = { kind = \"hand\", mass = "
    "\"0.2 kg\", "
    "damping = \"1 N s/m\", arm = { mass = \"0.554 kg\", damping = \"6.45 N s/m\", stiffness = \"135 N/m\" }, "
    "path = { kind = \"sine\", amplitude = [\"10 mm\", \"0 mm\", \"0 mm\"], frequency = \"2 Hz\" } } }]"};

}  // namespace

TEST_CASE("hands that feel the force give the same bits on every run, thread count and permutation of ties") {
  const Scenario scenario = read("closed-loop/price-remap.toml", kTwoHands);
  const RunRecord first = run_all(scenario);
  CHECK(run_all(scenario).trace_hash == first.trace_hash);
  RunOptions one_thread;
  one_thread.threads = 1;
  CHECK(run_all(scenario, one_thread).trace_hash == first.trace_hash);
  // Leaving out a strategy does not change the others: each has its own hands.
  Scenario alone = scenario;
  alone.strategies = {StrategyKind::phase_locked};
  CHECK(strategy(run_all(alone), "phase_locked").trace_hash == strategy(first, "phase_locked").trace_hash);
  // A different hand gives a different run.
  Scenario heavier = scenario;
  heavier.devices[1].hand->mass_kg *= 1.0001;
  CHECK(run_all(heavier).trace_hash != first.trace_hash);
}

TEST_CASE("a hand goes where its force sends it: another stiffness, another delay, another path are seen in its positions") {
  const auto at_one_second = [](const std::vector<std::string>& more) {
    std::vector<std::string> set = kTwoHands;
    set.insert(set.end(), more.begin(), more.end());
    const RunRecord run = run_all(read("closed-loop/price-remap.toml", set));
    return strategy(run, "direct").devices[1].ticks[333].position_m[0];
  };
  const double base = at_one_second({});
  CHECK(std::abs(at_one_second({"scene.stiffness=\"60 N/m\""}) - base) > 1e-4);
  CHECK(std::abs(at_one_second({"device.right.delay=\"0 s\""}) - base) > 1e-6);
  CHECK(std::abs(at_one_second({"device.right.motion.path.frequency=\"3 Hz\""}) - base) > 1e-4);
}

TEST_CASE("energy, damping and stability tell a loop that gives energy from one that takes it") {
  // Without visualizations `direct` would be an even 1 kHz loop on a spring. Here its bursts delay the force.
  const RunOutcome soft = run_scenario(read("closed-loop/price-remap.toml"), {});
  CHECK(metric_of(soft, "closed_loop.left.phase_locked", "stable") == 1);
  CHECK(metric_of(soft, "closed_loop.left.phase_locked", "energy_min") <
        metric_of(soft, "closed_loop.left.direct", "energy_min"));
  CHECK(soft.metrics.at("closed_loop.left.direct").count("rendered_damping") == 0);
  const RunOutcome stiff = run_scenario(read("closed-loop/price-remap-unstable.toml"), {});
  CHECK(stiff.exit == ExitCode::pass);
  CHECK(metric_of(stiff, "closed_loop.left.phase_locked", "oscillation_ratio") > 1);
}

TEST_CASE("a hand has no nominal speed, no true position and no ideal twin") {
  const RunOutcome outcome = run_scenario(read("closed-loop/price-remap.toml", kTwoHands), {});
  CHECK(outcome.metrics.at("left.interaction.direct").count("error_max") == 0);
  CHECK(outcome.metrics.at("left.interaction.direct").count("step_ratio_max") == 0);
  CHECK(outcome.metrics.at("right.interaction.direct").count("gain") == 0);
  const auto errors = [](const std::string& expect) {
    std::string text;
    for (const Diagnostic& error : check_expectations(read("closed-loop/price-remap.toml", {"expect=[" + expect + "]"})))
      text += error.message;
    return text;
  };
  for (const char* metric : {"deviation_from_ideal", "deviation_from_ideal_growth", "deviation_from_ideal_growth_min"}) {
    CHECK_THAT(errors(std::string("{ signal = \"left.force.direct\", metric = \"") + metric + "\", max = 1 }"),
               Catch::Contains(std::string("'") + metric + "' has no value here") &&
                   Catch::Contains("a hand that feels the force has none"));
  }
  CHECK_THAT(errors("{ signal = \"left.interaction.direct\", metric = \"velocity_jump\", max = \"1 step\" }"),
             Catch::Contains("has no unit 'step'"));
  CHECK(errors("{ signal = \"closed_loop.left.direct\", metric = \"energy_min\", min = \"-3 mJ\" }").empty());
}

TEST_CASE("a hand that leaves its reach stops the run with device, strategy and time, and a scenario may expect that") {
  std::vector<std::string> set{"run.strategies=[\"direct\"]", "scene.stiffness=\"2 kN/m\"",
                               "device.left.force_limit=\"1 kN\"", "expect=[]"};
  const RunOutcome failed = run_scenario(read("closed-loop/price-remap.toml", set), {});
  CHECK(failed.exit == ExitCode::run_failed);
  CHECK_THAT(failed.failure, Catch::StartsWith("direct: left: the hand is more than 2 m away at ") && Catch::EndsWith(" s"));
  CHECK_THAT(failed.remedy, Catch::Contains("force_limit"));
  set.push_back("expect_stop={ reason = \"diverged\", at_most_step = 3600 }");
  CHECK(run_scenario(read("closed-loop/price-remap.toml", set), {}).exit == ExitCode::pass);
  set.back() = "expect_stop={ reason = \"diverged\", at_most_step = 1 }";  // not so early
  CHECK(run_scenario(read("closed-loop/price-remap.toml", set), {}).exit == ExitCode::expectation_failed);
}

TEST_CASE("a force limit bounds what shakes, so that it is measured as unstable instead of lost", "[sweep]") {
  for (const double N_per_m : {220.0, 300.0, 500.0, 1000.0, 5000.0}) {
    const RunOutcome outcome = run_scenario(read("closed-loop/price-raw-unstable.toml", {stiffness(N_per_m)}), {});
    CHECK(outcome.exit == ExitCode::pass);
    CHECK(metric_of(outcome, "closed_loop.left.direct", "stable") == 0);
  }
}
