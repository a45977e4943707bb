// Runs on the wall clock. Nothing here asserts how fast or how late: the machine decides that. What must hold on any
// machine is that the recorded inputs give the same run again, and that every step got its sample in order.

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/live_devices.h"
#include "evenstep/harness/live_run.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/loop/exchange.h"

#include <filesystem>

#include "../scenarios.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::vector<std::string> kLive{"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "run.duration=\"0.7 s\"",
                                     "expect=[]"};

RunOutcome run_wall(const Scenario& scenario) {
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  return run_scenario(scenario, options);
}

}  // namespace

TEST_CASE("a run on the wall clock replays to the same hash, and shadows use its samples") {
  for (int round = 0; round < 3; ++round) {
    const RunOutcome outcome = run_wall(read("paper/figure-1-spring.toml", kLive));
    INFO(outcome.failure << outcome.repeat_difference);
    CHECK(outcome.exit == ExitCode::pass);
    CHECK(outcome.repeat_difference.empty());
    REQUIRE(outcome.record.strategies.size() == 4);
    const StrategyRecord& live = strategy(outcome.record, "phase_locked");
    const StrategyRecord& shadow = strategy(outcome.record, "direct");
    CHECK_FALSE(live.shadow);
    CHECK(shadow.shadow);
    CHECK(live.steps.size() > 100);
    REQUIRE(shadow.steps.size() == live.steps.size());
    std::int64_t different = 0;
    for (std::size_t n = 0; n < live.steps.size(); ++n) {
      different += shadow.steps[n].begin != live.steps[n].begin || shadow.steps[n].end != live.steps[n].end;
    }
    CHECK(different == 0);
    for (std::size_t k = 1; k < live.devices[0].ticks.size(); ++k) {
      REQUIRE(live.devices[0].ticks[k].at > live.devices[0].ticks[k - 1].at);
      REQUIRE(live.devices[0].ticks[k].lateness.ns >= 0);
    }
  }
}

TEST_CASE("two devices and the OpenCL tissue replay to the same hash") {
  std::vector<std::string> set = small_tissue("opencl");
  set.insert(set.end(), kLive.begin(), kLive.end());
  const RunOutcome outcome = run_wall(read("paper/figure-1.toml", set));
  INFO(outcome.failure << outcome.repeat_difference);
  CHECK(outcome.exit == ExitCode::pass);
}

TEST_CASE("a run that ends inside a step replays to the same hash") {
  for (const char* duration : {"0.3 s", "0.313 s", "0.32 s", "0.3301 s", "0.344 s"}) {
    std::vector<std::string> set = kLive;
    set.push_back(std::string("run.duration=\"") + duration + "\"");
    const RunOutcome outcome = run_wall(read("paper/figure-1-spring.toml", set));
    INFO(duration << outcome.failure << outcome.repeat_difference);
    CHECK(outcome.exit == ExitCode::pass);
  }
}

TEST_CASE("steps as fast as the solver makes them replay to the same hash") {
  std::vector<std::string> set = kLive;
  set.push_back("timing.step=\"real\"");
  const RunOutcome outcome = run_wall(read("paper/figure-1-spring.toml", set));
  INFO(outcome.failure << outcome.repeat_difference);
  CHECK(outcome.exit == ExitCode::pass);
  // Without a programmed floor nothing waits between a step's completion and the next launch.
  const StrategyRecord& live = strategy(outcome.record, "phase_locked");
  std::int64_t pauses = 0;
  for (std::size_t n = 1; n < live.steps.size(); ++n) {
    pauses += live.steps[n].segment == live.steps[n - 1].segment && live.steps[n].begin != live.steps[n - 1].end;
  }
  CHECK(pauses == 0);
}

TEST_CASE("real steps that are spread wait for their slots, with a pause or a burnt one, and replay to the same hash") {
  for (const bool burns : {false, true}) {
    if (burns && !built_with_opencl()) continue;
    std::vector<std::string> set = burns ? small_tissue("opencl") : std::vector<std::string>{};
    set.insert(set.end(), kLive.begin(), kLive.end());
    set.insert(set.end(), {"timing.step=\"real\"", "timing.governor={ steps = \"spread\" }"});
    if (burns) set.emplace_back("timing.visualization=\"burn 4 ms\"");
    const RunOutcome outcome = run_wall(read(burns ? "paper/figure-1.toml" : "paper/figure-1-spring.toml", set));
    INFO(outcome.failure << outcome.repeat_difference);
    CHECK(outcome.exit == ExitCode::pass);
    // 30 Hz and 15 steps: slots of 1/450 s, each rounded down twice.
    const StrategyRecord& live = strategy(outcome.record, "phase_locked");
    std::int64_t early = 0, waited = 0, i = 0;
    for (std::size_t n = 0; n < live.steps.size(); ++n) {
      const bool first = n == 0 || live.steps[n].segment != live.steps[n - 1].segment;
      i = first ? 0 : i + 1;
      early += live.steps[n].begin + Duration{2} < tick_time({450, 1}, 15 * live.steps[n].segment + i);
      waited += !first && live.steps[n].begin > live.steps[n - 1].end;
    }
    CHECK(early == 0);
    CHECK(waited > 0);
  }
}

TEST_CASE("a latency that adapts needs no knowledge of the timing, and replays to the same hash") {
  std::vector<std::string> set = kLive;
  set.insert(set.end(), {"remap.latency=\"adaptive\"", "remap.adapt={ window = \"0.1 s\" }"});
  const RunOutcome outcome = run_wall(read("paper/figure-1-spring.toml", set));
  INFO(outcome.failure << outcome.repeat_difference);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  const StrategyRecord& live = strategy(outcome.record, "phase_locked");
  CHECK_FALSE(live.shadow);
  CHECK(live.latency_growths > 0);  // it starts from 0: the first step of a segment alone takes longer
}

TEST_CASE("a device that is bound to a path is guarded unless the scenario says otherwise, and no other") {
  const std::vector<std::string> set{"device.left.guard={ gain = 0.5, ramp_up = \"10 ms\" }",
                                     "device.left.slew_limit=\"2 kN/s\""};
  const Scenario scenario = read("paper/figure-1.toml", set);
  const Scenario live = with_live_guards(scenario, {{"left", "/dev/hidraw0"}});
  const ForceLimits &bound = live.devices[0].limits, &simulated = live.devices[1].limits;
  CHECK(bound.max_N == 3);
  CHECK(bound.max_slew_N_per_s == 2000);
  CHECK(bound.cut.gain == 0.5);
  CHECK(bound.cut.ramp_up == Duration{10'000'000});
  CHECK(bound.cut.ramp_down == Duration{50'000'000});
  CHECK(bound.cut.max_speed_m_per_s == 1);
  CHECK(bound.cut.stale_force == Duration{100'000'000});
  CHECK(bound.cut.stale_hand == Duration{50'000'000});
  CHECK(simulated.max_N == 100);
  CHECK(simulated.max_slew_N_per_s == 1e6);
  CHECK(simulated.cut.gain == 1);
  CHECK(simulated.cut.stale_hand == kNeverStale);
  CHECK(with_live_guards(read("paper/figure-1.toml", {"device.left.force_limit=\"7 N\""}), {{"", "/dev/hidraw0"}})
            .devices[0]
            .limits.max_N == 7);
  CHECK(with_live_guards(read("paper/figure-1.toml"), {{"", "/dev/hidraw0"}}).devices[0].limits.max_slew_N_per_s == 1000);
}

TEST_CASE("what is replayed is read as of its head, however far the other lane has gone on, with every renderer") {
  const auto ms = [](std::int64_t count) { return RealTime{count * 1'000'000}; };
  const auto render = GENERATE(as<decltype(LinkSpec::render)>{}, RenderForce{}, RenderLocal{},
                               RenderSmith{{100, 100, 0.01, 0.1}, Duration{30'000'000}});
  LinkSpec link;
  link.samples = link.forces = 4;
  link.spare = 30;
  link.render = render;
  std::vector<DeviceInputs> inputs(1);
  for (std::int64_t k = 0; k < 30; ++k) {
    const DeviceSample sample{.read_at = ms(k), .position_m = {0.001 * static_cast<double>(k * k), 0, 0}, .fresh = true};
    // At each tick six forces had been written, at each step six samples.
    inputs[0].ticks.push_back({sample, ms(k), 6, static_cast<std::uint64_t>(k)});
    inputs[0].interaction_heads.push_back(6);
  }
  VirtualClock clock;
  InlineExecutor executor;
  const Scheduler scheduler(clock, executor, {});
  const auto read = [&](int pushed) {
    RecordedExchange exchange({link}, inputs, true);
    for (int i = 0; i < pushed; ++i) {
      ContactRecord contact;
      contact.force_N.x = i * i;
      exchange.respond(0, {ms(i), {}}, contact);
    }
    std::vector<Reading<glm::dvec3>> all;
    for (int k = 0; k < pushed; ++k) {
      const DeviceSample sample = exchange.sense(0, scheduler);
      const Reading<glm::dvec3> force = exchange.play(0, sample).force_N;
      if (k < 6) all.push_back(force);
    }
    for (int at = 0; at < 6; ++at) all.push_back(exchange.hand(0, {ms(at), SlotKind::mapped}));
    return all;
  };
  const std::vector<Reading<glm::dvec3>> then = read(6), later = read(30);
  REQUIRE(then.size() == later.size());
  bool overrun = false;
  for (std::size_t i = 0; i < then.size(); ++i) {
    CAPTURE(i);
    CHECK((then[i].value == later[i].value && then[i].status == later[i].status && then[i].newest == later[i].newest));
    overrun = overrun || then[i].status == ReadStatus::overrun;
  }
  CHECK(overrun);
}

TEST_CASE("a tick looks at the forces before a step can have its sample") {
  // Otherwise a step between both would come after the tick and before it, and the replay would have no order.
  struct Watched : DeviceExchange {
    using DeviceExchange::DeviceExchange;
    std::uint64_t samples_then = 99;
    TickInput look(int tool, const Scheduler& scheduler) override {
      samples_then = samples(tool);
      return DeviceExchange::look(tool, scheduler);
    }
  };
  const Scenario scenario = read("paper/figure-1-spring.toml");
  VirtualClock clock;
  InlineExecutor executor;
  const Scheduler scheduler(clock, executor, {});
  SimulatedDevices devices(scenario, clock);
  LinkSpec link;
  link.samples = link.forces = 4;
  Watched exchange({link}, devices.drivers());
  for (std::uint64_t tick = 0; tick < 3; ++tick) {
    (void)exchange.play(0, exchange.sense(0, scheduler));
    CHECK(exchange.samples_then == tick);
    CHECK(exchange.samples(0) == tick + 1);
  }
}

TEST_CASE("a minimal latency is refused on the wall clock, with the remedy") {
  const RunOutcome outcome = run_wall(read("paper/figure-1-spring.toml"));
  CHECK(outcome.exit == ExitCode::usage);
  REQUIRE(outcome.errors.size() == 1);
  CHECK_THAT(outcome.errors[0].message, Catch::Contains("--set remap.latency="));
}

TEST_CASE("what cannot run on the wall clock is refused there, with the remedy") {
  for (const auto& [set, remedy] : std::vector<std::pair<std::string, std::string>>{
           {"remap.underrun={ interaction = \"gate\" }", "interaction = \"clamp\" or \"extrapolate\""},
           {"run.keep=\"summary\"", "[run] keep"},
           {"run.strategies=[\"direct\", \"jack_dll\"]", "add \"phase_locked\" to 'strategies'"},
           {"timing={ order = \"concurrent\", visualization = \"25 ms\", steps = 15, segment = \"30 Hz\", paced = true }",
            "runs on the virtual clock only"}}) {
    std::vector<std::string> sets = kLive;
    sets.push_back(set);
    const RunOutcome outcome = run_wall(read("paper/figure-1-spring.toml", sets));
    INFO(set);
    CHECK(outcome.exit == ExitCode::usage);
    REQUIRE(outcome.errors.size() == 1);
    CHECK_THAT(outcome.errors[0].message, Catch::Contains(remedy));
  }
}

TEST_CASE("one device for two hands is refused under whatever paths it is named") {
  namespace fs = std::filesystem;
  const Scenario scenario = read("paper/figure-1.toml");  // left and right
  const testing::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  fs::create_directories(folder / "by-id");
  fs::create_symlink("/dev/null", folder / "haptic");
  fs::create_symlink("../haptic", folder / "by-id" / "usb-haptic");
  fs::create_symlink("loop", folder / "loop");
  const auto objection = [&](const std::string& left, const std::string& right) {
    return binding_objection(scenario, {{"left", left}, {"right", right}});
  };
  const std::vector<std::string> same{"/dev/null", "/dev/../dev/null", folder / "haptic", folder / "by-id" / "usb-haptic"};
  for (const std::string& left : same) {
    for (const std::string& right : same)
      CHECK_THAT(objection(left, right), Catch::Contains("--device right=" + right + " is the device of left"));
    for (const std::string& other : {std::string("/dev/zero"), (folder / "loop").string(), (folder / "absent").string()}) {
      CHECK(objection(left, other).empty());
      CHECK_FALSE(objection(other, other).empty());
    }
  }
}
