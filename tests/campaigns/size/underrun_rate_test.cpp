// The rate that is predicted from the map alone is the rate that a run with scheduler, device and solver measures.
#include "evenstep/harness/underrun_rate.h"

#include "evenstep/harness/run.h"
#include "evenstep/harness/sizing.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;

namespace {

Scenario spring(const std::vector<std::string>& set) {
  const ReadResult read =
      read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1-spring-hold.toml", {set, std::nullopt});
  for (const Diagnostic& error : read.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(read);
  Scenario scenario = *read;
  scenario.strategies = {StrategyKind::paper, StrategyKind::phase_locked};
  scenario.live = StrategyKind::phase_locked;
  scenario.expectations.clear();
  return scenario;
}

/// Compares every map, side and device of a run with the count from the map alone. Returns how many segments had an
/// underrun.
std::int64_t compare(const Scenario& scenario) {
  const RunOutcome run = run_scenario(scenario, {});
  INFO(run.failure);
  REQUIRE(run.failure.empty());
  REQUIRE(run.errors.empty());
  const std::vector<StrategyPlan> plans = plan(scenario);
  std::int64_t hit = 0;
  for (const RateSignal& signal : rate_signals(scenario)) {
    const auto with = std::find_if(plans.begin(), plans.end(), [&](const StrategyPlan& p) { return p.kind == signal.kind; });
    const RateCount count = count_underrun_segments(scenario, signal, with->lead, with->latency, 1);
    INFO(signal.name);
    REQUIRE(count.segments > 0);
    const double measured = run.metrics.at(signal.name).at("underrun_rate");
    CHECK(measured == static_cast<double>(count.hit) / static_cast<double>(count.segments));
    hit += count.hit;
  }
  return hit;
}

}  // namespace

TEST_CASE("a run under jitter has underruns in as many segments as the map alone counts") {
  std::int64_t hit = 0;
  for (const char* latency : {"latency = \"9 ms\"", "latency = \"14 ms\"", "latency = \"20 ms\""}) {
    for (const char* lead : {"0 ms", "3 ms"}) {
      hit += compare(spring({"run.duration=1.5 s", "run.warmup=3 segments", "timing.paced=true", "timing.step=1.3 ms",
                             "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }",
                             std::string("remap={ lead = \"") + lead + "\", " + latency + " }"}));
    }
  }
  CHECK(hit > 100);  // otherwise hardly anything was compared
}

TEST_CASE("a replayed recording has underruns in as many segments as the map alone counts") {
  for (const char* name : {"paced30-pthread", "paperlike-free-basic", "concurrent-paced30-basic-sub9"}) {
    const std::string trace = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/recorded/" + name + ".csv";
    INFO(name);
    const std::int64_t hit = compare(spring({"run.duration=6 s", "run.warmup=1 s", "timing={ trace = \"" + trace + "\" }",
                                             "scene.step_size=450 Hz", "remap={ lead = \"2 ms\", latency = \"16 ms\" }"}));
    CHECK(hit > 0);
  }
}
