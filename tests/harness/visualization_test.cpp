// Visualizations that draw or burn: nothing changes under the virtual clock, and on a wall clock their real length counts.
#include "evenstep/harness/visualization.h"

#include <set>

#include "evenstep/draw/canvas.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

Scenario tissue_with(const std::string& visualization, std::vector<std::string> more = {}, bool real_time = false) {
  std::vector<std::string> set = small_tissue("cpu");
  set.insert(set.end(), {"expect=[]", "run.duration=\"0.5 s\"", "timing.visualization=\"" + visualization + "\""});
  set.insert(set.end(), more.begin(), more.end());
  const ReadResult read =
      read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1.toml", {set, {}, {}, real_time});
  REQUIRE(read);
  return *read;
}

RunOutcome run_with(const Scenario& scenario, ClockKind clock, bool picture) {
  RunOptions options;
  options.clock = clock;
  options.allow_no_expectations = true;
  options.control.picture = picture;
  return run_scenario(scenario, options);
}

const std::vector<std::string> kDrawnLive{"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "timing.picture=[64, 48]"};

/// Why nothing can be drawn here; empty if it can.
std::string cannot_draw() {
#ifdef EVENSTEP_SANITIZE_THREAD
  return "Mesa is not instrumented, and its threads wait for each other by futexes, which this sanitizer does not see";
#endif
  TissueScene tissue;
  tissue.lattice = {2, 2, 2};
  tissue.particle_count = 8;
  const TissueMesh mesh(tissue, 0);
  const auto canvas = make_canvas(16, 16, view_of(tissue, 16, 16), mesh.mesh());
  return canvas ? "" : canvas.error().what;
}

}  // namespace

TEST_CASE("visualization: under the virtual clock a run that draws, burns, or is looked at has the same trace hash",
          "[sweep]") {
  const RunOutcome pause = run_with(tissue_with("11.1 ms"), ClockKind::virtual_clock, false);
  REQUIRE(pause.exit == ExitCode::pass);
  CHECK(strategy(pause.record, "phase_locked").tissue.svg.empty());
  for (const char* visualization : {"11.1 ms", "render 11.1 ms", "burn 11.1 ms"}) {
    const RunOutcome other = run_with(tissue_with(visualization), ClockKind::virtual_clock, true);
    CHECK(other.record.trace_hash == pause.record.trace_hash);
    const TissuePicture& picture = strategy(other.record, "phase_locked").tissue;
    CHECK(picture.svg.find("<svg") == 0);
    CHECK(picture.caption.find("left ") != std::string::npos);
    CHECK(strategy(other.record, "direct").tissue.svg.empty());
    CHECK(other.record.visualization.empty());
  }
}

TEST_CASE("visualization: a live run that draws records how long that took, replays to its hash and keeps the drawing") {
  if (const std::string why = cannot_draw(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  for (const char* visualization : {"render", "render 11.1 ms"}) {
    const RunOutcome outcome = run_with(tissue_with(visualization, kDrawnLive, true), ClockKind::wall, true);
    INFO(outcome.failure << outcome.repeat_difference);
    CHECK(outcome.exit == ExitCode::pass);
    CHECK(outcome.record.visualization.find("64 x 48 pixels") != std::string::npos);
    CHECK(outcome.record.drawing_png.find("PNG") == 1);
    const StrategyRecord& live = strategy(outcome.record, "phase_locked");
    CHECK_FALSE(live.tissue.svg.empty());
    REQUIRE(live.segments.size() > 1);
    std::set<std::int64_t> lengths;
    for (const SegmentRow& row : live.segments) {
      REQUIRE(row.visualization);
      const auto& [begin, end] = *row.visualization;
      REQUIRE(begin <= end);
      lengths.insert((end - begin).ns);
    }
    CHECK(lengths.count(11'100'000) == 0);
    CHECK(lengths.size() > 1);
  }
}

TEST_CASE("visualization: a live run that burns takes about as long as it says, and replays to its hash") {
  if (!built_with_opencl()) return;
  const std::vector<std::string> live{kDrawnLive[0], kDrawnLive[1]};
  const RunOutcome outcome = run_with(tissue_with("burn 4 ms", live), ClockKind::wall, false);
  INFO(outcome.failure << outcome.repeat_difference);
  CHECK(outcome.exit == ExitCode::pass);
  const StrategyRecord& run = strategy(outcome.record, "phase_locked");
  REQUIRE(run.segments.size() > 1);
  // How much longer it takes depends on the machine. A launch may end 20 us too early.
  for (std::size_t k = 0; k + 1 < run.segments.size(); ++k) {
    const auto& [begin, end] = *run.segments[k].visualization;
    CHECK(end - begin > Duration{3'900'000});
  }
}

TEST_CASE("visualization: a governor gives a virtual run the same hash whatever is drawn, and keeps its budget") {
  const std::vector<std::string> governor{"timing.governor={ split = 2, budget = \"3 ms\" }"};
  const RunOutcome pause = run_with(tissue_with("11.1 ms", governor), ClockKind::virtual_clock, false);
  INFO(pause.failure);
  REQUIRE(pause.exit == ExitCode::pass);
  CHECK(run_with(tissue_with("render 11.1 ms", governor), ClockKind::virtual_clock, false).record.trace_hash ==
        pause.record.trace_hash);
  CHECK(pause.record.trace_hash != run_with(tissue_with("11.1 ms"), ClockKind::virtual_clock, false).record.trace_hash);
  const auto& values = pause.metrics.at("solver.phase_locked");
  CHECK(values.at("drawing_pause_max") == Approx(3e-3).epsilon(1e-12));
  CHECK(values.at("drawings_left_out") > 0);
  // A drawing of 11.1 ms takes four pauses of 3 ms, so there is one drawing every two segments of 28.2 ms: four or five in
  // the judged span.
  CHECK(values.at("drawing_rate") == Approx(17.7).epsilon(0.25));
}

TEST_CASE("visualization: a live run draws in the parts that its governor asks for, and replays to its hash") {
  if (const std::string why = cannot_draw(); !why.empty()) {
    WARN("skipped: " << why);
    return;
  }
  std::vector<std::string> live = kDrawnLive;
  SECTION("each drawing in three parts") {
    live.push_back("timing.governor={ split = 3 }");
    const RunOutcome outcome = run_with(tissue_with("render 11.1 ms", live, true), ClockKind::wall, true);
    INFO(outcome.failure << outcome.repeat_difference);
    CHECK(outcome.exit == ExitCode::pass);
    const StrategyRecord& run = strategy(outcome.record, "phase_locked");
    REQUIRE(run.segments.size() > 6);
    for (std::size_t k = 0; k + 1 < run.segments.size(); ++k) CHECK(run.segments[k].finishes == (k % 3 == 2));
  }
  SECTION("a budget that no drawing keeps to") {
    live.push_back("timing.governor={ budget = \"1 us\" }");  // each pause draws at least a thirtieth
    const RunOutcome outcome = run_with(tissue_with("render 11.1 ms", live, true), ClockKind::wall, true);
    INFO(outcome.failure << outcome.repeat_difference);
    CHECK(outcome.exit == ExitCode::pass);
    const StrategyRecord& run = strategy(outcome.record, "phase_locked");
    REQUIRE(run.segments.size() > 6);
    for (std::size_t k = 0; k + 1 < run.segments.size(); ++k) {
      CHECK_FALSE(run.segments[k].finishes);
      CHECK(run.segments[k].left_out == (k > 0));
    }
  }
}

TEST_CASE("visualization: a live run that burns shares that out between the parts, and replays to its hash") {
  if (!built_with_opencl()) return;
  const std::vector<std::string> live{kDrawnLive[0], kDrawnLive[1], "timing.governor={ budget = \"2 ms\" }"};
  const RunOutcome outcome = run_with(tissue_with("burn 4 ms", live), ClockKind::wall, false);
  INFO(outcome.failure << outcome.repeat_difference);
  CHECK(outcome.exit == ExitCode::pass);
  const StrategyRecord& run = strategy(outcome.record, "phase_locked");
  REQUIRE(run.segments.size() > 3);
  for (std::size_t k = 0; k + 1 < run.segments.size(); ++k) CHECK(run.segments[k].finishes == (k % 2 == 1));
}

TEST_CASE("visualization: looking at a solver changes nothing, and the pose with the largest forces is kept") {
  const Scenario scenario = tissue_with("11.1 ms");
  const auto plain = make_scenario_solver(scenario, StrategyKind::phase_locked);
  WatchedSolver watched(make_scenario_solver(scenario, StrategyKind::phase_locked), 2, 3);
  for (int n = 0; n < 20; ++n) {
    const double pushed_m = 1e-4 * (n < 12 ? n : 24 - n);
    const std::array<glm::dvec3, 2> tools{glm::dvec3(0.01 + pushed_m, 0, 0), glm::dvec3(0, 0, 0)};
    CHECK(plain->step(tools).force_N == watched.step(tools).force_N);
    CHECK(std::abs(watched.tools()[0].moved_m.x - pushed_m) < 1e-15);
  }
  CHECK(plain->state_digest() == watched.state_digest());
  REQUIRE(watched.most_forceful());
  CHECK((watched.most_forceful()->step + 1) % 3 == 0);
  CHECK(watched.most_forceful()->step >= 8);
  CHECK(force_N(*watched.most_forceful()) > 0);
  watched.reset();
  CHECK_FALSE(watched.most_forceful());
}
