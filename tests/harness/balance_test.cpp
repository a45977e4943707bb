// Nothing is lost without being counted: the conservation laws of reports/balance.h on random scenarios in virtual time, and
// on the wall clock while every core is loaded. Nothing here asserts how fast or how late.

#include "evenstep/reports/balance.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include "bytes_for.h"
#include "cases.h"
#include "evenstep/harness/foresee.h"
#include "evenstep/harness/live_run.h"
#include "evenstep/reports/writers.h"
#include "evenstep/scheduler/random.h"
#include "scenarios.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// Draws from a list, and from a range.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : stream_(seed, "balance") {}
  std::string of(const std::vector<std::string>& words) { return words[below(words.size())]; }
  std::uint64_t below(std::uint64_t bound) { return stream_.below(n_++, bound); }

 private:
  RandomStream stream_;
  std::uint64_t n_ = 0;
};

std::string driver(Draw& draw) {
  return draw.of({"driver=\"reference\"",
                  "driver=\"pid\", pid={ travel = [\"2 m\", \"2 m\", \"2 m\"], full_scale = \"100 N\", gain = 1.0 }",
                  "driver=\"evdev\", evdev={ travel = [\"2 m\", \"2 m\", \"0 m\"], full_scale = \"100 N\", gain = 1.0 }"});
}

// Each draw is a statement of its own, because compilers choose the order in which they evaluate the arguments of a call.

std::string faults(Draw& draw) {
  std::string list;
  for (std::uint64_t i = draw.below(4); i > 0; --i) {
    const std::string kind = draw.of({"lost", "duplicated", "late", "cut", "unread", "write-lost", "write-rejected"});
    const std::uint64_t at_ms = 1 + draw.below(140), ticks = 1 + draw.below(60);
    list += fmt::format("{{ kind = \"{}\", at = \"{} ms\", ticks = {} }},", kind, at_ms, ticks);
  }
  return "[" + list + "]";
}

std::string timing(Draw& draw) {
  const std::string order = draw.of({"visualization-first", "steps-first"});
  const std::string visualization = draw.of({"2 ms", "11.1 ms", "25 ms"});
  const std::uint64_t steps = 1 + draw.below(30);
  const std::string more = draw.of({"", ", jitter = { visualization = \"lognormal 10 %\", step = \"lognormal 60 %\" }",
                                    ", hitch = { every = \"0.1 s\", visualization = \"80 ms\" }",
                                    ", spikes = { rate = \"40 Hz\", cost = \"9 ms\" }"});
  return fmt::format("timing={{ segment = \"30 Hz\", order = \"{}\", visualization = \"{}\", steps = {}{} }}", order,
                     visualization, steps, more);
}

std::string run(Draw& draw, std::uint64_t seed) {
  const std::uint64_t duration_ms = 150 + draw.below(350);
  const std::string keep = draw.of({"all", "summary"}), strategy = draw.of({"phase_locked", "paper"});
  const bool interrupted = draw.below(8) == 0;
  const std::uint64_t interrupt_ms = 1 + draw.below(140);
  return fmt::format(
      "run={{ duration = \"{} ms\", seed = {}, keep = \"{}\"{}, strategies = [\"ideal\", \"direct\", \"{}\"] }}",
      duration_ms, seed, keep, interrupted ? fmt::format(", interrupt = \"{} ms\"", interrupt_ms) : "", strategy);
}

std::string remap(Draw& draw, const std::string& emission) {
  const std::uint64_t latency_ms = 1 + draw.below(60), lead_ms = draw.below(10);
  const std::string interaction = draw.of({"clamp", "extrapolate", "gate"});
  const std::string force = emission == "hold" ? "hold" : draw.of({"hold", "extrapolate"});
  return fmt::format(
      "remap={{ latency = \"{} ms\", lead = \"{} ms\", underrun = {{ interaction = \"{}\", force = \"{}\" }} }}", latency_ms,
      lead_ms, interaction, force);
}

std::string device(Draw& draw, const std::string& emission) {
  const std::string rate = draw.of({"125 Hz", "500 Hz", "1 kHz", "8 kHz"}), of_cable = faults(draw), driven = driver(draw);
  const bool unplugged = draw.below(8) == 0;
  const std::uint64_t unplug_ms = 1 + draw.below(140);
  return fmt::format(
      "device=[{{ name = \"left\", motion = {{ kind = \"constant-velocity\", velocity = [\"0.1 m/s\", \"0 m/s\", \"0 m/s\"] "
      "}}, "
      "rate = \"{}\", render = {{ kind = \"force\", emission = \"{}\" }}, faults = {}, {}{} }}]",
      rate, emission, of_cable, driven, unplugged ? fmt::format(", unplug = \"{} ms\"", unplug_ms) : "");
}

/// Settings that overload, stall, interrupt or unplug something, or do several of these at once.
std::vector<std::string> random_settings(std::uint64_t seed) {
  Draw draw(seed);
  const std::string emission = draw.of({"hold", "linear"});
  return {"expect=[]", timing(draw), run(draw, seed), remap(draw, emission), device(draw, emission)};
}

/// Every core runs a thread that never sleeps, for as long as this lives.
class LoadedCores {
 public:
  LoadedCores() {
    for (unsigned core = 0; core < std::max(std::thread::hardware_concurrency(), 1U); ++core) {
      threads_.emplace_back([this] {
        while (!stop_.load(std::memory_order_relaxed)) {
        }
      });
    }
  }
  ~LoadedCores() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

std::int64_t resident_MiB() {
  std::ifstream pages("/proc/self/statm");
  std::int64_t all = 0, resident = 0;
  pages >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE) >> 20;
}

std::int64_t most_resident_MiB() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_maxrss >> 10;
}

/// What a live run must say of itself on any machine, however late it was.
void check_live(const RunOutcome& outcome, std::int64_t ticks_due) {
  INFO(outcome.failure << outcome.repeat_difference);
  REQUIRE(outcome.exit == ExitCode::pass);
  CHECK(imbalances(outcome.record) == std::vector<std::string>{});
  const auto& tick = outcome.metrics.at("events.device.tick");
  CHECK(tick.at("ticks_run") + tick.at("deadline_misses") == static_cast<double>(ticks_due));
  CHECK(tick.at("lateness_p50") <= tick.at("lateness_p99"));
  CHECK(tick.at("lateness_p99") <= tick.at("lateness_p999"));
  CHECK(tick.at("lateness_p999") <= tick.at("lateness_max"));
  const auto& force = outcome.metrics.at("left.force.phase_locked");
  const auto& solver = outcome.metrics.at("solver.phase_locked");
  const double steps = static_cast<double>(strategy(outcome.record, "phase_locked").steps.size());
  CHECK(force.at("forces") == steps);
  CHECK(force.at("forces_sent") + force.at("forces_overtaken") + force.at("forces_dropped") + force.at("forces_pending") ==
        steps);
  CHECK(force.at("reports") == tick.at("ticks_run") - force.at("stale") + force.at("reports_overtaken"));
  CHECK((solver.at("steps_begun") == steps || solver.at("steps_begun") == steps + 1));
  CHECK(solver.at("steps_not_begun") >= 0);
}

RunOutcome run_busy(const std::string& duration, RunOptions options = {}) {
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  const LoadedCores load;
  return run_scenario(read("live/figure-1-spring.toml", {"expect=[]", "run.duration=\"" + duration + "\""}), options);
}

}  // namespace

TEST_CASE("whatever the timing, the device and the policies, nothing is lost without being counted (300 scenarios)") {
  std::int64_t complete = 0, overtaken = 0, pending = 0, late = 0, stopped = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(300); ++seed) {
    const std::vector<std::string> set = random_settings(seed);
    const ReadResult scenario = read_scenario(shipped("paper/figure-1-spring.toml"), {set, std::nullopt});
    CAPTURE(seed, set);
    for (const Diagnostic& error : scenario.error_or({})) UNSCOPED_INFO(text(error));
    REQUIRE(scenario);
    RunOptions options;
    options.allow_no_expectations = true;
    const RunOutcome outcome = run_scenario(*scenario, options);
    INFO(outcome.failure);
    CHECK_THAT(outcome.failure, !Catch::Contains("do not add up"));
    stopped += !outcome.failure.empty();
    if (!outcome.failure.empty()) continue;
    ++complete;
    for (const StrategyRecord& strategy : outcome.record.strategies) {
      REQUIRE(strategy.devices.at(0).flow);
      overtaken += strategy.devices[0].flow->forces_overtaken;
      pending += strategy.devices[0].flow->forces_pending;
      late += std::ssize(strategy.underruns);
    }
  }
  CAPTURE(complete, stopped, overtaken, pending, late);
  CHECK(complete > evenstep::testing::cases(150));
  CHECK(stopped > evenstep::testing::cases(20));
  CHECK((overtaken > evenstep::testing::cases(1000) && pending > evenstep::testing::cases(1000) &&
         late > evenstep::testing::cases(1000)));
}

TEST_CASE("a live run while every core is loaded loses nothing without counting it") {
  const RunOutcome outcome = run_busy("2 s");
  check_live(outcome, 2000);
  REQUIRE(outcome.record.rights);
  CHECK(outcome.record.rights->threads.size() == 3);
}

TEST_CASE("a minute live while every core is loaded loses nothing without counting it", "[million]") {
  check_live(run_busy("60 s"), 60'000);
}

// docs/devices/busy.md shows what this test printed.
TEST_CASE("ten minutes live while every core is loaded lose nothing without counting it", "[.ten-minutes]") {
  const testing::TemporaryFolder folder;
  std::map<int, std::int64_t> resident_at;  // minute -> MiB
  RunOptions options;
  options.control.row_files = std::make_shared<RowFiles>(folder.path());
  options.control.progress = [&](const std::string&, double fraction) {
    for (const int minute : {1, 5, 10}) {
      if (10 * fraction >= minute) resident_at.try_emplace(minute, resident_MiB());
    }
  };
  const RunOutcome outcome = run_busy("600 s", options);
  WARN(live_lines(outcome.record, outcome.metrics)
       << "resident: " << resident_at[1] << " MiB after one minute, " << resident_at[5] << " after five, " << resident_at[10]
       << " after ten, " << resident_MiB() << " after replay and shadows; never more than " << most_resident_MiB());
  check_live(outcome, 600'000);
  CHECK(resident_at[10] <= resident_at[1] + 32);  // MiB: what rows may have in memory between two looks (rows.h)
}

TEST_CASE("one hour in virtual time needs no more memory at its end than after ten minutes", "[long]") {
  const testing::TemporaryFolder folder;
  std::int64_t after_ten_minutes_MiB = 0, at_end_MiB = 0;
  RunOptions options;
  options.allow_no_expectations = true;
  options.control.row_files = std::make_shared<RowFiles>(folder.path());
  options.control.progress = [&](const std::string&, double fraction) {
    if (after_ten_minutes_MiB == 0 && fraction >= 1.0 / 6) after_ten_minutes_MiB = resident_MiB();
    if (fraction >= 1) at_end_MiB = resident_MiB();
  };
  const RunOutcome outcome = run_scenario(
      read("paper/figure-1-spring.toml",
           {"expect=[]", "run.duration=\"3600 s\"", "run.keep=\"summary\"", "run.strategies=[\"phase_locked\"]"}),
      options);
  INFO(outcome.failure);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(imbalances(outcome.record) == std::vector<std::string>{});
  CHECK(outcome.record.strategies.at(0).devices.at(0).ticks.size() == 3'600'000);
  WARN("resident: " << after_ten_minutes_MiB << " MiB after ten minutes, " << at_end_MiB << " MiB after sixty");
  CHECK(at_end_MiB <= after_ten_minutes_MiB + 32);  // MiB: what rows may have in memory between two looks (rows.h)
}

// Left out with sanitizers, because their allocators keep what was freed.
TEST_CASE("sizing a run of two hours needs no more memory than one of two seconds, with or without a gate", "[sweep]") {
  const auto bytes = [](const char* policy, const char* duration) {
    return bytes_for([&] {
      const Scenario scenario =
          read("timing/jitter-1.toml", {std::string("run.duration=\"") + duration + "\"",
                                        std::string("remap.underrun={ interaction = \"") + policy + "\" }"});
      const std::vector<StrategyPlan> plans = plan(scenario);
      foresee_failures(scenario, plans);
      return plans.size() > 1 && plans.back().sizing.has_steps();
    });
  };
  for (const char* policy : {"clamp", "gate"}) {
    const std::int64_t brief = bytes(policy, "2 s"), lasting = bytes(policy, "2 h");
    INFO(policy << ": " << brief << " bytes, " << lasting << " for two hours");
    CHECK(lasting - brief < (8 << 20));  // 3.2 million steps would have 150 MB
  }
}
