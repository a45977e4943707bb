// The rows of a live run on their way to files: no row is lost without being counted, no lane allocates, and a longer run
// needs no more memory.

#include "src/log/live_rows.h"

#include <unistd.h>

#include <chrono>
#include <thread>

#include "bytes_for.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/run.h"
#include "evenstep/harness/simulated_devices.h"
#include "recordings.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;
using evenstep::internal::LiveRows;

namespace {

/// The lanes of a live run, with rows that the test makes.
struct LiveLanes {
  Scenario scenario = read("paper/figure-1-spring.toml");
  StrategyPlan plan = evenstep::plan(scenario).back();
  VirtualClock clock;
  SimulatedDevices devices{scenario, clock};
  DeviceExchange exchange{links_of(scenario, plan), devices.drivers()};
  StrategyLanes lanes{
      scenario, plan, make_scenario_solver(scenario, plan.kind), exchange, make_timing(scenario.timing), devices.drivers()};
  InlineExecutor executor;
  Scheduler simulation{clock, executor}, device{clock, executor};
  std::vector<DeviceInputs> added{1};
  std::int64_t slices = 0, ticks = 0, steps = 0, allocated = 0;

  /// A slice of each lane: 20 ticks and 9 steps. Every second slice has a segment whose visualization ends in the next
  /// slice.
  void slice(LiveRows& rows) {
    DeviceRecord& made = lanes.rows().devices[0];
    allocated += made.ticks.capacity() < 20 || added[0].ticks.capacity() < 20 || lanes.rows().steps.capacity() < 9 ||
                 made.steps.capacity() < 9 || added[0].interaction_heads.capacity() < 9;
    for (int i = 0; i < 20; ++i, ++ticks) {
      made.ticks.push_back({.at = RealTime{ticks * 1'000'000}, .lateness = {}});
      added[0].ticks.push_back({.sample = {}, .played_at = {}, .force_head = static_cast<std::uint64_t>(ticks), .order = 0});
    }
    if (slices >= 3) made.springs.resize(20, {.center_m = {1, 2, 3}});
    auto& segments = lanes.rows().segments;
    if (slices % 2 == 0)
      segments.push_back({slices / 2, RealTime{slices}, RealTime{slices + 2}, {{RealTime{slices}, RealTime{slices}}}});
    else
      (*segments.back().visualization)[1] = RealTime{slices};
    for (int i = 0; i < 9; ++i, ++steps) {
      lanes.rows().steps.push_back({.segment = slices / 2, .begin = RealTime{steps}});
      made.steps.push_back({});
      added[0].interaction_heads.push_back(static_cast<std::uint64_t>(steps));
    }
    const RealTime until{20'000'000 * ++slices};
    rows.device_slice(device, until);
    rows.simulation_slice(simulation, until);
  }
};

std::string failure_of(LiveRows& rows) {
  LiveRecording recording;
  try {
    rows.finish(recording);
  } catch (const RunFailure& failure) {
    CHECK(failure.reason == "disk");
    CHECK_FALSE(failure.remedy.empty());
    return failure.what();
  }
  return {};
}

}  // namespace

TEST_CASE(
    "what lanes add comes out as it went in, slice by slice, and each slice begins with columns that have their place") {
  const TemporaryFolder folder;
  const bool in_files = GENERATE(false, true);
  LiveLanes live;
  // A busy machine may give the thread that keeps the rows no time for long, so there is room for nearly all of the slices.
  // The ring still begins anew once.
  constexpr std::size_t kRoom = 1900;
  LiveRows rows(live.scenario, in_files ? std::make_shared<RowFiles>(folder.path()) : nullptr, nullptr, kRoom);
  rows.attach(live.lanes, live.added, live.device, live.simulation);
  rows.start();
  constexpr int kBetween = 100;
  for (int i = 0; i < 2000; ++i) {
    live.slice(rows);
    if (i % kBetween == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  LiveRecording recording;
  rows.finish(recording);
  CHECK(live.allocated == 0);
  const StrategyRecord& kept = live.lanes.rows();
  REQUIRE(kept.devices[0].ticks.size() == 40'000);
  REQUIRE(recording.inputs[0].ticks.size() == 40'000);
  REQUIRE(kept.devices[0].springs.size() == 40'000);
  REQUIRE(kept.steps.size() == 18'000);
  REQUIRE(kept.devices[0].steps.size() == 18'000);
  REQUIRE(recording.inputs[0].interaction_heads.size() == 18'000);
  REQUIRE(kept.segments.size() == 1000);
  std::int64_t different = 0;
  for (std::size_t k = 0; k < 40'000; ++k) {
    different += kept.devices[0].ticks[k].at.ns != static_cast<std::int64_t>(k) * 1'000'000;
    different += recording.inputs[0].ticks[k].force_head != k;
    different += kept.devices[0].springs[k].center_m != (k < 60 ? Vec3{} : Vec3{1, 2, 3});
  }
  for (std::size_t n = 0; n < 18'000; ++n) {
    different += kept.steps[n].begin.ns != static_cast<std::int64_t>(n);
    different += recording.inputs[0].interaction_heads[n] != n;
  }
  for (std::size_t s = 0; s < 1000; ++s) {
    different += kept.segments[s].index != static_cast<std::int64_t>(s);
    different += (*kept.segments[s].visualization)[1].ns != 2 * static_cast<std::int64_t>(s) + 1;
  }
  CHECK(different == 0);
  CHECK(recording.device_check.until == RealTime{40'000'000'000});
  CHECK(recording.simulation_check.until == RealTime{40'000'000'000});
}

TEST_CASE("slices for which nobody comes are lost after ten seconds, from then on all of them, and the run says how many") {
  LiveLanes live;
  LiveRows rows(live.scenario, nullptr, nullptr);
  rows.attach(live.lanes, live.added, live.device, live.simulation);
  for (std::size_t i = 0; i < LiveRows::kSlots + 3; ++i) live.slice(rows);
  CHECK(live.allocated == 0);
  CHECK_THAT(failure_of(rows), Catch::Contains("60 ticks and 27 steps of the live run are lost"));
}

TEST_CASE("rows of a live run that find no room on the disk fail it, and until then its lanes go on") {
  LiveLanes live;
  LiveRows rows(live.scenario, std::make_shared<RowFiles>("/no/such/folder"), nullptr);
  rows.attach(live.lanes, live.added, live.device, live.simulation);
  rows.start();
  for (int i = 0; i < 2000; ++i) {  // 4 MiB of ticks
    live.slice(rows);
    if (i % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  CHECK(live.ticks == 40'000);
  CHECK_THAT(failure_of(rows), Catch::Contains("no room") && Catch::Contains("/no/such/folder"));
}

namespace {

constexpr std::int64_t kEnough = 24 << 20;  // bytes of rows: a third of what 18 s make

/// What a live run in a separate process needed: the most memory that it had, and the bytes of the rows that it made. Its
/// replay and a shadow make as many again.
struct Needed {
  std::int64_t most_bytes = 0, row_bytes = 0;
};

Needed run_apart(const std::string& duration) {
  const TemporaryFolder folder;
  Needed needed;
  needed.most_bytes = bytes_for([&] {
    RunOptions options;
    options.clock = ClockKind::wall;
    options.allow_no_expectations = true;
    options.control.row_files = std::make_shared<RowFiles>(folder.path());
    const RunOutcome outcome = run_scenario(
        read("paper/figure-1-spring.toml",
             {"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "run.duration=\"" + duration + "\"", "expect=[]",
              "run.strategies=[\"direct\", \"phase_locked\"]", "run.warmup=\"0 s\"", "device.left.rate=\"10 kHz\""}),
        options);
    std::int64_t bytes = 0;
    for (const StrategyRecord& strategy : outcome.record.strategies)
      bytes += static_cast<std::int64_t>(strategy.devices.at(0).ticks.size() * (sizeof(TickRow) + sizeof(EventRow)));
    std::ofstream(folder / "bytes") << bytes;
    return outcome.exit == ExitCode::pass;
  });
  std::ifstream(folder / "bytes") >> needed.row_bytes;
  return needed;
}

}  // namespace

// Left out with sanitizers, because their allocators keep what was freed.
TEST_CASE("a live run that lasts six times as long needs no more memory: its rows, its replay and a shadow are in files",
          "[sweep]") {
  const Needed brief = run_apart("3 s");
  Needed lasting;
  std::int64_t more_rows = 0;
  // A busy machine misses ticks, and a missed tick makes no row. Then a longer run is made.
  for (const char* duration : {"18 s", "54 s"}) {
    lasting = run_apart(duration);
    more_rows = lasting.row_bytes - brief.row_bytes;
    if (more_rows >= kEnough) break;
  }
  const std::int64_t more = lasting.most_bytes - brief.most_bytes;
  INFO(brief.row_bytes << " bytes of rows needed " << brief.most_bytes << ", " << lasting.row_bytes << " needed "
                       << lasting.most_bytes);
  if (more_rows < kEnough) FAIL("this machine ran less than a ninth of the ticks: too few rows to judge");
  // Inputs and steps come on top of these rows. 32 MiB of pages may stay in memory (rows.h), and the brief run has some of
  // these, too.
  CHECK(more < more_rows);
  CHECK(more < (40 << 20));
}
