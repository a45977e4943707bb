// A latency that adapts, in the whole loop: what the sizing pass predicts of it, what a device feels, and when it behaves
// like a fixed latency.
#include <cmath>

#include "evenstep/harness/sizing.h"
#include "evenstep/reports/figures.h"
#include "evenstep/reports/measures.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::string kHeldSpring = "paper/figure-1-spring-hold.toml";
const std::string kAdaptive = "remap.latency=\"adaptive\"";

std::vector<std::string> jittered(const std::vector<std::string>& more) {
  std::vector<std::string> set{"expect=[]", "run.strategies=[\"paper\", \"phase_locked\"]",
                               "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }"};
  set.insert(set.end(), more.begin(), more.end());
  return set;
}

}  // namespace

TEST_CASE("where timing is constant an adaptive latency gives the trace of the fixed one") {
  const std::vector<std::string> quiet{"expect=[]", "run.strategies=[\"phase_locked\"]"};
  const auto hash = [&](std::vector<std::string> set) {
    set.insert(set.end(), quiet.begin(), quiet.end());
    return run_all(read(kHeldSpring, set)).trace_hash;
  };
  const std::uint64_t fixed = hash({"remap.latency=\"12.842223 ms\""});
  CHECK(hash({kAdaptive, "remap.adapt={ min = \"12.842223 ms\", margin = \"0 ms\" }"}) == fixed);
  CHECK(hash({kAdaptive, "remap.adapt={ min = \"12.842223 ms\", max = \"12.842223 ms\" }"}) == fixed);
  CHECK(hash({kAdaptive}) != fixed);
}

TEST_CASE("the sizing pass foretells the run of an adaptive latency, held and interpolated, and its rings hold") {
  for (const std::string emission : {"hold", "linear"}) {
    for (const std::string force : {"hold", "extrapolate"}) {
      if (emission == "hold" && force == "extrapolate") continue;
      const Scenario scenario = read("paper/figure-1-spring.toml",
                                     jittered({kAdaptive, "remap.adapt={ window = \"0.5 s\", max = \"40 ms\" }",
                                               "device.left.render={ kind = \"force\", emission = \"" + emission + "\" }",
                                               "remap.underrun={ force = \"" + force + "\" }"}));
      const std::vector<StrategyPlan> plans = plan(scenario);
      const RunRecord run = run_all(scenario);
      const Metrics metrics = measure(run);
      for (const StrategyPlan& plan : plans) {
        const std::string name = name_of(plan.kind);
        INFO(name << " " << emission << " " << force);
        const auto& of = metrics.at("left.force." + name);
        const AdaptationForecast forecast = forecast_adaptation(scenario, plan);
        CHECK(of.at("late") == static_cast<double>(plan.predicted[0].late_forces));
        CHECK(of.at("latency_growths") == static_cast<double>(forecast.growths));
        CHECK(forecast.growths > 0);
        if (plan.kind == StrategyKind::phase_locked) {
          CHECK(of.at("schedule_latency") == seconds(forecast.largest));
          CHECK(std::abs(of.at("schedule_latency_mean") - forecast.mean_s) < 1e-12);
        }
        CHECK(of.at("schedule_latency") <= 0.040);
        CHECK(of.at("schedule_latency_p50") < of.at("schedule_latency"));
        CHECK(plan.latency == Duration{40'000'000});
        CHECK(static_cast<double>(plan.force_capacity) == metrics.at("left.buffers." + name).at("force_capacity"));
      }
    }
  }
}

TEST_CASE("a growth is one hold in what the device plays, and the line goes on behind it") {
  // One visualization takes 61.1 ms, all others 11.1 ms. So some 50 ms more latency are needed, once.
  const Scenario scenario = read(
      kHeldSpring, {"expect=[]", "run.strategies=[\"phase_locked\"]", "run.duration=\"3 s\"", kAdaptive,
                    "timing.changes=[{ at = \"1.5 s\", visualization = \"61.1 ms\" }, { at = \"1.55 s\", visualization = "
                    "\"11.1 ms\" }]",
                    "remap.lead=\"1 ms\"", "remap.adapt={ start = \"14 ms\", margin = \"1 ms\" }"});
  const RunRecord run = run_all(scenario);
  const StrategyRecord& record = strategy(run, "phase_locked");
  const Rows<StepRow>& steps = record.steps;
  std::size_t grew = 0;
  std::int64_t late = 0;
  for (std::size_t n = 0; n + 1 < steps.size(); ++n) {
    if (steps[n].begin < RealTime{1'400'000'000}) continue;
    late += steps[n].end > steps[n].emission;
    const Duration by = (steps[n + 1].emission - steps[n + 1].read) - (steps[n].emission - steps[n].read);
    if (grew == 0 && by > Duration{1'000'000}) grew = n;
  }
  REQUIRE(grew > 0);
  CHECK(late == 1);
  const Duration before = steps[grew].emission - steps[grew].read, after = steps[grew + 1].emission - steps[grew + 1].read;
  CHECK(steps[grew].end - steps[grew].read + Duration{1'000'000} == after);
  // At 0.1 m/s and 200 N/m the force is 20 N/s * L behind the hand. Between two growths the force follows a line as before.
  const auto behind_N = [&](RealTime at) {
    const auto tick = std::find_if(record.devices[0].ticks.begin(), record.devices[0].ticks.end(),
                                   [&](const TickRow& row) { return row.at >= at; });
    return 200 * tick->position_m[0] + tick->force_N[0];
  };
  const double d_N = 20 * seconds(after - before);
  const double more_N = behind_N(steps[grew + 20].emission) - behind_N(steps[grew - 20].emission);
  CHECK(std::abs(more_N - d_N) <= 20 * (1e-3 + 1.5 / 450));  // a tick, and stairs of slots that vary by a half
  CHECK(d_N > 0.5);
  CHECK(latency_over_time_svg(run).has_value());
}

TEST_CASE("the picture of the latency is drawn where one adapts and nowhere else") {
  const std::vector<std::string> quiet = jittered({"run.duration=\"1 s\""});
  CHECK_FALSE(latency_over_time_svg(run_all(read(kHeldSpring, quiet))));
  std::vector<std::string> adapts = quiet;
  adapts.push_back(kAdaptive);
  const std::string svg = latency_over_time_svg(run_all(read(kHeldSpring, adapts))).value();
  CHECK_THAT(svg, Catch::Contains(">paper<") && Catch::Contains(">phase_locked<"));
}
