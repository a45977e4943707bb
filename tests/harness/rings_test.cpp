// [remap] rings: a run with the rings that a program of somebody's own has.

#include <algorithm>
#include <filesystem>

#include "evenstep/harness/strategy_run.h"
#include "evenstep/harness/suffered.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct Overruns {
  std::int64_t reads = 0, ticks = 0;
};

StrategyPlan plan_of_the_map(const Scenario& scenario) {
  std::vector<StrategyPlan> plans = plan(scenario);
  return *std::find_if(plans.begin(), plans.end(), [](const StrategyPlan& one) { return is_remap(one.kind); });
}

Overruns overruns(Scenario scenario, std::size_t samples, std::size_t forces) {
  scenario.remap.rings = {samples, forces};
  Overruns found;
  for (const DeviceRecord& device : run_strategy(scenario, plan_of_the_map(scenario), {}).devices) {
    for (const StepSample& step : device.steps) found.reads += step.read == StepRead::overrun;
    found.ticks += device.flow->ticks_overrun;
  }
  return found;
}

Duration phase_at(RealTime tick, Duration period) { return {tick.ns % period.ns}; }

}  // namespace

TEST_CASE("with the rings that are needed nothing overruns, with an entry less something does, in every recording") {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(shipped("recorded"))) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path().filename());
  }
  std::sort(files.begin(), files.end());
  std::size_t of_samples = 0, of_forces = 0;
  for (const std::string& file : files) {
    INFO(file);
    Scenario scenario = read("recorded/" + file, {"run.strategies=[\"phase_locked\"]", "run.duration=\"2 s\"",
                                                  "run.warmup=\"0 s\"", "expect=[]"});
    REQUIRE(scenario.devices.size() == 1);
    REQUIRE(scenario.devices[0].rate.den == 1);
    const Duration period{1'000'000'000 / scenario.devices[0].rate.num};
    const StrategyPlan any = plan_of_the_map(scenario);
    // A ring has four entries at least, so one that needs no more says nothing here.
    const bool many_samples = any.interaction_capacity > 4, many_forces = any.force_capacity > 4;
    of_samples += many_samples;
    of_forces += many_forces;

    // The step whose read has most samples behind it needs them all if a tick comes right after the time that it reads.
    const auto steps = steps_of(scenario, any);
    const auto furthest = std::max_element(steps.begin(), steps.end(), [](const MappedStep& a, const MappedStep& b) {
      return a.begin - a.slot < b.begin - b.slot;
    });
    scenario.devices[0].phase = phase_at(furthest->slot - any.lead + Duration{1}, period);
    CHECK(overruns(scenario, any.interaction_capacity, any.force_capacity).reads == 0);
    if (many_samples) CHECK(overruns(scenario, any.interaction_capacity - 1, any.force_capacity).reads > 0);

    // The force with most others waiting behind it, if a tick comes when it has just been made.
    std::size_t first = 0, most = 0;
    RealTime made;
    for (std::size_t n = 0; n < steps.size(); ++n) {
      while (steps[first].slot + (any.latency - any.lead) < steps[n].end) ++first;
      if (n + 1 - first <= most) continue;
      most = n + 1 - first;
      made = steps[n].end;
    }
    scenario.devices[0].phase = phase_at(made, period);
    CHECK(overruns(scenario, any.interaction_capacity, any.force_capacity).ticks == 0);
    if (many_forces) CHECK(overruns(scenario, any.interaction_capacity, any.force_capacity - 1).ticks > 0);
  }
  CHECK(of_samples >= 12);
  CHECK(of_forces >= 12);
}

TEST_CASE("rings that are too small are suffered, and fail an expectation that asks for none") {
  const std::vector<std::string> small{"remap.rings=[4, 4]", "run.strategies=[\"phase_locked\"]"};
  const auto with = [&](const std::string& expect) {
    std::vector<std::string> set = small;
    set.push_back("expect=" + expect);
    return run_scenario(read("paper/figure-1-spring.toml", set), {});
  };
  const RunOutcome outcome = with("[]");
  CHECK(metric_of(outcome, "left.buffers.phase_locked", "interaction_capacity") == 4);
  CHECK(metric_of(outcome, "left.buffers.phase_locked", "overruns") > 0);
  CHECK(metric_of(outcome, "left.force.phase_locked", "ticks_overrun") > 0);
  CHECK_THAT(suffered_lines(outcome), Catch::Contains("samples overwritten before they were read") &&
                                          Catch::Contains("ticks whose force was overwritten before it was played"));
  const RunOutcome judged = with("[{ signal = \"left.buffers.phase_locked\", metric = \"overruns\", equals = 0 }]");
  CHECK(judged.exit == ExitCode::expectation_failed);
  CHECK_THAT(suffered_lines(judged), !Catch::Contains("samples overwritten"));
}
