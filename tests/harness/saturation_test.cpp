// A signal at a limit is smooth whatever drives it. So its shape is not judged there, whichever limit it is.

#include <random>

#include "evenstep/harness/sizing.h"
#include "evenstep/reports/saturation.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;
using Verdict = ExpectationResult::Verdict;

namespace {

std::string expecting(const std::string& signal, const std::string& metric, const std::string& limit) {
  return "{ signal = \"" + signal + "\", metric = \"" + metric + "\", " + limit + " }";
}

std::string moving(const std::string& velocity, const std::string& rest = "kind = \"constant-velocity\"") {
  return "device.left.motion={ velocity = [\"" + velocity + "\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.2 s\", " + rest +
         " }";
}

RunOutcome outcome_of(std::vector<std::string> set) {
  set.push_back("run.strategies=[\"ideal\", \"direct\", \"phase_locked\"]");
  RunOutcome outcome = run_scenario(read("paper/figure-1-spring.toml", set), {});
  for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
  REQUIRE(outcome.errors.empty());
  REQUIRE(outcome.failure.empty());
  return outcome;
}

/// Settings for a run of two seconds, and the saturation that they cause. The run has one expectation on the force and one
/// on the interaction; any straight line meets both.
struct Limited {
  std::vector<std::string> set;
  SaturationCause cause;
  bool interaction = false;  ///< true if the interaction saturates too
};

const std::vector<Limited> kLimited{
    {{moving("0.1 m/s"), "device.left.force_limit=\"20 N\""}, SaturationCause::clamp},
    {{moving("0.1 m/s"), "device.left.slew_limit=\"10 N/s\""}, SaturationCause::slew},
    {{moving("0.1 m/s"), "device.left.guard={ ramp_up = \"1 s\" }"}, SaturationCause::cut},
    {{moving("0.1 m/s"), "device.left.guard={ speed_limit = \"0.05 m/s\" }"}, SaturationCause::cut},
    {{moving("0.1 m/s"), "device.left.driver=\"pid\"",
      "device.left.pid={ travel = [\"1 m\", \"1 m\", \"0 mm\"], full_scale = \"20 N\", gain = 1.0 }"},
     SaturationCause::device_force},
    {{moving("1.2 m/s"), "device.left.force_limit=\"1 kN\""}, SaturationCause::device_position, true},
    {{moving("0.1 m/s"), "device.left.driver=\"pid\"",
      "device.left.pid={ travel = [\"0.2 m\", \"0.2 m\", \"0 mm\"], full_scale = \"100 N\", gain = 1.0 }"},
     SaturationCause::device_position,
     true}};

}  // namespace

TEST_CASE("a saturated force or interaction makes an expectation on its shape an error that says when and what to do") {
  for (const Limited& limited : kLimited) {
    std::vector<std::string> set = limited.set;
    set.push_back("run.duration=\"2 s\"");
    set.push_back("expect=[" + expecting("left.force.phase_locked", "jump_max", "max = \"1 kN\"") + ", " +
                  expecting("left.interaction.phase_locked", "velocity_jump", "max = \"1 m\"") + ", " +
                  expecting("left.force.phase_locked", "saturated", "min = 1") + ", " +
                  expecting("left.force.phase_locked", "underruns", "equals = 0") + "]");
    const RunOutcome outcome = outcome_of(set);
    INFO(name_of(limited.cause) << ": " << outcome.results[0].detail);
    CHECK(outcome.results[0].verdict == Verdict::error);
    CHECK_THAT(outcome.results[0].detail, Catch::Contains(std::string(name_of(limited.cause))) &&
                                              Catch::Contains("first at") && Catch::Contains("saturation = \"expected\""));
    CHECK(outcome.results[1].verdict == (limited.interaction ? Verdict::error : Verdict::pass));
    CHECK(outcome.results[2].verdict == Verdict::pass);
    CHECK(outcome.results[3].verdict == Verdict::pass);
    CHECK(outcome.exit == ExitCode::usage);

    const Saturation met = saturations(outcome.record).at("left.force.phase_locked");
    const auto part = std::find_if(met.parts.begin(), met.parts.end(),
                                   [&](const Saturation::Part& one) { return one.cause == limited.cause; });
    REQUIRE(part != met.parts.end());
    CHECK(met.saturated == outcome.metrics.at("left.force.phase_locked").at("saturated"));
    CHECK(met.judged == outcome.metrics.at("left.force.phase_locked").at("judged"));
    CHECK(part->count <= met.saturated);
  }
}

TEST_CASE("a device that expects saturation is judged as it is") {
  for (const Limited& limited : kLimited) {
    std::vector<std::string> set = limited.set;
    set.push_back("run.duration=\"2 s\"");
    set.push_back("device.left.saturation=\"expected\"");
    set.push_back("expect=[" + expecting("left.force.phase_locked", "jump_max", "max = \"1 kN\"") + ", " +
                  expecting("left.interaction.*", "velocity_jump", "max = \"1 m\"") + "]");
    const RunOutcome outcome = outcome_of(set);
    INFO(name_of(limited.cause));
    CHECK(outcome.exit == ExitCode::pass);
    CHECK(outcome.metrics.at("left.force.phase_locked").at("saturated") > 0);
  }
}

TEST_CASE("the README's example, run on in a straight line, errs from the clamp on, and later for the device's range",
          "[sweep]") {
  const auto of = [](const char* duration) {
    return outcome_of({moving("0.1 m/s"), std::string("run.duration=\"") + duration + "\"",
                       "expect=[" + expecting("left.force.direct", "jump_max", "max = \"1 N\"") + ", " +
                           expecting("left.interaction.phase_locked", "velocity_jump", "max = \"1e-6 step\"") + "]"});
  };
  CHECK(of("5.1 s").exit == ExitCode::pass);
  const RunOutcome clamped = of("6 s");  // 200 N/m (0.1 m/s (t - 0.1 s)) = 100 N at t = 5.1 s
  CHECK(clamped.results[0].verdict == Verdict::error);
  CHECK_THAT(clamped.results[0].detail, Catch::Contains("clamp first at 5.1"));
  CHECK(clamped.results[1].verdict == Verdict::pass);
  const RunOutcome out_of_range = of("22 s");  // 2.147 m = 0.1 m/s (t - 0.1 s) at t = 21.57 s
  CHECK(out_of_range.results[1].verdict == Verdict::error);
  CHECK_THAT(out_of_range.results[1].detail, Catch::Contains("device_position first at 21.5"));
}

TEST_CASE("the interaction of the ideal twin is never saturated: it reads the motion and not the device") {
  const RunOutcome outcome =
      outcome_of({moving("1.2 m/s"), "device.left.force_limit=\"1 kN\"", "run.duration=\"3 s\"", "expect=[]"});
  const auto found = saturations(outcome.record);
  CHECK(found.count("left.interaction.ideal") == 0);
  CHECK(found.count("left.interaction.direct") == 1);
}

TEST_CASE("the damping that a limited force renders is not judged either") {
  const RunOutcome outcome =
      outcome_of({"device.left.motion={ kind = \"sine\", amplitude = [\"50 mm\", \"0 m\", \"0 m\"], frequency = \"2 Hz\" }",
                  "device.left.force_limit=\"5 N\"",
                  "expect=[" + expecting("closed_loop.left.phase_locked", "rendered_damping", "max = \"100 N s/m\"") + "]"});
  CHECK(outcome.results[0].verdict == Verdict::error);
}

TEST_CASE("there and back a perfect map stays perfect to the nanosecond, whatever the turns, the latency and the device",
          "[sweep]") {
  // The timing is periodic, so each straight piece is a line. A single sample of a turn among the judged ones would bend it
  // by up to 3 v / turn slot^2, which is 1e-2 steps and more.
  std::mt19937_64 random(7);
  const auto pick = [&](std::uint64_t from, std::uint64_t to) { return std::to_string(from + random() % (to - from + 1)); };
  for (int i = 0; i < 60; ++i) {
    const std::string latency = random() % 2 ? "\"minimal\"" : "\"" + pick(16, 400) + " ms\"";
    const std::string emission = random() % 2 ? "linear" : "hold";
    const std::vector<std::string> set{
        moving("0.1 m/s", "kind = \"back-and-forth\", straight = \"" + pick(700, 1500) + " ms\", turn = \"" + pick(20, 400) +
                              " ms\", delay = \"" + pick(0, 300) + " ms\""),
        "device.left.rate=\"" + std::to_string(1 << random() % 3) + " kHz\"",
        "device.left.render={ kind = \"force\", emission = \"" + emission + "\" }",
        "remap.latency=" + latency,
        "run.duration=\"8 s\"",
        "run.warmup=\"1 s\"",
        "expect=[]"};
    const RunOutcome outcome = outcome_of(set);
    for (const std::string& line : set) UNSCOPED_INFO(line);
    const auto& steps = outcome.metrics.at("left.interaction.phase_locked");
    const auto& ticks = outcome.metrics.at("left.force.phase_locked");
    // Instants are whole nanoseconds. Each of two neighbouring slots is off by up to 4.5e-7 step (docs/choose/numerics.md).
    const double step_m = 0.1 / 450, step_N = 200 * step_m, floor = 1e-6;
    CHECK(steps.at("velocity_jump") <= floor * step_m);
    CHECK(steps.at("deviation_max") <= floor * step_m);
    CHECK(steps.at("step_ratio_min") >= 1 - floor);
    CHECK(ticks.at("velocity_jump") <= (emission == "hold" ? 1 + floor : floor) * step_N);
    CHECK(ticks.at("deviation_max") <= (emission == "hold" ? 0.55 : floor) * step_N);
    CHECK(ticks.at("saturated") == 0);
    // No more is left out than the turn and the time that goes into a step or a tick: the latency and some periods.
    const Nominal::Turns turns = *outcome.record.nominal.devices[0].turns;
    const double period_s = seconds(turns.straight + turns.turn);
    const double left_out_s = seconds(turns.turn) + seconds(strategy(outcome.record, "phase_locked").latency.latency) + 0.03;
    CHECK(ticks.at("straight") >= ticks.at("judged") * (1 - left_out_s / period_s) - 2 * 1000 * period_s);
    CHECK(steps.at("straight") >= steps.at("judged") * (1 - (seconds(turns.turn) + 0.03) / period_s) - 2 * 450 * period_s);
  }
}

TEST_CASE("what a filter or a predictor still remembers of a turn is not judged") {
  // Even steps without visualizations, each at the same time after a tick. Some time after a turn, a filter and a predictor
  // follow a line exactly.
  for (const char* filter : {"{ kind = \"butterworth\", cutoff = \"10 Hz\", on = \"interaction\" }",
                             "{ kind = \"butterworth\", cutoff = \"10 Hz\", on = \"force\" }",
                             "{ kind = \"moving-average\", window = \"1 segment\", on = \"interaction\" }",
                             "{ kind = \"moving-average\", window = \"1 segment\", on = \"force\" }"}) {
    const RunOutcome outcome = run_scenario(
        read("paper/figure-1-spring.toml",
             {"timing.visualization=\"0 ms\"", "device.left.rate=\"450 Hz\"", "device.left.phase=\"1 ms\"",
              std::string("remap.filter=") + filter,
              moving("0.1 m/s", "kind = \"back-and-forth\", straight = \"1.5 s\", turn = \"0.1 s\""), "run.duration=\"8 s\"",
              "run.warmup=\"1 s\"", "run.strategies=[\"filtered\", \"predict\", \"phase_locked\"]", "expect=[]"}),
        {});
    REQUIRE(outcome.failure.empty());
    INFO(filter);
    for (const char* name : {"filtered", "predict"}) {
      INFO(name);
      const auto& steps = outcome.metrics.at(std::string("left.interaction.") + name);
      CHECK(steps.at("straight") > 1000);
      // A predictor extrapolates by some slots from samples that are up to 1 ns off.
      CHECK(steps.at("velocity_jump") / (0.1 / 450) <= 3e-5);
    }
  }
}

TEST_CASE("ten minutes at 0.1 m/s pass with the expectations of four seconds", "[sweep]") {
  const RunOutcome outcome =
      run_scenario(read("paper/figure-1-spring.toml", {"run.duration=\"600 s\"", "run.keep=\"summary\""}), {});
  REQUIRE(outcome.failure.empty());
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(saturations(outcome.record).empty());
}
