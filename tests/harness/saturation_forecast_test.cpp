// The saturation that `check` predicts is the one that the run meets.

#include "evenstep/harness/saturation_forecast.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

std::string moving_at(const std::string& velocity) {
  return "device.left.motion={ kind = \"constant-velocity\", velocity = [\"" + velocity +
         "\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.2 s\" }";
}

struct Case {
  std::vector<std::string> set;
  std::vector<SaturationCause> causes;
};

}  // namespace

TEST_CASE("what is foretold of a straight motion is met in the run, a latency later, and nothing else is", "[sweep]") {
  using enum SaturationCause;
  const std::string pid = "device.left.driver=\"pid\"";
  for (const Case& one : std::vector<Case>{
           {{moving_at("0.1 m/s"), "run.duration=\"4 s\""}, {}},
           {{moving_at("0.1 m/s"), "run.duration=\"6 s\""}, {clamp}},
           {{moving_at("0.1 m/s"), "run.duration=\"22 s\""}, {clamp, device_position}},
           {{moving_at("0.1 m/s"), "run.duration=\"22 s\"", "scene.stiffness=\"10 N/m\""}, {device_position}},
           {{moving_at("0.1 m/s"), "run.duration=\"600 s\"", "scene.stiffness=\"10 N/m\"", "run.keep=\"summary\""},
            {device_position}},  // the end of the axis keeps the force below the clamp
           {{moving_at("0.1 m/s"), "device.left.slew_limit=\"10 N/s\""}, {slew}},
           {{moving_at("0.1 m/s"), "device.left.guard={ speed_limit = \"0.05 m/s\" }"}, {cut}},
           {{moving_at("0.1 m/s"), pid,
             "device.left.pid={ travel = [\"1 m\", \"1 m\", \"0 mm\"], full_scale = \"20 N\", gain = 1.0 }"},
            {device_force}},
           {{moving_at("0.1 m/s"), pid,
             "device.left.pid={ travel = [\"0.2 m\", \"0.2 m\", \"0 mm\"], full_scale = \"100 N\", gain = 1.0 }"},
            {device_position}},
           {{"run.duration=\"30 s\""}, {}}}) {  // the shipped motion: back and forth
    std::vector<std::string> set = one.set;
    set.push_back("run.strategies=[\"phase_locked\"]");
    set.push_back("expect=[{ signal = \"left.force.phase_locked\", metric = \"jump_max\", max = \"1 kN\" }]");
    const Scenario scenario = read("paper/figure-1-spring.toml", set);
    for (const std::string& line : set) UNSCOPED_INFO(line);
    const std::vector<ForetoldSaturation> foretold = foretell_saturation(scenario);
    const RunOutcome outcome = run_scenario(scenario, {});
    REQUIRE(outcome.failure.empty());
    const auto found = saturations(outcome.record);
    CHECK(foretold.size() == one.causes.size());
    for (const SaturationCause cause : one.causes) {
      const auto is_cause = [&](const auto& what) { return what.cause == cause; };
      const auto told = std::find_if(foretold.begin(), foretold.end(), is_cause);
      REQUIRE(told != foretold.end());
      const auto& parts = found.at("left.force.phase_locked").parts;
      const auto met = std::find_if(parts.begin(), parts.end(), is_cause);
      REQUIRE(met != parts.end());
      CHECK(met->first + Duration{5'000'000} >= told->first);  // a count of the device early, or 5 ms for a speed
      CHECK(met->first <= told->first + Duration{50'000'000});
    }
    const bool must_fail = !foretold_errors(scenario, plan(scenario), foretold).empty();
    CHECK(must_fail == (outcome.exit == ExitCode::usage));
    CHECK(must_fail == !one.causes.empty());
  }
}

TEST_CASE("nothing is foretold to fail where saturation is expected, or a count is asked for") {
  const std::vector<std::string> set{moving_at("0.1 m/s"), "run.duration=\"6 s\""};
  const auto errors_of = [&](std::vector<std::string> more) {
    more.insert(more.begin(), set.begin(), set.end());
    const Scenario scenario = read("paper/figure-1-spring.toml", more);
    return foretold_errors(scenario, plan(scenario), foretell_saturation(scenario)).size();
  };
  CHECK(errors_of({}) > 0);
  CHECK(errors_of({"device.left.saturation=\"expected\""}) == 0);
  CHECK(errors_of({"expect=[{ signal = \"left.force.*\", metric = \"clamped\", min = 1 }]"}) == 0);
  CHECK(errors_of({"expect=[{ signal = \"left.force.*\", metric = \"jump_max\", max = \"1 N\" }]"}) == 1);
}
