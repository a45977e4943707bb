// A live run through the connection to a Haply Inverse Service.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "catch.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/run.h"
#include "service.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

Scenario live_inverse3(const std::string& duration) {
  const ReadResult read =
      read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/live/figure-1-spring.toml",
                    {{"run.duration=\"" + duration + "\"", "run.warmup=\"0.3 s\"", "device.0.driver=\"inverse3\"",
                      "device.0.rate=\"250 Hz\"", "device.0.inverse3={origin=[\"10 mm\", \"0 mm\", \"0 mm\"]}",
                      "device.0.guard={ramp_up=\"0.1 s\"}", "remap.lead=\"60 ms\"", "remap.latency=\"200 ms\"", "expect=[]",
                      "run.strategies=[\"direct\", \"phase_locked\"]"},
                     std::nullopt});
  for (const Diagnostic& error : read.error_or({})) FAIL(text(error));
  return *read;
}

}  // namespace

TEST_CASE("inverse3 socket: a live run through it renders forces, replays to the same trace and ends with none") {
  const Service service;
  const Scenario scenario = live_inverse3("1 s");
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  for (const bool forces : {false, true}) {
    options.devices = {{{"left", service.address() + "#049D"}}, forces};
    const RunOutcome outcome = run_scenario(scenario, options);
    INFO(outcome.failure);
    CHECK(outcome.exit == ExitCode::pass);
    const auto& metrics = outcome.metrics.at("left.force.phase_locked");
    CHECK(metrics.at("reports") > 50);
    CHECK(metrics.at("malformed") == 0);
    CHECK(metrics.at("writes") > 50);
    // 10 mm from the origin at 200 N/m. A quarter of that is rendered.
    const std::vector<double> all = service.forces_x_N();
    CHECK((*std::max_element(all.begin(), all.end()) > 0.1) == forces);
    CHECK(service.force_N() == glm::dvec3(0));
  }
}

TEST_CASE("inverse3 socket: a live run goes on when its service was away for a moment, and says so") {
  ServiceOptions with;
  with.closes_after = 100;
  with.closes = 1;
  const Service service(with);
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  options.devices = {{{"left", service.address() + "#049D"}}, true};
  const RunOutcome outcome = run_scenario(live_inverse3("3 s"), options);
  INFO(outcome.failure << outcome.repeat_difference);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  const auto& metrics = outcome.metrics.at("left.force.phase_locked");
  CHECK(metrics.at("unplugged") == 1);
  CHECK_FALSE(service.forces_x_N(1).empty());
  CHECK(service.forces_x_N(1).front() == 0);
  CHECK(service.force_N() == glm::dvec3(0));
}

TEST_CASE("inverse3 socket: evenstep devices lists an arm behind a service, and that another program uses it") {
  ServiceOptions with;
  with.in_use = true;
  const Service service(with);
  const auto devices = [&](const std::string& options) {
    std::FILE* const out =
        ::popen((std::string("'") + EVENSTEP_PROGRAM + "' devices --service " + service.address() + options).c_str(), "r");
    REQUIRE(out);
    std::string text;
    for (int c = 0; (c = std::fgetc(out)) != EOF;) text += static_cast<char>(c);
    CHECK(::pclose(out) == 0);
    return text;
  };
  CHECK_THAT(devices(""), Catch::Contains(service.address() + "#049D  Haply Inverse3\n    reads 3 positions in metres") &&
                              Catch::Contains("; another program uses it\n"));
  CHECK_THAT(devices(" --json"), Catch::Contains("\"driver\": \"inverse3\"") && Catch::Contains("\"serial\": \"049D\""));
  CHECK(service.forces_x_N().empty());
}
