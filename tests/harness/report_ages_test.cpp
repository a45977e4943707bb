// What the age of reports does to a run if a sample carries the time at which it was read, and if it carries the time at
// which its position was taken.

#include <cmath>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr double kSpeed_m_per_s = 0.01, kStep_m = kSpeed_m_per_s / 450;

std::vector<std::string> with_ages(const std::string& jitter, std::vector<std::string> more = {}) {
  std::vector<std::string> set{
      "device.left.motion={ kind = \"constant-velocity\", velocity = [\"0.01 m/s\", \"0 m/s\", \"0 m/s\"], "
      "start = \"smooth 0.2 s\" }",
      "device.left.report_age=\"0.3 ms\"",
      "device.left.report_age_jitter=\"" + jitter + "\"",
      "run.duration=\"4 s\"",
      "run.warmup=\"2 s\"",
      "run.strategies=[\"phase_locked\"]",
      "expect=[]"};
  set.insert(set.end(), more.begin(), more.end());
  return set;
}

RunOutcome run(const std::vector<std::string>& set, ClockKind clock = ClockKind::virtual_clock) {
  RunOptions options;
  options.clock = clock;
  options.allow_no_expectations = true;
  RunOutcome outcome = run_scenario(read("paper/figure-1-spring.toml", set), options);
  INFO(outcome.failure << outcome.repeat_difference);
  REQUIRE(outcome.exit == ExitCode::pass);
  return outcome;
}

double metric_of_left(const RunOutcome& outcome, const std::string& signal, const std::string& name) {
  return outcome.metrics.at("left." + signal + ".phase_locked").at(name);
}

}  // namespace

TEST_CASE("an age that is not followed is an error of velocity times age, and its variation leaves the line") {
  struct Row {
    const char* jitter;
    double least_ticks, most_ticks;  // of 1 ms, from the tick of the position to that of its read
  };
  for (const auto& [jitter, least, most] : {Row{"0.5 ms", 1, 1}, Row{"0.9 ms", 1, 2}, Row{"2.4 ms", 1, 3}}) {
    CAPTURE(jitter);
    const RunOutcome arrival = run(with_ages(jitter, {"device.left.sample_time=\"arrival\""}));
    const double error_m = metric_of_left(arrival, "interaction", "error_max"), tick_m = kSpeed_m_per_s * 1e-3;
    CHECK(error_m <= most * tick_m * (1 + 1e-6));
    CHECK(error_m >= (most - 0.2) * tick_m);
    const double off_m = metric_of_left(arrival, "interaction", "deviation_max");
    CHECK(off_m <= (most - least) * tick_m + 1e-6 * kStep_m);
    if (most > least) CHECK(off_m >= 0.3 * (most - least) * tick_m);
    CHECK(arrival.metrics.at("left.force.phase_locked").count("sample_age_max") == 0);  // nobody knows

    // With ages followed, the error that remains comes from the part of the least age that nobody told: 1 ms less 0.3 ms.
    const RunOutcome taken = run(with_ages(jitter));
    CHECK(metric_of_left(taken, "interaction", "deviation_max") <= 1e-6 * kStep_m);
    CHECK(metric_of_left(taken, "interaction", "velocity_jump") <= 1e-6 * kStep_m);
    CHECK(metric_of_left(taken, "interaction", "error_max") == Approx(0.7e-3 * kSpeed_m_per_s).epsilon(1e-3));
    CHECK(metric_of_left(taken, "interaction", "underruns") == 0);
    CHECK(metric_of_left(taken, "force", "sample_age_max") == Approx((most - least) * 1e-3 + 0.3e-3).epsilon(1e-6));
    CHECK(metric_of_left(taken, "force", "clock_rate_error") == 0);
    CHECK(metric_of_left(taken, "force", "ages_capped") == 0);
    // A tick that no report has come for reads the position of the one before, which is in the ring already.
    const auto& flow = taken.record.strategies.at(0).devices.at(0).flow;
    REQUIRE(flow);
    CAPTURE(flow->samples, flow->samples_repeated);
    CHECK((flow->samples_repeated > 10) == (most > least));
  }
}

TEST_CASE("the least latency is longer by the largest age, and less than that is too little") {
  const RunOutcome young = run(with_ages("0 ms", {"device.left.sample_time=\"arrival\""}));
  const RunOutcome old = run(with_ages("0.9 ms"));
  const double longer_s = metric_of_left(old, "buffers", "latency") - metric_of_left(young, "buffers", "latency");
  CHECK(longer_s == Approx(1.3e-3 + 999e-9).margin(1e-9));
  CHECK(metric_of_left(old, "interaction", "underruns") == 0);
  const double lead_s = metric_of_left(old, "buffers", "lead");
  const RunOutcome less =
      run(with_ages("0.9 ms", {"remap.lead=\"" + std::to_string(std::lround(lead_s * 1e9) - 1'400'000) + " ns\"",
                               "remap.latency=\"20 ms\""}));
  CHECK(metric_of_left(less, "interaction", "underruns") > 0);
}

TEST_CASE(
    "times of events leave the line at half a count of the axis, and a hand that holds still is read without underruns") {
  const auto evdev = [](const char* motion, std::vector<std::string> more) {
    std::vector<std::string> set{"device.left.driver=\"evdev\"",
                                 "device.left.evdev={ travel = [\"24 mm\", \"0 mm\", \"0 mm\"], full_scale = \"10 N\" }",
                                 "device.left.saturation=\"expected\"", std::string("device.left.motion=") + motion};
    set.insert(set.end(), more.begin(), more.end());
    return with_ages("0.9 ms", set);
  };
  const char* const moving =
      "{ kind = \"back-and-forth\", velocity = [\"0.01 m/s\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.2 s\", "
      "straight = \"1 s\", turn = \"0.1 s\" }";
  constexpr double kCount_m = 24e-3 / 65534;
  const RunOutcome arrival = run(evdev(moving, {"device.left.sample_time=\"arrival\""}));
  CHECK(metric_of_left(arrival, "interaction", "deviation_max") > 0.3 * kSpeed_m_per_s * 1e-3);
  CHECK(arrival.metrics.at("left.force.phase_locked").count("sample_age_max") == 0);
  const RunOutcome taken = run(evdev(moving, {}));
  // Half a count, the time of an event cut to whole microseconds, and rounding.
  CHECK(metric_of_left(taken, "interaction", "deviation_max") <= 0.51 * kCount_m + 1e-6 * kSpeed_m_per_s);
  CHECK(metric_of_left(taken, "interaction", "velocity_jump") <= 0.05 * kStep_m);
  CHECK(metric_of_left(taken, "interaction", "underruns") == 0);
  CHECK(metric_of_left(taken, "force", "ages_capped") == 0);
  // The hand moves for a tenth of a second, then holds still without any event, then moves again.
  const char* const halting =
      "{ kind = \"stick-slip\", velocity = [\"1 mm/s\", \"0 m/s\", \"0 m/s\"], stick = \"0.9 s\", slip = \"0.1 s\" }";
  const RunOutcome halts = run(evdev(halting, {}));
  CHECK(metric_of_left(halts, "interaction", "underruns") == 0);
  CHECK(metric_of_left(halts, "force", "ages_capped") == 0);
  CHECK(metric_of_left(halts, "force", "stale") > 1000);
  // If the scenario gives a shorter interval than the device has, the hand seems to hold still between two reports. Its
  // positions are then off the line by the way between two reports.
  const RunOutcome hasty = run(
      evdev(moving, {"device.left.evdev.report_interval=\"0.01 ms\"", "device.left.rate=\"4 kHz\"",
                     "device.left.report_age=\"0 ms\"", "device.left.report_age_jitter=\"0 ms\"",
                     "device.left.sample_time=\"taken\"", "device.left.faults=[{kind=\"lost\", at=\"3 s\", ticks=40}]"}));
  CHECK(metric_of_left(hasty, "interaction", "deviation_max") > 0.09 * kSpeed_m_per_s * 1e-1);
}

TEST_CASE("the time at which a sample was taken is an input of a live run, which replays to the same trace") {
  const RunOutcome live = run(with_ages("0.9 ms", {"run.duration=\"0.7 s\"", "run.warmup=\"0.3 s\"",
                                                   "remap.latency=\"60 ms\"", "remap.lead=\"20 ms\""}),
                              ClockKind::wall);
  CHECK(live.repeat_difference.empty());
  CHECK(metric_of_left(live, "force", "sample_age_max") > 0);
}
