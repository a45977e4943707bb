// The rate that is predicted from the map alone is the rate that a run with scheduler, device and solver measures.
#include "evenstep/harness/underrun_rate.h"

#include "evenstep/harness/run.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/rate_bound.h"
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

TEST_CASE(
    "segments that come together count as one in a rate with a confidence, and those that chose the latency judge less") {
  const std::vector<std::string> jitter{"run.duration=20 s",
                                        "run.warmup=1 s",
                                        "timing.paced=true",
                                        "timing.step=1.3 ms",
                                        "timing.jitter={ visualization = \"lognormal 10 %\" }",
                                        "remap={ lead = \"9 ms\", latency = \"29 ms\" }"};
  const RateBasis apart = rate_basis(spring(jitter), StrategyKind::paper);
  std::vector<std::string> regimes = jitter;
  regimes.push_back("timing.regimes={ factor = 1.3, mean_length = \"20 segments\" }");
  const RateBasis together = rate_basis(spring(regimes), StrategyKind::paper);
  CHECK(apart.alike < 2);
  CHECK(together.alike > 2);
  CHECK_FALSE(together.chosen);
  // D segments count as one: the bound is that of D times fewer.
  const RateBasis five{.alike = 5, .chosen = false, .refused = {}};
  CHECK(underrun_rate_at_most({1000, 10}, five, 0.95) == rate_at_most(2, 200, 0.95));
  CHECK(underrun_rate_at_most({1000, 11}, five, 0.95) == rate_at_most(3, 200, 0.95));
  for (const double rate : {0.3, 0.01, 0.001}) {
    for (const RateBasis& basis : {RateBasis{}, five, RateBasis{.alike = 2.5, .chosen = true, .refused = {}}}) {
      const std::int64_t enough = clean_segments(rate, 0.95, basis);
      CHECK(underrun_rate_at_most({enough, 0}, basis, 0.95) <= rate);
      CHECK(underrun_rate_at_most({enough - 1, 0}, basis, 0.95) > rate);
    }
  }
  regimes.back() = "remap={ lead = \"9 ms\", latency = \"minimal\" }";
  const RateBasis chosen = rate_basis(spring(regimes), StrategyKind::paper);
  CHECK(chosen.chosen);
  CHECK(clean_segments(0.01, 0.95, {.alike = 1, .chosen = true, .refused = {}}) > clean_segments(0.01, 0.95, {}));
}

TEST_CASE("nobody is sure of a rate of underruns in a recording that changes") {
  const std::string trace = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/recorded/h100-render.csv";
  const RateBasis basis = rate_basis(spring({"run.duration=9.9 s", "run.warmup=1 s", "timing={ trace = \"" + trace + "\" }",
                                             "scene.step_size=450 Hz", "remap={ lead = \"2 ms\", latency = \"40 ms\" }"}),
                                     StrategyKind::phase_locked);
  CHECK_THAT(basis.refused, Catch::Contains("it behaves differently than before"));
}
