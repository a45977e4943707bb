// Underrun policies and the strategies that stand beside the map, in the whole loop.

#include <cmath>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/loop/recorder.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/sim/solver.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::string kSpring = "paper/figure-1-spring.toml";
constexpr double kStep_m = 0.1 / 450;  // 0.1 m/s

std::vector<std::string> with(std::vector<std::string> set, const std::vector<std::string>& more) {
  set.insert(set.end(), more.begin(), more.end());
  return set;
}
std::vector<std::string> jitter(int percent) {
  const std::string cv = "\"lognormal " + std::to_string(percent) + " %\"";
  return {"timing.jitter={ visualization = " + cv + ", step = " + cv + " }"};
}
const std::vector<std::string> kGate{"remap.underrun={ interaction = \"gate\" }", "remap.lead=\"0 ms\"", "expect=[]"};

Rows<UnderrunRow> rows(const StrategyRecord& record, UnderrunRow::Side side) {
  Rows<UnderrunRow> out;
  for (const UnderrunRow& row : record.underruns) {
    if (row.side == side) out.push_back(row);
  }
  return out;
}
Duration total(const Rows<UnderrunRow>& rows) {
  Duration sum;
  for (const UnderrunRow& row : rows) sum = sum + row.lateness;
  return sum;
}
std::int64_t count(const StrategyRecord& record, StepRead read) {
  std::int64_t count = 0;
  for (const StepSample& sample : record.devices[0].steps) count += sample.read == read;
  return count;
}

// What a step has found, and what its read then counts as
struct Found {
  SlotKind slot;
  ReadStatus status;
  Duration waited;
  StepRead read, of_one_that_predicts;
};
constexpr Duration kLacking{40};
Task record(Scheduler& scheduler, StepRecorder& recorder, const SolverStep& step, const std::vector<Found>& found) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto n = static_cast<std::int64_t>(i);
    co_await scheduler.until(RealTime{100 * n}, Lane::launch, "step");
    const Slot slot{RealTime{100 * n}, found[i].slot};
    recorder.hand(0, n, slot, {{}, found[i].status, slot.read - kLacking}, found[i].waited);
    recorder.step(scheduler, {}, {}, slot, slot.read, {}, step);
  }
}

}  // namespace

TEST_CASE("a gate waits in all as long as the worst step must, and no longer", "[sweep]") {
  // Step n needs the first tick at or after R(n) to be at or before S(n) + W(n), where W(n) is what was waited before step
  // n. So W rises to the largest of these needs and stays there. Waits do not move the reads: the map counts work time only.
  for (const int percent : {0, 1, 10}) {
    const std::vector<std::string> timing = percent == 0 ? std::vector<std::string>{} : jitter(percent);
    const Scenario free = read(kSpring, with(timing, {"run.duration=\"10 s\"", "expect=[]"}));
    const Scenario gated = read(kSpring, with(with(timing, {"run.duration=\"10 s\""}), kGate));
    const RunRecord run = run_all(gated);
    for (const StrategyPlan& plan : plan(free)) {
      if (!is_remap(plan.kind)) continue;
      const StrategyRecord& record = strategy(run, name_of(plan.kind));
      INFO(percent << " % " << record.name);
      CHECK(count(record, StepRead::underrun) == 0);
      const Rows<UnderrunRow> waits = rows(record, UnderrunRow::Side::interaction);
      CHECK(static_cast<std::int64_t>(waits.size()) == count(record, StepRead::gated));
      REQUIRE(!waits.empty());
      Duration need;
      for (const MappedStep& step : steps_of(free, plan)) {
        const Rate rate{1000, 1};
        need = std::max(need, tick_time(rate, first_tick_at_or_after(rate, step.slot)) - step.begin);
      }
      CHECK(total(waits) == need);
      CHECK(need <= plan.sizing.any_phase.lead);
      for (const UnderrunRow& wait : waits) CHECK(wait.policy == "gate");
    }
  }
}

TEST_CASE("a gated run loses as much time as it waited once, so that its segments stay as long as they were", "[sweep]") {
  const RunRecord free = run_all(read(kSpring, with(jitter(10), {"run.duration=\"30 s\"", "expect=[]"})));
  const RunRecord gated = run_all(read(kSpring, with(with(jitter(10), {"run.duration=\"30 s\""}), kGate)));
  for (const char* name : {"paper", "phase_locked"}) {
    const StrategyRecord &a = strategy(free, name), &b = strategy(gated, name);
    REQUIRE(b.segments.size() > 800);
    const std::size_t last = b.segments.size() - 1;
    const auto length = [last](const StrategyRecord& r) { return (r.segments[last].begin - r.segments[0].begin).ns; };
    INFO(name);
    const std::int64_t lost_ns = length(b) - length(a);
    CHECK(lost_ns >= 0);
    CHECK(lost_ns <= total(rows(b, UnderrunRow::Side::interaction)).ns);
    CHECK(static_cast<double>(lost_ns) <= 1e-3 * static_cast<double>(length(a)));  // ratcheting costs 4 %
  }
}

TEST_CASE("idle time takes up what a gate has waited: paced segments begin on their grid") {
  // 15 steps of 1.3 ms leave 2.7 ms of idle time in each segment. That is more than any wait (a device period at most). The
  // reads are as even as without waits, so each segment has to wait again.
  const RunRecord run = run_all(read(kSpring, with({"timing.step=\"1.3 ms\""}, kGate)));
  for (const char* name : {"paper", "phase_locked"}) {
    const StrategyRecord& record = strategy(run, name);
    INFO(name);
    CHECK(count(record, StepRead::gated) > 20);
    CHECK(count(record, StepRead::underrun) == 0);
    for (const SegmentRow& segment : record.segments) REQUIRE(segment.begin == tick_time({30, 1}, segment.index));
  }
}

TEST_CASE("the least latency of a gated schedule lets no force be late at this phase, and one nanosecond less does",
          "[sweep]") {
  for (const int percent : {0, 10}) {
    const std::vector<std::string> base = with(with(percent == 0 ? std::vector<std::string>{} : jitter(percent), kGate),
                                               {"run.strategies=[\"phase_locked\"]"});
    const StrategyPlan least = plan(read(kSpring, with(base, {"remap.latency=\"minimal-this-phase\""}))).front();
    for (const int less : {0, 1}) {
      const std::string latency = "remap.latency=\"" + std::to_string(least.latency.ns - less) + " ns\"";
      const RunRecord run = run_all(read("paper/figure-1-spring-hold.toml", with(base, {latency})));
      const RunRecord linear = run_all(read(kSpring, with(base, {latency})));
      // The linear latency is a slot more than the end of the step itself needs. With hold emission nothing is nearly late.
      CHECK(rows(strategy(run, "phase_locked"), UnderrunRow::Side::force).empty());
      CHECK(rows(strategy(linear, "phase_locked"), UnderrunRow::Side::force).empty() == (less == 0));
    }
    const StrategyPlan hold =
        plan(read("paper/figure-1-spring-hold.toml", with(base, {"remap.latency=\"minimal-this-phase\""}))).front();
    for (const int less : {0, 1}) {
      const std::string latency = "remap.latency=\"" + std::to_string(hold.latency.ns - less) + " ns\"";
      const RunRecord run = run_all(read("paper/figure-1-spring-hold.toml", with(base, {latency})));
      INFO(percent << " % " << latency);
      CHECK(rows(strategy(run, "phase_locked"), UnderrunRow::Side::force).empty() == (less == 0));
    }
  }
}

TEST_CASE("the any-phase latency of a gated schedule is what its worst phase needs, to the nanosecond") {
  for (const int percent : {1, 10}) {
    Scenario gated =
        read("paper/figure-1-spring-hold.toml",
             with(with(jitter(percent), kGate), {"run.strategies=[\"phase_locked\"]", "run.duration=\"0.5 s\""}));
    const StrategyPlan any = plan(gated).front();
    // At the worst phase a tick comes 1 ns before the read time of some step, which then waits for the next tick. Every step
    // is tried.
    const std::vector<MappedStep> steps = steps_of(gated, any);
    REQUIRE(steps.size() > 100);
    Duration largest;
    for (const MappedStep& step : steps) {
      const std::int64_t period_ns = 1'000'000, before_read_ns = step.slot.ns - any.lead.ns - 1;
      gated.devices[0].phase = {((before_read_ns % period_ns) + period_ns) % period_ns};
      largest = std::max(largest, plan(gated).front().sizing.this_phase.latency);
    }
    INFO(percent << " %");
    CHECK(any.latency == largest);
  }
}

TEST_CASE("on the line that a hand moves on, extrapolation replaces every missing sample exactly") {
  // With lead 0, periodic timing at phase 0 misses samples in every segment. `clamp` then uses the newest sample.
  const std::vector<std::string> base{"remap.lead=\"0 ms\"", "run.strategies=[\"phase_locked\"]", "expect=[]"};
  const RunOutcome clamped = run_scenario(read(kSpring, base), {});
  const RunOutcome line = run_scenario(read(kSpring, with(base, {"remap.underrun={ interaction = \"extrapolate\" }"})), {});
  const std::string signal = "left.interaction.phase_locked";
  CHECK(metric_of(clamped, signal, "underruns") == metric_of(line, signal, "underruns"));
  CHECK(metric_of(line, signal, "underruns") > 30);                     // one in every third segment
  CHECK(metric_of(clamped, signal, "velocity_jump") > 0.02 * kStep_m);  // a sample is up to 1/9 ms too old
  CHECK(metric_of(line, signal, "velocity_jump") <= 1e-6 * kStep_m);
  const StrategyRecord& record = strategy(line.record, "phase_locked");
  for (const UnderrunRow& row : record.underruns) {
    CHECK(row.policy == "extrapolate");
    CHECK(row.lateness.ns > 0);
    CHECK(row.lateness.ns <= 111'112);  // reads fall on a grid of 1/9 ms
  }
}

TEST_CASE("late forces of a spring on a line, extrapolated, are the line, held, they are not") {
  const std::vector<std::string> base{"remap.latency=\"11 ms\"", "run.strategies=[\"phase_locked\"]", "expect=[]"};
  const RunOutcome held = run_scenario(read(kSpring, base), {});
  const RunOutcome line = run_scenario(read(kSpring, with(base, {"remap.underrun={ force = \"extrapolate\" }"})), {});
  const std::string signal = "left.force.phase_locked";
  const double step_N = 200 * kStep_m;
  CHECK(metric_of(held, signal, "late") > 100);
  CHECK(metric_of(held, signal, "late") == metric_of(line, signal, "late"));
  CHECK(metric_of(held, signal, "deviation_max") > 0.1 * step_N);
  CHECK(metric_of(line, signal, "deviation_max") <= 1e-6 * step_N);
  const auto late = rows(strategy(line.record, "phase_locked"), UnderrunRow::Side::force);
  REQUIRE(!late.empty());
  CHECK(late.front().policy == "extrapolate");
}

TEST_CASE("every underrun that is counted is a row of the log, with its lateness") {
  const std::vector<std::string> set =
      with(jitter(10), {"remap.latency=\"14 ms\"", "remap.lead=\"0.5 ms\"", "run.warmup=\"0 s\"", "expect=[]"});
  const RunOutcome outcome = run_scenario(read(kSpring, set), {});
  for (const char* name : {"paper", "phase_locked"}) {
    const StrategyRecord& record = strategy(outcome.record, name);
    const auto interaction = rows(record, UnderrunRow::Side::interaction), force = rows(record, UnderrunRow::Side::force);
    INFO(name);
    CHECK(static_cast<double>(interaction.size()) ==
          metric_of(outcome, std::string("left.interaction.") + name, "underruns"));
    CHECK(static_cast<double>(force.size()) == metric_of(outcome, std::string("left.force.") + name, "underruns"));
    CHECK(!interaction.empty());
    CHECK(!force.empty());
    for (const UnderrunRow& row : force) {
      const StepRow& step = record.steps[static_cast<std::size_t>(row.step)];
      CHECK(row.lateness == step.end - record.steps[static_cast<std::size_t>(row.step) - 1].emission);
      CHECK(row.lateness.ns > 0);
    }
    for (const UnderrunRow& row : interaction) CHECK(row.lateness.ns > 0);
  }
}

TEST_CASE("a step before the first sample is an underrun with every strategy, and the gate of a map waits for that sample") {
  // Steps first: the first step begins at 0, half a period before the first tick.
  for (const bool gate : {false, true}) {
    Scenario scenario = read(kSpring, with({"timing.order=\"steps-first\"", "run.duration=\"1 s\""},
                                           gate ? kGate : std::vector<std::string>{"expect=[]"}));
    scenario.devices[0].phase = Duration{500'000};
    std::size_t strategies = 0;
    for (const StrategyRecord& record : run_all(scenario).strategies) {
      if (record.name == "ideal") continue;
      INFO(record.name << ", gate " << gate);
      ++strategies;
      const bool waits = gate && record.name != "direct";
      CHECK(record.devices[0].steps[0].read == (waits ? StepRead::gated : StepRead::underrun));
      CHECK(record.devices[0].steps[1].read != StepRead::gated);
      const Rows<UnderrunRow> underruns = rows(record, UnderrunRow::Side::interaction);
      REQUIRE(underruns.size() > 0);
      CHECK(underruns[0].step == 0);
      CHECK(underruns[0].lateness == Duration{waits ? 500'000 : 0});
    }
    CHECK(strategies == 3);
  }
}

TEST_CASE("predict has no latency and is exact on a line, its forces come on time") {
  const std::vector<std::string> base{"run.strategies=[\"predict\"]", "expect=[]"};
  const RunOutcome outcome = run_scenario(read(kSpring, base), {});
  const StrategyRecord& record = strategy(outcome.record, "predict");
  CHECK(metric_of(outcome, "left.interaction.predict", "velocity_jump") <= 1e-6 * kStep_m);
  CHECK(metric_of(outcome, "left.interaction.predict", "underruns") == 0);
  CHECK(metric_of(outcome, "left.force.predict", "late") == 0);
  CHECK(metric_of(outcome, "left.force.predict", "schedule_latency") == 0);
  CHECK(count(record, StepRead::predicted) > 1000);
  for (const StepRow& step : record.steps) {
    if (step.mapped) REQUIRE(step.read == step.emission);
  }
}

TEST_CASE("after a dead stop predict runs on by its horizon, where a remap does not run on at all") {
  // x = x0 + v t until the stop. If the newest sample is the one at the stop, the prediction runs on by v times the time
  // from that sample to R. With hold emission the longest such time is s + V (1 - 1/N) less the newest sample's distance
  // before S, and it is more than s. An error of 0.5 mm takes 5 ms at 0.1 m/s.
  const std::vector<std::string> base{
      "run.strategies=[\"phase_locked\", \"predict\"]",
      "device.left.motion={ kind = \"ramp-stop\", velocity = [\"0.1 m/s\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.2 s\", "
      "stop = \"2 s\" }",
      "expect=[]"};
  const RunOutcome outcome = run_scenario(read(kSpring, base), {});
  CHECK(metric_of(outcome, "left.interaction.predict", "error_at_stop") >= 0.5e-3);
  CHECK(metric_of(outcome, "left.interaction.predict", "error_at_stop") <= 0.1 * 16e-3);
  // Interpolation cuts the corner of the stop: at most v h / 4 = 25 um with the stop in the middle of two samples.
  CHECK(metric_of(outcome, "left.interaction.phase_locked", "error_at_stop") <= 25e-6);
}

TEST_CASE("a filter weakens and delays what a remap only delays") {
  const char* filter = GENERATE("{ kind = \"moving-average\"", "{ kind = \"butterworth\"",
                                "{ kind = \"one-euro\", min_cutoff = \"5 Hz\", beta = 0.0");
  for (const std::string on : {"interaction", "force"}) {
    const std::vector<std::string> base{
        "run.strategies=[\"direct\", \"filtered\", \"phase_locked\"]",
        std::string("remap.filter=") + filter + ", on = \"" + on + "\" }",
        "device.left.motion={ kind = \"sine\", amplitude = [\"10 mm\", \"0 mm\", \"0 mm\"], frequency = \"5 Hz\" }",
        "expect=[]"};
    const RunOutcome outcome = run_scenario(read(kSpring, base), {});
    INFO(filter << " on " << on);
    const auto of = [&](const std::string& name, const char* what) {
      return metric_of(outcome, "left." + on + "." + name, what);
    };
    CHECK(of("phase_locked", "gain") > 0.999);  // linear between samples 1 ms and forces 2.2 ms apart
    CHECK(of("phase_locked", "gain") < 1.0);
    CHECK(of("filtered", "gain") < 0.98);
    CHECK(of("filtered", "phase_delay") > of("direct", "phase_delay") + 10e-3);
    CHECK(of("filtered", "distortion") < of("direct", "distortion"));
    CHECK(of("filtered", "distortion") > of("phase_locked", "distortion"));
  }
}

TEST_CASE("a filter on the force changes no step") {
  const RunRecord run = run_all(read(kSpring, {"run.strategies=[\"direct\", \"filtered\"]", "expect=[]"}));
  const StrategyRecord &direct = strategy(run, "direct"), &filtered = strategy(run, "filtered");
  REQUIRE(direct.steps.size() == filtered.steps.size());
  for (std::size_t n = 0; n < direct.steps.size(); ++n) {
    REQUIRE(direct.devices[0].steps[n].force_N == filtered.devices[0].steps[n].force_N);
  }
}

TEST_CASE("variable steps keep simulation time beside real time") {
  const RunOutcome outcome = run_scenario(read(kSpring, {"run.strategies=[\"variable_step\"]", "expect=[]"}), {});
  const StrategyRecord& record = strategy(outcome.record, "variable_step");
  for (const StepRow& step : record.steps) {  // the sum of 1,800 rounded steps in 4 s
    REQUIRE(step.simulated == SimTime{(step.begin - record.steps[0].begin).ns});
  }
  // Over that time the hand moves evenly. What is left is the age of the newest sample, which is below 1 ms.
  CHECK(metric_of(outcome, "left.interaction.variable_step", "deviation_max") <= 0.1 * 1e-3);
}

TEST_CASE("a lead that is given moves the least latency with it, nanosecond by nanosecond") {
  const std::vector<std::string> hold{"run.duration=\"1 s\"", "expect=[]", "run.strategies=[\"paper\", \"phase_locked\"]"};
  const std::vector<StrategyPlan> least = plan(read("paper/figure-1-spring-hold.toml", with(hold, jitter(10))));
  const std::vector<StrategyPlan> given =
      plan(read("paper/figure-1-spring-hold.toml", with(with(hold, jitter(10)), {"remap.lead=\"3.000001 ms\""})));
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(given[i].lead == Duration{3'000'001});
    CHECK(given[i].lead != least[i].lead);
    CHECK(given[i].latency - given[i].lead == least[i].latency - least[i].lead);
  }
}

TEST_CASE("the ideal twin plays its forces as long after their reads as the latency is, however many wait") {
  const RunOutcome outcome = run_scenario(
      read(kSpring,
           {"remap.latency=\"60 ms\"", "run.strategies=[\"ideal\", \"phase_locked\"]", "run.duration=\"2 s\"", "expect=[]"}),
      {});
  // 27 forces wait. On a line the force is the one that was due 60 ms ago: 200 N/m, 0.1 m/s.
  CHECK(metric_of(outcome, "left.force.ideal", "error_max") == Approx(200 * 0.1 * 0.06).epsilon(1e-6));
  CHECK(metric_of(outcome, "left.force.ideal", "deviation_max") <= 1e-9);
  CHECK(metric_of(outcome, "left.force.ideal", "velocity_jump") <= 1e-9);
}

TEST_CASE("one device that interpolates makes the latency of all of them that of interpolation") {
  const auto latency = [](const std::string& left, const std::string& right) {
    const auto device = [](const std::string& name, const std::string& emission) {
      return "{ name = \"" + name +
             "\", rate = \"1 kHz\", motion = { kind = \"still\" }, render = { kind = \"force\", emission = \"" + emission +
             "\" } }";
    };
    return plan(read(kSpring, {"device=[" + device("left", left) + ", " + device("right", right) + "]", "expect=[]",
                               "run.strategies=[\"phase_locked\"]"}))
        .front()
        .latency;
  };
  CHECK(latency("hold", "linear") == latency("linear", "linear"));
  CHECK(latency("linear", "hold") == latency("linear", "linear"));
  CHECK(latency("hold", "hold") < latency("linear", "linear"));  // by a slot
}

TEST_CASE("a segment that a gate pushed back ends as much later as it began, in the record too") {
  const Scenario scenario =
      read(kSpring, with(with(jitter(10), {"run.duration=\"5 s\"", "run.strategies=[\"phase_locked\"]"}), kGate));
  const RunRecord run = run_all(scenario);
  const StrategyRecord& record = strategy(run, "phase_locked");
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  SegmentTiming programmed;
  std::int64_t pushed = 0;
  for (const SegmentRow& row : record.segments) {
    REQUIRE(timing->next(programmed));
    REQUIRE(row.end - row.begin == programmed.end - programmed.begin);
    pushed += row.begin > programmed.begin;
  }
  CHECK(pushed > 50);  // otherwise hardly any segment was pushed back, and nothing was tested
}

TEST_CASE("what a read counts as follows from what the buffer had, then from the kind of slot") {
  constexpr Duration kNone{}, kWaited{1};
  using enum ReadStatus;
  const std::vector<Found> found{
      {SlotKind::mapped, inside, kNone, StepRead::inside, StepRead::inside},
      {SlotKind::mapped, inside, kWaited, StepRead::gated, StepRead::gated},
      {SlotKind::mapped, underrun, kNone, StepRead::underrun, StepRead::predicted},
      {SlotKind::newest, inside, kNone, StepRead::newest, StepRead::newest},
      {SlotKind::acquiring, inside, kNone, StepRead::acquiring, StepRead::acquiring},
      {SlotKind::acquiring, inside, kWaited, StepRead::gated, StepRead::gated},
      // Nothing was ever there, or what was wanted has left the ring: no kind of slot and no strategy makes that good.
      {SlotKind::mapped, empty, kNone, StepRead::underrun, StepRead::underrun},
      {SlotKind::newest, empty, kNone, StepRead::underrun, StepRead::underrun},
      {SlotKind::acquiring, empty, kNone, StepRead::underrun, StepRead::underrun},
      {SlotKind::mapped, overrun, kNone, StepRead::overrun, StepRead::overrun},
      {SlotKind::newest, overrun, kNone, StepRead::overrun, StepRead::overrun},
      {SlotKind::acquiring, overrun, kNone, StepRead::overrun, StepRead::overrun},
  };
  const Scenario scenario = read(kSpring);
  const std::unique_ptr<Solver> solver = make_solver(scenario.solver, scenario.scene);
  const SolverStep step(*solver, scenario.scene);
  for (const bool predicts : {false, true}) {
    VirtualClock clock;
    InlineExecutor executor;
    Scheduler scheduler(clock, executor);
    StrategyRecord run;
    run.devices.resize(1);
    StepRecorder recorder(run, {.predicts = predicts, .interaction = "clamp", .force = "hold"});
    scheduler.spawn(record(scheduler, recorder, step, found));
    scheduler.run(RealTime{10'000});

    std::vector<Duration> lacked;  // what a step lacked, or waited for, is a row
    for (std::size_t i = 0; i < found.size(); ++i) {
      const StepRead expected = predicts ? found[i].of_one_that_predicts : found[i].read;
      CAPTURE(i, predicts);
      CHECK(run.devices[0].steps[i].read == expected);
      if (expected == StepRead::underrun) lacked.push_back(kLacking);
      if (expected == StepRead::gated) lacked.push_back(kWaited);
    }
    REQUIRE(run.underruns.size() == lacked.size());
    for (std::size_t i = 0; i < lacked.size(); ++i) CHECK(run.underruns[i].lateness == lacked[i]);
  }
}
