// Recovery as a run judges it: on both clocks, too short, never, without a fault; and faults that are switched off.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "evenstep/reports/recovery.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;
using Verdict = ExpectationResult::Verdict;

namespace {

std::vector<std::string> stall(const std::string& duration, const std::string& expectation) {
  return {"run.duration=\"" + duration + "\"", "run.strategies=[\"phase_locked\"]", "expect=[" + expectation + "]"};
}

ExpectationResult judged(const std::vector<std::string>& set, const RunOptions& options = {}) {
  const RunOutcome outcome = run_scenario(read("timing/stall.toml", set), options);
  REQUIRE(outcome.errors.empty());
  REQUIRE(outcome.results.size() == 1);
  return outcome.results.front();
}

std::string wants(const std::string& limit) {
  return "{ signal = \"left.force.phase_locked\", metric = \"recovery_time\", " + limit + " }";
}

}  // namespace

TEST_CASE("A time of recovery is judged by its limit") {
  const ExpectationResult result = judged(stall("8 s", wants("max = \"2 s\"")));
  CHECK(result.verdict == Verdict::pass);
  REQUIRE(result.value);
  CHECK(*result.value > 0);
  CHECK(judged(stall("8 s", wants("max = \"1 ns\""))).verdict == Verdict::fail);
}

TEST_CASE("A run that ends too early to tell of its recovery is an error that says how long it must last") {
  const ExpectationResult result = judged(stall("3.8 s", wants("max = \"2 s\"")));
  CHECK(result.verdict == Verdict::error);
  CHECK_THAT(result.detail, Contains("the run must last at least"));
  const ExpectationResult inside = judged(stall("3 s", wants("max = \"2 s\"")));
  CHECK(inside.verdict == Verdict::error);
  CHECK_THAT(inside.detail, Contains("is not over when it ends"));
}

TEST_CASE("A fault that lasts fails a time of recovery by name, also one with a minimum", "[sweep]") {
  // The guard cuts the force of a device that has stopped reporting.
  const std::vector<std::string> lost{"run.strategies=[\"phase_locked\"]",
                                      "device.left.faults=[{ kind = \"lost\", at = \"2 s\", ticks = 2000 }]"};
  auto with = [&](const std::string& expectation) {
    std::vector<std::string> set = lost;
    set.push_back("expect=[" + expectation + "]");
    return run_scenario(read("safety/stale-hand.toml", set), {}).results.at(0);
  };
  CHECK(with(wants("max = \"1 s\"")).verdict == Verdict::error);  // the fault is over only when the run ends
  const std::vector<std::string> gone{"run.strategies=[\"direct\"]",
                                      "expect=[{ signal = \"left.force.direct\", metric = \"recovered\", equals = 0 }]"};
  const RunOutcome outcome = run_scenario(read("safety/inverse3-uncalibrated.toml", gone), {});
  CHECK(outcome.exit == ExitCode::pass);
  CHECK_THAT(outcome.results.at(0).detail, Contains("inverse3.uncalibrated_at lasts until the end"));
  const std::vector<std::string> hoped{
      "run.strategies=[\"direct\"]",
      "expect=[{ signal = \"left.force.direct\", metric = \"recovery_time\", min = \"1 s\" }]"};
  CHECK(run_scenario(read("safety/inverse3-uncalibrated.toml", hoped), {}).exit == ExitCode::expectation_failed);
}

TEST_CASE("A limit longer than what is left of a run that has not recovered is an error, a shorter one fails") {
  std::vector<std::string> set = stall("8 s", wants("max = \"2 s\""));
  set.push_back("remap.lead=\"0 ms\"");  // so samples are missing in every segment, also before the stall
  const ExpectationResult fails = judged(set);
  CHECK(fails.verdict == Verdict::fail);
  CHECK_THAT(fails.detail, Contains("never, within"));
  set[2] = "expect=[" + wants("max = \"1 min\"") + "]";
  const ExpectationResult open = judged(set);
  CHECK(open.verdict == Verdict::error);
  CHECK_THAT(open.detail, Contains("to judge this limit the run must last at least"));
}

TEST_CASE("Under a star a signal that never recovers fails a minimum, whatever the others do") {
  // Without a lead samples are missing in every segment of the map, and direct does not care.
  const auto judged_minimum = [](const std::string& signal) {
    return judged({"run.duration=\"8 s\"", "run.strategies=[\"direct\", \"phase_locked\"]", "remap.lead=\"0 ms\"",
                   "expect=[{ signal = \"" + signal + "\", metric = \"recovery_time\", min = \"0 ns\" }]"});
  };
  CHECK(judged_minimum("left.force.direct").verdict == Verdict::pass);
  CHECK(judged_minimum("left.force.phase_locked").verdict == Verdict::fail);
  CHECK(judged_minimum("left.force.*").verdict == Verdict::fail);
  CHECK(judged_minimum("left.force.*").signal == "left.force.phase_locked");
}

TEST_CASE("An expectation of recovery without a fault is an error before the run") {
  const RunOutcome outcome =
      run_scenario(read("paper/figure-1-spring.toml", {"expect=[" + wants("max = \"1 s\"") + "]"}), {});
  CHECK(outcome.exit == ExitCode::usage);
  REQUIRE(outcome.errors.size() == 1);
  CHECK_THAT(outcome.errors[0].message, Contains("no fault is programmed"));
}

TEST_CASE("With every fault switched off an expectation of recovery does not apply, and says so") {
  std::vector<std::string> set = stall("8 s", wants("max = \"1 ns\""));
  set.push_back("run.faults_off=[\"timing.changes\"]");
  const ExpectationResult result = judged(set);
  CHECK(result.verdict == Verdict::skipped);
  CHECK_THAT(result.detail, Contains("every fault is switched off"));
}

TEST_CASE("A fault that is switched off is as if it were not in the file") {
  const Scenario whole = read("safety/faults-reference-hidraw.toml");
  REQUIRE(whole.faults.size() == 10);
  const Scenario without =
      read("safety/faults-reference-hidraw.toml", {"run.faults_off=[\"device.left.faults.9\", \"device.left.faults.1\"]"});
  REQUIRE(without.faults.size() == 8);
  CHECK(without.faults[0].name == "device.left.faults.0");
  CHECK(without.faults[1].name == "device.left.faults.2");
  CHECK(without.faults[1].from == whole.faults[2].from);
  CHECK(without.faults.back().name == "device.left.faults.8");
  CHECK(without.devices[0].faults.size() == whole.devices[0].faults.size() - 6);
  const std::vector<std::string> spring{"run.duration=\"0.6 s\"", "run.strategies=[\"phase_locked\"]", "expect=[]"};
  std::vector<std::string> off = spring;
  off.push_back("timing.hitch={ every = \"0.2 s\", visualization = \"20 ms\" }");
  off.push_back("run.faults_off=[\"timing.hitch\"]");
  CHECK(run_all(read("paper/figure-1-spring.toml", off)).trace_hash ==
        run_all(read("paper/figure-1-spring.toml", spring)).trace_hash);
}

TEST_CASE("A device that returns was away from its unplug to its return, and for ever where nobody looks for it any more") {
  const auto fault_with = [](std::vector<std::string> set) {
    set.push_back("expect=[]");
    const Scenario scenario = read("recovery/unplugged-evdev.toml", set);
    REQUIRE(scenario.faults.size() == 1);
    CHECK(scenario.faults[0].name == "device.left.unplug");
    CHECK(scenario.faults[0].from == RealTime{1'500'000'000});
    return scenario.faults[0];
  };
  CHECK(fault_with({}).to == RealTime{1'900'000'000});
  CHECK(fault_with({}).over == ProgrammedFault::Over::at_time);
  CHECK(fault_with({"device.left.returns=\"11.5 s\""}).over == ProgrammedFault::Over::at_time);
  CHECK(fault_with({"device.left.returns=\"11.501 s\""}).over == ProgrammedFault::Over::never);
  const Scenario off = read("recovery/unplugged-evdev.toml", {"run.faults_off=[\"device.left.unplug\"]", "expect=[]"});
  CHECK(off.faults.empty());
  CHECK_FALSE(off.devices[0].returns);
}

TEST_CASE("A return that cannot be is refused: of a device that stays, before its unplug, and of a driver that has none") {
  const auto error_of = [](const std::string& file, std::vector<std::string> set) {
    const ReadResult result = read_scenario(shipped(file), {std::move(set), std::nullopt});
    REQUIRE_FALSE(result);
    return result.error().front().message;
  };
  const std::string late = "device.left.returns=\"2 s\"";
  CHECK_THAT(error_of("paper/figure-1-spring.toml", {late}), Contains("it was never unplugged"));
  CHECK_THAT(error_of("safety/unplug.toml", {"device.left.returns=\"1 s\""}), Contains("it is not unplugged yet (1000 ms)"));
  CHECK_THAT(error_of("safety/unplug-pid.toml", {late}), Contains("driver = \"pid\" renders no force"));
}

TEST_CASE("The name of a fault that is not there is an error that knows the others") {
  const ReadResult result =
      read_scenario(shipped("timing/stall.toml"), {{"run.faults_off=[\"timing.change\"]"}, std::nullopt});
  REQUIRE_FALSE(result);
  CHECK_THAT(result.error().front().message, Contains("there is no fault 'timing.change'"));
  CHECK_THAT(result.error().front().message, Contains("timing.changes"));
}

TEST_CASE("The stored scenario keeps a fault that is switched off, and reads as the same run") {
  const Scenario scenario = read("timing/stall.toml", {"run.faults_off=[\"timing.changes\"]"});
  CHECK_THAT(scenario.resolved_toml, Contains("1667 ms"));
  CHECK(scenario.timing.programmed.changes.empty());
}

TEST_CASE("A run on the wall clock is judged by the same rules, and its shadows too") {
  RunOptions options;
  options.clock = ClockKind::wall;
  const Scenario scenario =
      read("safety/faults-reference-hidraw.toml",
           {"run.duration=\"1.4 s\"", "remap.latency=\"25 ms\"", "remap.lead=\"3 ms\"", "run.warmup=\"0.2 s\"",
            "device.left.faults=[{ kind = \"lost\", at = \"0.6 s\", ticks = 30 }]",
            "expect=[{ signal = \"left.force.*\", metric = \"recovered\", min = 0 }]"});
  const RunOutcome outcome = run_scenario(scenario, options);
  for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
  INFO(outcome.failure);
  REQUIRE(outcome.results.size() == 1);
  // Nobody can say how soon a loaded machine is smooth again. But the answer must be a number or "never", not nothing.
  for (const char* name : {"direct", "phase_locked"}) {
    const Recovery recovery = recovery_of(outcome.record, strategy(outcome.record, name), 0);
    INFO(name << ": " << recovery.why);
    CHECK((recovery.state == Recovery::State::recovered || recovery.state == Recovery::State::never));
    CHECK(outcome.metrics.at(std::string("left.force.") + name).count("recovery_time") == 1);
  }
}

TEST_CASE("Outside of the disturbed time there are no hitches, spikes, regimes, drops or pre-emption") {
  const std::vector<std::string> calm{"run.duration=\"3 s\"", "run.strategies=[\"phase_locked\"]", "expect=[]",
                                      "timing.jitter={ step = \"lognormal 1 %\" }"};
  std::vector<std::string> stormy = calm;
  for (const char* more :
       {"timing.spikes={ rate = \"20 Hz\", cost = \"4 ms\" }",
        "timing.preemption={ rate = \"9 Hz\", cost = \"pareto 3 ms cap 9 ms\" }",
        "timing.regimes={ factor = 1.6, mean_length = \"8 segments\" }", "timing.dropped_visualization=\"5 %\"",
        "timing.hitch={ every = \"0.25 s\", visualization = \"30 ms\" }", "timing.merged_visualization=\"5 %\"",
        "timing.disturbed={ from = \"1 s\", to = \"2 s\" }"})
    stormy.push_back(more);
  const RunRecord without = run_all(read("paper/figure-1-spring.toml", calm));
  const RunRecord with = run_all(read("paper/figure-1-spring.toml", stormy));
  const auto& a = strategy(without, "phase_locked").segments;
  const auto& b = strategy(with, "phase_locked").segments;
  std::size_t calm_segments = 0;
  for (std::size_t k = 0; k < b.size(); ++k) {
    const Duration visualization = b[k].visualization ? (*b[k].visualization)[1] - (*b[k].visualization)[0] : Duration{};
    const bool disturbed = b[k].begin >= RealTime{1'000'000'000} && b[k].begin < RealTime{2'000'000'000};
    if (!disturbed) CHECK(visualization == Duration{11'100'000});
    calm_segments += disturbed ? 0 : 1;
  }
  CHECK(calm_segments > 50);
  // Until the disturbance both runs are the same to the nanosecond: they draw the same numbers, and T sets the pace of both.
  CHECK(std::equal(a.begin(), a.begin() + 30, b.begin()));
  CHECK(with.nominal.slot_s == without.nominal.slot_s);
}

namespace {

bool is_endless(const ProgrammedFault& fault) {
  return fault.over == ProgrammedFault::Over::never && fault.name.starts_with("timing.");
}

/// The folder `recovery` has a scenario that extends this one and ends the fault that never ends here.
bool has_end_elsewhere(const std::filesystem::path& file) {
  const std::filesystem::path other = shipped("recovery/" + file.filename().string());
  std::ifstream text(other);
  const std::string all{std::istreambuf_iterator<char>(text), {}};
  return all.find("extends = [\"../timing/" + file.filename().string() + "\"]") != std::string::npos &&
         all.find("disturbed") != std::string::npos;
}

}  // namespace

TEST_CASE("Every shipped scenario with faults asserts the recovery of each of its strategies", "[sweep]") {
  std::size_t with_faults = 0, endless = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shipped(""))) {
    const std::filesystem::path file = entry.path();
    if (file.extension() != ".toml" || file.string().find("/format/") != std::string::npos) continue;
    const ReadResult scenario = read_scenario(file.string());
    INFO(file.string());
    REQUIRE(scenario);
    if (scenario->faults.empty()) continue;
    if (std::all_of(scenario->faults.begin(), scenario->faults.end(), is_endless)) {
      ++endless;
      CHECK(has_end_elsewhere(file));
      continue;
    }
    ++with_faults;
    for (const StrategyKind kind : scenario->strategies) {
      if (traits_of(kind).knows_motion) continue;
      for (const DeviceSpec& device : scenario->devices) {
        const std::string signal = device.name + ".force." + name_of(kind);
        INFO(signal);
        CHECK(std::any_of(scenario->expectations.begin(), scenario->expectations.end(), [&](const Expectation& one) {
          return one.metric.starts_with("recover") && (one.signal == signal || one.signal == device.name + ".force.*");
        }));
      }
    }
  }
  CHECK(with_faults >= 30);
  CHECK(endless == 4);
}
