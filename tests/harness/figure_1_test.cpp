// Figure 1 on the spring: what the whole path must give, against closed forms.
//
// Reference case: T = 1/30 s, V = 11.1 ms, N = 15, s = (T - V) / N = 1.482222 ms, Z = V, h = 1 ms, tau = T / N.
//   least latency, any phase, hold:  s + Z (1 - 1/N) + h = 12.842222 ms      linear: + tau = 15.064444 ms
// on integer nanoseconds h counts as h - 1 ns and each floor may add 1 ns, hence the 2 ns below.

#include <cmath>

#include "evenstep/harness/sizing.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::int64_t kHold_ns = 12'842'222;
constexpr std::int64_t kLinear_ns = 15'064'444;

std::int64_t late(const RunRecord& run, const std::string& name) {
  std::int64_t count = 0;
  for (const StepRow& step : strategy(run, name).steps) count += step.mapped && step.end > step.emission;
  return count;
}
std::int64_t missing(const RunRecord& run, const std::string& name) {
  std::int64_t count = 0;
  for (const StepSample& sample : strategy(run, name).devices[0].steps) count += sample.read == StepRead::underrun;
  return count;
}
std::string ns(std::int64_t value) {
  return std::to_string(value / 1'000'000) + "." + std::to_string(1'000'000 + value % 1'000'000).substr(1) + " ms";
}

}  // namespace

TEST_CASE("the shipped figure-1-spring scenario holds every expectation") {
  for (const char* file : {"paper/figure-1-spring.toml", "paper/figure-1-spring-hold.toml", "paper/steps-first.toml",
                           "paper/no-visualization.toml", "paper/ties.toml"}) {
    const RunOutcome outcome = run_scenario(read(file), {});
    for (const ExpectationResult& result : outcome.results) {
      INFO(file << ":" << result.line << " " << result.signal << " " << result.metric << " " << result.value.value_or(NAN)
                << " " << result.detail);
      CHECK(result.verdict == ExpectationResult::Verdict::pass);
    }
    CHECK(outcome.exit == ExitCode::pass);
  }
}

TEST_CASE("the least latencies are the closed form's, to the nanosecond") {
  const auto hold = plan(read("paper/figure-1-spring-hold.toml"));
  const auto linear = plan(read("paper/figure-1-spring.toml"));
  const auto here =
      plan(read("paper/figure-1-spring-hold.toml", {"remap.lead=minimal-this-phase", "remap.latency=minimal-this-phase"}));
  for (std::size_t i = 2; i < 4; ++i) {
    INFO(name_of(hold[i].kind));
    CHECK(std::abs(hold[i].latency.ns - kHold_ns) <= 2);
    CHECK(std::abs(linear[i].latency.ns - kLinear_ns) <= 2);
    CHECK(std::abs(hold[i].lead.ns - 260'000) <= 2);  // h - V/N
    // At this phase (0) reads fall on a grid of 1/9 ms. The worst one is 1/9 ms before its tick, so c = 0.111111 ms and
    // L = 12.693333 ms; with the lead of the run it is the same at all phases.
    CHECK(std::abs(hold[i].sizing.this_phase.lead.ns - 111'111) <= 1);
    CHECK(std::abs(here[i].latency.ns - 12'693'333) <= 2);
    CHECK(hold[i].sizing.this_phase.latency == hold[i].latency);
  }
}

TEST_CASE("at this phase the least lead and latency underrun nothing, and one nanosecond less underruns", "[sweep]") {
  const std::string name = GENERATE(std::string("paper"), std::string("phase_locked"));
  const std::string file = "paper/figure-1-spring-hold.toml";
  const std::vector<StrategyPlan> plans = plan(read(file, {"remap.lead=minimal-this-phase"}));
  const LatencyBudget least = plans[name == "paper" ? 2 : 3].sizing.this_phase;
  const auto set = [&](std::int64_t lead, std::int64_t latency) {
    return std::vector<std::string>{"remap.lead=" + ns(lead), "remap.latency=" + ns(latency)};
  };
  const RunRecord exact = run_all(read(file, set(least.lead.ns, least.latency.ns)));
  CHECK(late(exact, name) == 0);
  CHECK(missing(exact, name) == 0);
  const RunRecord less_latency = run_all(read(file, set(least.lead.ns, least.latency.ns - 1)));
  CHECK(late(less_latency, name) > 0);
  CHECK(missing(less_latency, name) == 0);
  const RunRecord less_lead = run_all(read(file, set(least.lead.ns - 1, least.latency.ns)));
  CHECK(missing(less_lead, name) > 0);
}

TEST_CASE("at the worst device phase the any-phase lead underruns nothing, and one nanosecond less underruns") {
  const std::string file = "paper/figure-1-spring-hold.toml";
  const Scenario scenario = read(file);
  const StrategyPlan locked = plan(scenario)[3];
  const std::vector<MappedStep> steps = steps_of(scenario, locked);
  // At the worst phase the step that set the lead reads exactly on a tick. With a read time 1 ns later it would need the
  // next tick, and that comes 1 ns after the step began.
  const auto& culprit = *std::find_if(steps.begin(), steps.end(),
                                      [&](const MappedStep& s) { return s.step == locked.sizing.any_phase.lead_culprit; });
  const std::int64_t read_ns = (culprit.slot - locked.lead).ns;
  const std::int64_t phase_ns = read_ns % 1'000'000;
  const std::vector<std::string> phase{"device.left.phase=" + ns(phase_ns)};
  std::vector<std::string> less = phase;
  less.push_back("remap.lead=" + ns(locked.lead.ns - 1));
  CHECK(missing(run_all(read(file, phase)), "phase_locked") == 0);
  CHECK(missing(run_all(read(file, less)), "phase_locked") > 0);
}

TEST_CASE("V + s underruns at phase 0 and not at phase 0.5 ms") {
  const std::vector<std::string> v_plus_s{"remap.latency=12.582222 ms", "remap.lead=minimal-this-phase"};
  std::vector<std::string> half = v_plus_s;
  half.push_back("device.left.phase=0.5 ms");
  const std::string file = "paper/figure-1-spring-hold.toml";
  CHECK(late(run_all(read(file, v_plus_s)), "phase_locked") > 0);
  CHECK(late(run_all(read(file, half)), "phase_locked") == 0);
}

TEST_CASE("a run counts the underruns that the sizing pass predicts, at any lead and latency", "[sweep]") {
  for (const char* lead : {"0 ms", "0.05 ms", "0.2 ms", "1 ms"}) {
    for (const char* latency : {"8 ms", "12 ms", "12.7 ms", "14 ms"}) {
      const Scenario scenario =
          read("paper/figure-1-spring-hold.toml",
               {std::string("remap.lead=") + lead, std::string("remap.latency=") + latency, "run.duration=2 s",
                "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }"});
      const RunOutcome outcome = run_scenario(scenario, {});
      for (const std::string name : {"paper", "phase_locked"}) {
        INFO(name << " lead " << lead << " latency " << latency);
        const DeviceRecord& predicted = strategy(outcome.record, name).devices[0];
        CHECK(outcome.metrics.at("left.interaction." + name).at("underruns") ==
              static_cast<double>(predicted.predicted_interaction_underruns));
        if (name == "phase_locked") {  // `paper` repairs backward steps by later emissions: fewer are late than predicted
          CHECK(outcome.metrics.at("left.force." + name).at("underruns") ==
                static_cast<double>(predicted.predicted_late_forces));
        }
      }
    }
  }
}

TEST_CASE("on an even schedule the remap hands the solver what direct does, bit for bit, and ideal the motion itself") {
  const RunRecord run = run_all(read("paper/no-visualization.toml"));
  const auto& direct = strategy(run, "direct").devices[0].steps;
  for (const char* name : {"paper", "phase_locked", "ideal"}) {
    const auto& other = strategy(run, name).devices[0].steps;
    std::int64_t different = 0;
    double farthest_m = 0;
    for (std::size_t n = 0; n < std::min(direct.size(), other.size()); ++n) {
      different += direct[n].position_m != other[n].position_m;
      farthest_m = std::max(farthest_m, std::abs(direct[n].position_m[0] - other[n].position_m[0]));
    }
    INFO(name);
    if (std::string(name) != "ideal") CHECK(different == 0);
    CHECK(farthest_m < 0.51e-9);  // reports are whole nanometres
  }
}

TEST_CASE("every launch on a tick sees that tick's sample") {
  const RunRecord run = run_all(read("paper/ties.toml"));
  const StrategyRecord& direct = strategy(run, "direct");
  std::int64_t ties = 0, seen = 0;
  for (std::size_t n = 0; n < direct.steps.size(); ++n) {
    if (direct.steps[n].begin.ns % 1'000'000 != 0) continue;
    ++ties;
    const std::size_t tick = static_cast<std::size_t>(direct.steps[n].begin.ns / 1'000'000);
    seen += direct.devices[0].steps[n].position_m == direct.devices[0].ticks[tick].position_m;
  }
  CHECK(ties == 1000);  // 4 s of segments of 32 ms with 8 launches on a tick each
  CHECK(seen == ties);
}

TEST_CASE("leaving strategies out changes no other's trace") {
  const RunRecord all = run_all(read("paper/figure-1-spring.toml"));
  for (const char* alone : {"direct", "paper", "phase_locked"}) {
    const RunRecord run =
        run_all(read("paper/figure-1-spring.toml", {std::string("run.strategies=[\"") + alone + "\"]",
                                                    std::string("run.live=\"") + alone + "\"", "expect=[]"}));
    CHECK(strategy(run, alone).trace_hash == strategy(all, alone).trace_hash);
  }
}
