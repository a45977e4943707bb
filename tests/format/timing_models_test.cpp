// How run times vary: what a file says is read, nominal times are means, and what makes no sense is refused.
#include <fmt/format.h>

#include "catch.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

const char* const kBase = "segment = \"30 Hz\"\nvisualization = \"11.1 ms\"\nsteps = 15\n";

/// kSpring with this [timing].
std::string spring_with(const std::string& timing) {
  std::string text = kSpring;
  const std::size_t from = text.find("segment = "), to = text.find("[scene]");
  return text.replace(from, to - from, timing + "\n");
}

Scenario read_back(const std::string& timing) {
  const ReadResult result = read_text(spring_with(timing));
  INFO(timing << "\n" << errors_of(result));
  REQUIRE(result);
  const TemporaryFolder folder;
  const ReadResult again = read_scenario(folder.write("resolved.toml", result->resolved_toml));
  INFO(result->resolved_toml << errors_of(again));
  REQUIRE(again);
  CHECK(describe(*again) == describe(*result));
  return *result;
}

ProgrammedTiming timing_of(const std::string& more) { return read_back(kBase + more).timing.programmed; }

struct TimingMistake {
  std::string timing;
  const char* error;  ///< with its place; [timing] is line 8 and its first key line 9
};
void check_timings(const std::vector<TimingMistake>& mistakes) {
  for (const auto& [timing, error] : mistakes) {
    INFO(timing);
    const ReadResult result = read_text(spring_with(timing));
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(error));
  }
}

}  // namespace

TEST_CASE("Each model of [timing] arrives as it is written, and comes back from the resolved file") {
  CHECK(timing_of("first_step = \"+20 %\"").first_step == 0.2);
  CHECK(timing_of("first_step = \"8.5%\"").first_step == 0.085);
  CHECK(timing_of("drift = \"10 %/s\"").drift_per_s == 0.1);
  CHECK(timing_of("drift = \"-2.5 %/s\"").drift_per_s == -0.025);
  const ProgrammedTiming lost = timing_of("dropped_visualization = \"2 %\"\nmerged_visualization = \"98 %\"");
  CHECK(lost.dropped_visualization == 0.02);
  CHECK(lost.merged_visualization == 0.98);
  const ProgrammedTiming spiked = timing_of("spikes = { rate = \"2 Hz\", cost = \"4 ms\" }");
  REQUIRE(spiked.spikes);
  CHECK(spiked.spikes->rate_Hz == 2);
  CHECK(spiked.spikes->cost.ns == 4'000'000);
  const ProgrammedTiming hit = timing_of("preemption = { rate = \"1/2 Hz\", cost = \"pareto 3 ms cap 40 ms\" }");
  REQUIRE(hit.preemption);
  CHECK(hit.preemption->rate_Hz == 0.5);
  CHECK(hit.preemption->least.ns == 3'000'000);
  CHECK(hit.preemption->most.ns == 40'000'000);
  CHECK(hit.preemption->tail == 1.5);
  CHECK(timing_of("preemption = { rate = \"2 Hz\", cost = \"pareto 3ms cap 3ms\", tail = 2 }").preemption->tail == 2);
  const ProgrammedTiming regimes = timing_of("regimes = { factor = 1.6, mean_length = \"8.5 segments\" }");
  REQUIRE(regimes.regimes);
  CHECK(regimes.regimes->factor == 1.6);
  CHECK(regimes.regimes->mean_length == 8.5);
  CHECK(regimes.regimes->slow_share == 0.5);
  CHECK(timing_of("regimes = { factor = 1.6, mean_length = \"8 segments\", slow_share = \"30 %\" }").regimes->slow_share ==
        0.3);
  const ProgrammedTiming hitching = timing_of("hitch = { every = \"2 s\", visualization = \"20 ms\" }");
  REQUIRE(hitching.hitch);
  CHECK(hitching.hitch->every.ns == 2'000'000'000);
  CHECK(hitching.hitch->visualization.ns == 20'000'000);
  const ProgrammedTiming uniform = timing_of("jitter = { visualization = \"uniform 10 %\", step = \"lognormal 5 %\" }");
  CHECK(uniform.visualization_law == JitterLaw::uniform);
  CHECK(uniform.visualization_variation == 0.1);
  CHECK(uniform.step_law == JitterLaw::log_normal);
  CHECK(uniform.step_variation == 0.05);
  const ProgrammedTiming changed = timing_of(
      "changes = [{ at = \"2 s\", visualization = \"22.2 ms\" }, { at = \"3 s\", step = \"1 ms\", steps = [3, 4] }]");
  REQUIRE(changed.changes.size() == 2);
  CHECK(changed.changes[0].at.ns == 2'000'000'000);
  CHECK(changed.changes[0].visualization->ns == 22'200'000);
  CHECK_FALSE(changed.changes[0].step);
  CHECK(changed.changes[0].steps.empty());
  CHECK_FALSE(changed.changes[1].visualization);
  CHECK(changed.changes[1].step->ns == 1'000'000);
  CHECK(changed.changes[1].steps == std::vector<int>{3, 4});
  CHECK(timing_of("paced = true").paced);
  CHECK_FALSE(timing_of("").paced);
}

TEST_CASE("A scenario without models is periodic, each model alone makes it vary") {
  CHECK(is_periodic(timing_of("")));
  CHECK(is_periodic(timing_of("paced = true\nfirst_step = \"0 %\"\ndrift = \"0 %/s\"\nchanges = []")));
  for (const char* model :
       {"first_step = \"1 %\"", "drift = \"1 %/s\"", "dropped_visualization = \"1 %\"", "merged_visualization = \"1 %\"",
        "spikes = { rate = \"1 Hz\", cost = \"1 us\" }", "regimes = { factor = 2, mean_length = \"8 segments\" }",
        "preemption = { rate = \"1 Hz\", cost = \"pareto 1 us cap 2 us\" }", "changes = [{ at = \"0 s\", steps = 15 }]",
        "hitch = { every = \"2 s\", visualization = \"20 ms\" }", "jitter = { step = \"uniform 1 %\" }",
        "jitter = { step = \"lognormal 1 %\" }", "jitter = { visualization = \"lognormal 1 %\" }"}) {
    INFO(model);
    CHECK_FALSE(is_periodic(timing_of(model)));
  }
}

TEST_CASE("Nominal segment and slot are means with what the models add, V and s stay as written") {
  const auto nominal = [](const std::string& timing) { return read_back(timing).nominal; };
  // T grows by 20 % of 1.482222 ms; the slot is T / 15.
  const NominalUnits first = nominal(std::string(kBase) + "first_step = \"20 %\"");
  CHECK(first.segment.ns == 33'333'333 + 296'444);
  CHECK(first.slot.ns == (1'000'000'000'000 / 30 + 296'444'000) / 15 / 1000);
  CHECK(first.visualization.ns == 11'100'000);
  CHECK(first.step_run_time.ns == 1'482'222);
  // T grows by 2 % of V.
  CHECK(nominal(std::string(kBase) + "merged_visualization = \"2 %\"").segment.ns == 33'333'333 + 222'000);
  CHECK(nominal(std::string(kBase) + "dropped_visualization = \"2 %\"").segment.ns == 33'333'333 - 222'000);
  // Each of the 15 steps takes 4 ms (1 - exp(-2 Hz * 1.482222 ms)) = 11.8402 us more.
  CHECK(nominal(std::string(kBase) + "spikes = { rate = \"2 Hz\", cost = \"4 ms\" }").segment.ns == 33'333'333 + 177'603);
  // A hitch of 20 ms every 2 s: T = 33.33 ms / (1 - 8.9 ms / 2 s).
  CHECK(nominal(std::string(kBase) + "hitch = { every = \"2 s\", visualization = \"20 ms\" }").segment.ns ==
        33'333'333 + 148'996);
  // Regimes, drift and changes leave the mean at the start as it is.
  for (const char* model : {"regimes = { factor = 2, mean_length = \"8 segments\" }", "drift = \"5 %/s\"",
                            "changes = [{ at = \"1 s\", visualization = \"20 ms\" }]"}) {
    CHECK(nominal(std::string(kBase) + model).segment.ns == 33'333'333);
    CHECK(read_back(std::string(kBase) + model).scene.step_rate == Rate{450, 1});
  }
  // Where segments wait for a grid, the grid is the mean.
  const std::string paced = "step = \"1 ms\"\npaced = true\nfirst_step = \"20 %\"\njitter = { step = \"lognormal 10 %\" }";
  CHECK(nominal(kBase + paced).segment.ns == 33'333'333);
  CHECK(read_back(kBase + paced).scene.step_rate == Rate{450, 1});
}

TEST_CASE("A concurrent visualization takes its steps from `steps` or from `step`, its segments from V or from the grid") {
  const Scenario asked = read_back("order = \"concurrent\"\nvisualization = \"11.1 ms\"\nsteps = 15");
  CHECK(asked.timing.programmed.order == SegmentOrder::concurrent);
  CHECK(asked.nominal.segment.ns == 11'100'000);
  CHECK(asked.nominal.slot.ns == 740'000);
  CHECK(asked.scene.step_rate == Rate{50'000, 37});  // 15 / 11.1 ms
  const Scenario given = read_back("order = \"concurrent\"\nvisualization = \"11.1 ms\"\nstep = \"2 ms\"");
  CHECK(given.nominal.segment.ns == 11'100'000);
  CHECK(given.nominal.slot.ns == 2'000'000);
  CHECK(given.scene.step_rate == Rate{500, 1});
  const Scenario paced = read_back(std::string(kBase) + "order = \"concurrent\"\npaced = true\nslowdown = 1.5");
  CHECK(paced.nominal.segment.ns == 33'333'333);
  CHECK(paced.scene.step_rate == Rate{450, 1});
  CHECK(paced.timing.programmed.slowdown == 1.5);
  // In each segment steps take 2 ms for 22.233 ms and 4 ms for 11.1 ms, so a slot is 33.333 ms / (11.117 + 2.775).
  const Scenario slowed = read_back(
      "order = \"concurrent\"\nsegment = \"30 Hz\"\npaced = true\nvisualization = \"11.1 ms\"\nstep = \"2 ms\"\n"
      "slowdown = 2");
  CHECK(slowed.nominal.slot.ns == Approx(33.333333e6 / (22.233333 / 2 + 11.1 / 4)).margin(1));
}

TEST_CASE("Models that make no sense where they stand are refused with place and remedy") {
  const std::string base = kBase, fixed = base + "step = \"1 ms\"\n";
  const std::string lane = "order = \"concurrent\"\nvisualization = \"11.1 ms\"\n";
  check_timings({
      {base + "first_step = 20", "scenario.toml:12:14: error: 'first_step': 20 has no unit; write a ratio such as \"20 %\""},
      {base + "first_step = \"-20 %\"", "'first_step': \"-20 %\" is out of range; it must be at least 0"},
      {base + "drift = \"10 %\"", "scenario.toml:12:9: error: 'drift': '%' is a unit of ratio, not of ratio per time"},
      {base + "drift = \"-25 %/s\"",
       "scenario.toml:12:9: error: 'drift': -25 %/s leaves no run time after 4 s of 4 s; write a slower drift"},
      {base + "hitch = { every = \"2 s\", visualization = \"2 s\" }", "leaves no time for anything else"},
      {base + "hitch = { every = \"2 s\" }", "timing.hitch has no 'visualization'; write visualization = \"20 ms\""},
      {base + "hitch = { every = \"0 s\", visualization = \"20 ms\" }", "out of range"},
      {base + "jitter = { step = \"uniform 101 %\" }", "\"uniform 101 %\" is out of range"},
      {base + "jitter = { step = \"uniform 5 ms\" }", "'step'"},
      {base + "jitter = { step = \"gauss 5 %\" }", "must be \"lognormal <ratio>\" or \"uniform <ratio>\""},
      {base + "spikes = { rate = \"2 Hz\" }", "timing.spikes has no 'cost'; write cost = \"4 ms\""},
      {base + "spikes = { rate = \"0 Hz\", cost = \"4 ms\" }", "'rate': '0 Hz' is not above 0 Hz"},
      {base + "preemption = { rate = \"2 Hz\", cost = \"4 ms\" }",
       "scenario.toml:12:38: error: 'cost': \"4 ms\" must be \"pareto <time> cap <time>\", such as \"pareto 3 ms cap 40 "
       "ms\""},
      {base + "preemption = { rate = \"2 Hz\", cost = \"pareto 3 ms\" }", "must be \"pareto <time> cap <time>\""},
      {base + "preemption = { rate = \"2 Hz\", cost = \"pareto 3 ms cap 2 ms\" }", "the cap is below the least cost"},
      {base + "preemption = { rate = \"2 Hz\", cost = \"pareto 0 ms cap 2 ms\" }", "is out of range"},
      {base + "preemption = { rate = \"2 Hz\", cost = \"pareto 3 ms cap 10 s\" }", "is out of range"},
      {base + "preemption = { rate = \"2 Hz\", cost = \"pareto 3 msec cap 4 ms\" }", "did you mean 'ms'?"},
      {base + "preemption = { rate = \"2 Hz\", cost = \"pareto 3 ms cap 4 Hz\" }", "'Hz' is a unit of rate, not of time"},
      {base + "preemption = { rate = \"2 Hz\", cost = \"pareto 3 ms cap 4 ms\", tail = 0 }", "'tail': 0 is out of range"},
      {base + "regimes = { factor = 0.5, mean_length = \"8 segments\" }", "'factor': 0.5 is out of range"},
      {base + "regimes = { factor = 2, mean_length = \"8 segments\", slow_share = \"0 %\" }",
       "'slow_share': \"0 %\" is out of"},
      {base + "regimes = { factor = 2, mean_length = \"8 segments\", slow_share = \"5 %\" }",
       "'slow_share': of 2 mean_length, 16 segments, 0.8 would be at the level that is rarer"},
      {base + "regimes = { factor = 2, mean_length = 8 }", "'mean_length': 8 has no unit; write \"8 segments\""},
      {base + "regimes = { factor = 2, mean_length = \"8 ms\" }", "'8 ms' must be a number of segments, such as"},
      {base + "regimes = { factor = 2, mean_length = \"0.5 segments\" }", "'mean_length': \"0.5 segments\" is out of range"},
      {base + "dropped_visualization = \"60 %\"\nmerged_visualization = \"41 %\"",
       "scenario.toml:13:24: error: 'merged_visualization': 41 % and 60 % dropped are more than all segments"},
      {base + "dropped_visualization = \"101 %\"", "'dropped_visualization': \"101 %\" is out of range"},
      {"segment = \"30 Hz\"\nvisualization = \"0 s\"\nsteps = 15\nregimes = { factor = 2, mean_length = \"8 segments\" }",
       "scenario.toml:12:11: error: 'regimes' means nothing with visualization = \"0 s\"; remove it"},
      {"segment = \"30 Hz\"\nvisualization = \"0 s\"\nsteps = 15\nfirst_step = \"1 %\"", "'first_step' means nothing with"},
      {base + "changes = { at = \"2 s\", steps = 3 }",
       "'changes' must be a list, each a table, such as [{ at = \"2 s\", visualization = \"22.2 ms\" }]"},
      {base + "changes = [{ at = \"2 s\" }]", "scenario.toml:12:19: error: 'changes': this entry changes nothing; write"},
      {base + "changes = [{ steps = 3 }]", "timing.changes has no 'at'; write at = \"2 s\""},
      {base + "changes = [{ at = \"2 segments\", steps = 3 }]", "'segments' is not known here"},
      {base + "changes = [{ at = \"2 s\", steps = 3 }, { at = \"2 s\", steps = 4 }]",
       "scenario.toml:12:46: error: 'at': 2000 ms is not after the change before it, at 2000 ms; sort the entries"},
      {fixed + "first_step = \"1 %\"",
       "scenario.toml:9:11: error: 'segment': where run times vary, segments of a given 'step' follow each other without a "
       "gap; write paced = true to keep them to this grid, or leave 'segment' out"},
      {"visualization = \"8 ms\"\nsteps = 16\nstep = \"1.5 ms\"\npaced = true",
       "scenario.toml:8:1: error: [timing] has no 'segment', which paced = true needs; write segment = \"30 Hz\""},
      {base + "paced = true\nfirst_step = \"20 %\"",
       "scenario.toml:12:9: error: 'paced': the mean work of a segment, 33.6298 ms, is longer than the segment of 33.3333 "
       "ms"},
      {fixed + "paced = true\nchanges = [{ at = \"1 s\", visualization = \"18 ms\" }, { at = \"2 s\", steps = 16 }]",
       "scenario.toml:14:60: error: 'changes': the mean work of a segment, 34 ms, is longer than the segment"},
      {base + "slowdown = 2",
       "scenario.toml:12:1: error: 'slowdown' means nothing with order = \"visualization-first\"; remove it, or write order "
       "= \"concurrent\""},
      {lane + "steps = 15\nfirst_step = \"20 %\"",
       "'first_step' means nothing with order = \"concurrent\"; remove it, or write order = \"visualization-first\" or"},
      {lane + "steps = [14, 15]", "'steps': must be a whole number, not a list"},
      {lane + "steps = 15\nstep = \"1 ms\"", "scenario.toml:11:9: error: order = \"concurrent\" needs either 'steps'"},
      {lane, "needs either 'steps', the mean number per segment, or 'step', a run time"},
      {lane + "steps = 15\nsegment = \"30 Hz\"",
       "scenario.toml:12:11: error: 'segment': with order = \"concurrent\" visualizations follow each other without a gap"},
      {lane + "steps = 15\npaced = true", "has no 'segment', which paced = true needs"},
      {lane + "steps = 15\npaced = true\nsegment = \"100 Hz\"", "the mean work of a segment, 11.1 ms, is longer than the"},
      {lane + "steps = 15\ndropped_visualization = \"1 %\"", "a segment without one has no length; write paced = true"},
      {lane + "step = \"real\"", "'step': \"real\" must be \"fill\" or a time"},
      {lane + "steps = 15\nslowdown = 0.5", "'slowdown': 0.5 is out of range; it must be at least 1"},
      {lane + "steps = 15\nchanges = [{ at = \"1 s\", steps = 3 }]", "'steps' cannot change with order = \"concurrent\""},
      {lane + "steps = 15\nchanges = [{ at = \"1 s\", visualization = \"0 s\" }]", "needs one; write a longer time"},
      {"order = \"concurrent\"\nvisualization = \"99999 s\"\nstep = \"1 ms\"",
       "more than 1000000 steps of 1 ms come beside it, or become due; write a shorter time"},
      {lane + "step = \"1 us\"\nchanges = [{ at = \"1 s\", visualization = \"2 s\" }]",
       "more than 1000000 steps of 0.001 ms"},
      {lane + "step = \"1 ms\"\nchanges = [{ at = \"1 s\", step = \"0.01 us\" }]", "more than 1000000 steps of 1e-05 ms"},
      {lane + "step = \"1 ms\"\nhitch = { every = \"1 s\", visualization = \"1001 s\" }", "more than 1000000 steps of 1 ms"},
      {"order = \"concurrent\"\nvisualization = \"0 s\"\nsteps = 15", "'visualization': order = \"concurrent\" needs one"},
      {"trace = \"x.csv\"\nspikes = { rate = \"2 Hz\", cost = \"4 ms\" }", "'spikes' does not go with 'trace'"},
      {base + "order = \"sideways\"", "'order': \"sideways\" must be \"visualization-first\", \"steps-first\" or"},
  });
}

TEST_CASE("A paced schedule whose steps fill the segment is accepted: its mean work is the segment, to the nanosecond") {
  for (const int steps : {1, 12, 15, 700}) {
    read_back(
        fmt::format("segment = \"30 Hz\"\nvisualization = \"11.1 ms\"\nsteps = {}\npaced = true\n"
                    "jitter = {{ step = \"lognormal 10 %\" }}",
                    steps));
  }
}

namespace {

const char* const kGame = "loop = \"accumulator\"\nsegment = \"60 Hz\"\nvisualization = \"4 ms\"\nstep = \"0.5 ms\"\n";

/// kSpring with this [timing] and steps of 90 Hz.
std::string game_with(const std::string& timing) {
  std::string text = spring_with(timing);
  return text.insert(text.find("[scene]") + 8, "step_size = \"90 Hz\"\n");
}

}  // namespace

TEST_CASE("A game's loop arrives as it is written: steps first, its step size is the scene's, and a slot is one") {
  const ReadResult plain = read_text(game_with(kGame));
  REQUIRE(plain);
  REQUIRE(plain->timing.programmed.accumulator);
  CHECK(plain->timing.programmed.order == SegmentOrder::steps_first);
  CHECK(plain->timing.programmed.paced);
  CHECK(plain->timing.programmed.accumulator->step_rate == Rate{90, 1});
  CHECK_FALSE(plain->timing.programmed.accumulator->max_steps);
  CHECK(plain->scene.step_rate == Rate{90, 1});
  CHECK(plain->nominal.slot == Duration{11'111'111});
  CHECK(plain->nominal.segment == Duration{16'666'666});
  const ReadResult all = read_text(
      game_with(std::string(kGame) +
                "max_steps = 8\njitter_fix = 0.5\nrefresh_jitter = \"0.1 ms\"\norder = \"visualization-first\"\n"));
  REQUIRE(all);
  CHECK(all->timing.programmed.accumulator->max_steps == 8);
  CHECK(all->timing.programmed.accumulator->jitter_fix == Duration{5'555'555});
  CHECK(all->timing.programmed.accumulator->refresh_jitter == Duration{100'000});
  CHECK(all->timing.programmed.order == SegmentOrder::visualization_first);
  const ReadResult free = read_text(game_with("loop = \"accumulator\"\nvisualization = \"4 ms\"\nstep = \"0.5 ms\"\n"));
  REQUIRE(free);
  CHECK_FALSE(free->timing.programmed.paced);
  CHECK(free->nominal.segment == Duration{4'188'482});  // 4 / (1 - 0.5 * 0.09)
}

TEST_CASE("A game's loop that cannot work, or a key that it does not have, is an error that says what to write") {
  const auto check_game = [](const std::string& timing, const char* error) {
    INFO(timing);
    const ReadResult result = read_text(game_with(timing));
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(error));
  };
  const std::string free = "loop = \"accumulator\"\nvisualization = \"4 ms\"\nstep = \"0.5 ms\"\n";
  check_game(kGame + std::string("steps = 2\n"), "'steps' means nothing with loop = \"accumulator\"; remove it");
  check_game(kGame + std::string("paced = true\n"), "'paced' means nothing with loop = \"accumulator\"; remove it");
  check_game(std::string(kBase) + "max_steps = 2\n", "'max_steps' is about a game's loop; remove it, or write loop = ");
  check_game("loop = \"accumulator\"\nvisualization = \"4 ms\"\n", "[timing] has no 'step'; write step = \"1 ms\"");
  check_game("loop = \"game\"\nvisualization = \"4 ms\"\n", "must be \"segments\" or \"accumulator\"");
  check_game(kGame + std::string("jitter_fix = 1.5\n"), "at most 1");
  check_game(kGame + std::string("max_steps = 0\n"), "at least 1");
  check_game(free + "refresh_jitter = \"1 ms\"\n", "'refresh_jitter' delays the frames that wait for a 'segment'");
  check_game(kGame + std::string("refresh_jitter = \"17 ms\"\n"), "write segment = \"60 Hz\", or a shorter time");
  check_game(free + "dropped_visualization = \"1 %\"\n", "'dropped_visualization': a frame without a visualization");
  check_game("loop = \"accumulator\"\nvisualization = \"0 ms\"\nstep = \"0.5 ms\"\n", "takes no time if no step is due");
  check_game(free + "changes = [{ at = \"1 s\", visualization = \"0 s\" }]\n", "takes no time if no step is due");
  check_game(free + "changes = [{ at = \"1 s\", visualization = \"99999 s\" }]\n", "more than 1000000 steps of ");
  check_game(free + "changes = [{ at = \"1 s\", steps = 3 }]\n", "'steps' cannot change with loop = \"accumulator\"");
  check_game("loop = \"accumulator\"\nvisualization = \"4 ms\"\nstep = \"12 ms\"\n", "so each frame has more steps than");
  check_game(free + "changes = [{ at = \"1 s\", step = \"12 ms\" }]\n", "so each frame has more steps than");
  check_game(
      kGame + std::string("governor = { steps = \"spread\" }\n"),
      "so they come in a burst whenever the frame comes, and how many they are depends on when that is; remove it. A loop "
      "that begins each step when it is due has no accumulator: instead of 'loop' write e.g. segment = \"30 Hz\", "
      "steps = 3, governor = { steps = \"spread\" }");
  CHECK(
      read_text(spring_with("segment = \"30 Hz\"\nvisualization = \"4 ms\"\nstep = \"0.5 ms\"\n"
                            "steps = 3\ngovernor = { steps = \"spread\" }\n")));
  CHECK_THAT(errors_of(read_text(spring_with(kGame))), Contains("[scene] has no 'step_size', which loop = \"accumulator\""));
}
