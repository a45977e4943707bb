// What a [timing] table or a recording says: nominal times, step sizes, and the length of a run.
#include "catch.h"
#include "checked.h"
#include "evenstep/format/scenario.h"
#include "evenstep/recordings/timing_csv.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

TEST_CASE("Each form of the timing table gives its exact nominal times") {
  struct {
    const char* timing;
    Rate segment;
    std::int64_t T, V, slot, s;
    Rate steps;
  } const rows[] = {
      {"segment = \"30 Hz\"\nvisualization = \"11.1 ms\"\nsteps = 15\nstep = \"real\"",
       {30, 1},
       33'333'333,
       11'100'000,
       2'222'222,
       1'482'222,
       {450, 1}},
      {"segment = \"32 ms\"\nvisualization = \"8 ms\"\nsteps = 16\nstep = \"1.5 ms\"",
       {125, 4},
       32'000'000,
       8'000'000,
       2'000'000,
       1'500'000,
       {500, 1}},
      {"segment = \"40 ms\"\nvisualization = \"8 ms\"\nsteps = 16\nstep = \"1.5 ms\"",
       {25, 1},
       40'000'000,
       8'000'000,
       2'500'000,
       1'500'000,
       {400, 1}},
      {"visualization = \"8 ms\"\nsteps = 16\nstep = \"1.5 ms\"",
       {125, 4},
       32'000'000,
       8'000'000,
       2'000'000,
       1'500'000,
       {500, 1}},
      {"visualization = \"8 ms\"\nsteps = [1, 2]\nstep = \"1 ms\"",
       {2000, 19},
       9'500'000,
       8'000'000,
       6'333'333,
       1'000'000,
       {3000, 19}},
      {"segment = \"1/3 Hz\"\nvisualization = \"0 s\"\nsteps = [1, 2]",
       {1, 3},
       3'000'000'000,
       0,
       2'000'000'000,
       2'000'000'000,
       {1, 2}},
      {"segment = \"30 Hz\"\nvisualization = \"11.1 ms\"\nsteps = [14, 15]\norder = \"steps-first\"",
       {30, 1},
       33'333'333,
       11'100'000,
       2'298'850,
       1'533'333,
       {435, 1}},
  };
  for (const auto& row : rows) {
    INFO(row.timing);
    const Scenario s = good(with_timing(row.timing));
    CHECK(s.timing.programmed.segment == row.segment);
    CHECK(s.nominal.segment.ns == row.T);
    CHECK(s.nominal.visualization.ns == row.V);
    CHECK(s.nominal.slot.ns == row.slot);
    CHECK(s.nominal.step_run_time.ns == row.s);
    CHECK(s.scene.step_rate == row.steps);
    check_round_trip(s);
  }
  CHECK(good(with_timing(rows[0].timing)).timing.real_steps);
  CHECK(good(with_timing(rows[6].timing)).timing.programmed.order == SegmentOrder::steps_first);
}

TEST_CASE("The widest timing numbers neither overflow nor lose the segment") {
  // With most steps, finest rates and the longest segment, every product stays within 128 bits (sections/timing.cpp).
  const Scenario slow =
      good(with_timing("visualization = \"8 s\"\nsteps = 1000000\nstep = \"1 us\""), {{"run.duration=80 s"}, {}});
  CHECK(slow.nominal.segment.ns == 9'000'000'000);
  CHECK(slow.scene.step_rate == Rate{1'000'000, 9});
  const Scenario odd = good(with_timing("segment = \"8.999999999 s\"\nvisualization = \"1 ns\"\nsteps = 1000000"),
                            {{"run.duration=80 s"}, {}});
  CHECK(odd.timing.programmed.segment == Rate{1'000'000'000, 8'999'999'999});
  const Scenario fast = good(with_timing("segment = \"99999.999999999 Hz\"\nvisualization = \"1 ns\"\nsteps = 9000"),
                             {{"run.duration=5 ms"}, {}});
  CHECK(fast.nominal.step_run_time.ns == 1);
  CHECK(fast.nominal.segment.ns == 10'000);
}

TEST_CASE("A run of more than ten million steps is refused, and says how long it may be") {
  CHECK_THAT(errors_of(read_text(kSpring, {{"run.duration=22222.225 s"}, {}})),
             Contains("'duration': this is 10000002 steps, and a run has at most 10000000; run for 22222220 ms at most"));
  CHECK_THAT(errors_of(read_text(kSpring, {{"scene.step_size=1 ns", "run.duration=1 s"}, {}})),
             Contains("'step_size': 1e+09 steps of this size make up the run, and it has at most 10000000"));
}

TEST_CASE("A step size is taken from a duration or a rate as it is written") {
  const auto rate_of = [](const std::string& size) {
    return good(kSpring, {{"scene.step_size=" + size}, {}}).scene.step_rate;
  };
  CHECK(rate_of("2 ms") == Rate{500, 1});
  CHECK(rate_of("450 Hz") == Rate{450, 1});
  CHECK(rate_of("1000/3 Hz") == Rate{1000, 3});
  CHECK(rate_of("fill") == Rate{450, 1});
}

TEST_CASE("A trace gives the means of the recording as nominal times, and its length as the duration") {
  const TemporaryFolder folder;
  // Two segments of 30 and 34 us, V of 10 and 12 us, one idle time, 2 and 3 steps of 4 us.
  folder.write(
      "recorded/x.csv",
      "segment,kind,index,begin_ns,end_ns\n0,visualization,0,100,10100\n0,step,0,10100,14100\n0,step,1,14200,18200\n"
      "0,idle,0,18200,30100\n1,visualization,0,30100,42100\n1,step,0,42100,46100\n1,step,1,46100,50100\n1,step,2,50100,"
      "54100\n1,idle,0,54100,64100\n");
  std::string text = with_timing("trace = \"../recorded/x.csv\"");
  text.replace(text.find("duration = \"4 s\""), 16, "");
  const ReadResult result = read_scenario(folder.write("sub/s.toml", text));
  INFO(errors_of(result));
  REQUIRE(result);
  const Scenario& s = *result;
  CHECK(s.run_duration.ns == 64'000);
  CHECK(s.nominal.segment.ns == 32'000);
  CHECK(s.nominal.visualization.ns == 11'000);
  CHECK(s.nominal.slot.ns == 12'800);
  CHECK(s.nominal.step_run_time.ns == 4'000);
  CHECK(s.scene.step_rate == Rate{78'125, 1});  // 5 steps in 64 us
  CHECK(s.timing.trace.size() == 2);
  check_round_trip(s);
  CHECK_THAT(errors_of(read_scenario(folder / "sub/s.toml", {{"run.duration=65 us"}, {}})),
             Contains("--set run.duration=65 us: error: 'duration': the trace ends at 0.064 ms"));
}

TEST_CASE("A run of a trace that ends with a step is 1 ns longer than the trace, so that this step ends within it") {
  const TemporaryFolder folder;
  const std::string rows =
      "segment,kind,index,begin_ns,end_ns\n0,visualization,0,0,10000\n0,step,0,10000,14000\n1,step,0,20000,64000\n";
  folder.write("x.csv", rows);
  std::string text = with_timing("trace = \"x.csv\"");
  text.replace(text.find("duration = \"4 s\""), 16, "");
  const std::string path = folder.write("s.toml", text);
  const auto duration_ns = [&](const ReadOptions& options = {}) {
    const ReadResult result = read_scenario(path, options);
    INFO(errors_of(result));
    REQUIRE(result);
    CHECK(result->nominal.slot.ns == 32'000);  // 2 steps in 64 us, as before
    return result->run_duration.ns;
  };
  CHECK(duration_ns() == 64'001);
  CHECK(duration_ns({{"run.duration=64 us"}, {}}) == 64'000);
  folder.write("x.csv", rows + "1,visualization,0,64000,64001\n");
  CHECK(read_scenario(path)->run_duration.ns == 64'001);
  folder.write("x.csv", rows + "1,idle,0,64000,64001\n");
  CHECK(read_scenario(path)->run_duration.ns == 64'001);
}

TEST_CASE("A recording that is repeated goes on from its end, and its length is that of all") {
  const TemporaryFolder folder;
  const std::string csv = folder.write("timing.csv",
                                       "segment,kind,index,begin_ns,end_ns\n0,visualization,0,0,100\n0,step,0,100,300\n"
                                       "1,step,0,400,500\n1,idle,0,500,900\n");
  const auto with = [&](const std::string& rest) {
    std::string text = with_timing("trace = \"" + csv + "\"\n" + rest);
    const std::string duration = "duration = \"4 s\"\n";
    return text.erase(text.find(duration), duration.size());
  };
  const ReadResult read = read_text(with("repeat = 3"));
  INFO(errors_of(read));
  REQUIRE(read);
  CHECK(format_timing_csv(read->timing.trace) ==
        "segment,kind,index,begin_ns,end_ns\n0,visualization,0,0,100\n0,step,0,100,300\n"
        "1,step,0,400,500\n1,idle,0,500,900\n2,visualization,0,900,1000\n2,step,0,1000,1200\n"
        "3,step,0,1300,1400\n3,idle,0,1400,1800\n4,visualization,0,1800,1900\n4,step,0,1900,2100\n"
        "5,step,0,2200,2300\n5,idle,0,2300,2700\n");
  CHECK(read->run_duration.ns == 2700);
  CHECK(read->nominal.segment.ns == 450);
  CHECK(describe(*read_text(with("repeat = 1"))) == describe(*read_text(with(""))));
  CHECK_THAT(errors_of(read_text(with("repeat = 0"))), Contains("'repeat'"));
  CHECK_THAT(errors_of(read_text(with("repeat = 1000001"))), Contains("'repeat'"));
  CHECK_THAT(errors_of(read_text(with_timing("segment = \"30 Hz\"\nvisualization = \"1 ms\"\nsteps = 2\nrepeat = 2"))),
             Contains("'repeat' belongs to a recording"));
}

TEST_CASE("A recording is repeated up to 10 million segments and steps, and up to 1e6 s, and not once more") {
  const TemporaryFolder folder;
  std::string rows = "segment,kind,index,begin_ns,end_ns\n";
  for (int i = 0; i < 9'999; ++i)
    rows += "0,step," + std::to_string(i) + "," + std::to_string(i) + "," + std::to_string(i + 1) + "\n";
  const std::string many = folder.write("many.csv", rows);
  const std::string longest = folder.write("long.csv", "segment,kind,index,begin_ns,end_ns\n0,step,0,0,400000000000000\n");
  const auto with = [&](const std::string& csv, int times) {
    return errors_of(read_text(with_timing("trace = \"" + csv + "\"\nrepeat = " + std::to_string(times))));
  };
  CHECK_THAT(with(many, 1001), Contains("this recording can be played 1000 times at most"));
  CHECK_THAT(with(longest, 3), Contains("this recording can be played 2 times at most"));
  CHECK_THAT(with(longest, 2), !Contains("at most"));
}

TEST_CASE("A trace may be a profiler's file, whose roles are in the scenario or guessed") {
  const TemporaryFolder folder;
  const std::string events =
      folder.write("events.json",
                   R"([{"ph":"X","name":"draw","ts":0,"dur":10,"pid":1},{"ph":"X","name":"step","ts":10,
      "dur":5,"pid":1},{"ph":"X","name":"step","ts":15,"dur":5,"pid":1},
      {"ph":"X","name":"draw","ts":30,"dur":10,"pid":1}])");
  const std::string csv = folder.write("timing.csv", "segment,kind,index,begin_ns,end_ns\n0,step,0,0,10\n");
  const std::string trace = "trace = \"" + events + "\"\n";
  for (const char* const roles : {"", "roles = { visualization = \"dr.w\", step = \"^step$\" }"}) {
    std::string text = with_timing(trace + roles);
    const std::string duration = "duration = \"4 s\"\n";
    text.erase(text.find(duration), duration.size());
    const ReadResult read = read_text(text);
    INFO(errors_of(read));
    REQUIRE(read);
    REQUIRE(read->timing.trace.size() == 1);
    CHECK(read->timing.trace[0].steps.size() == 2);
    CHECK(read->nominal.visualization.ns == 10'000);
  }
  CHECK_THAT(errors_of(read_text(with_timing(trace + "roles = { step = \"stepp\" }"))),
             Contains("no name matches the step 'stepp'; there are 'draw' (2), 'step' (2)"));
  CHECK_THAT(errors_of(read_text(with_timing(trace + "roles = { visualization = \"draw\", steps = 3 }"))),
             Contains("'steps' and 'step_time' go together"));
  CHECK_THAT(errors_of(read_text(with_timing("trace = \"" + csv + "\"\nroles = { step = \"a\" }"))),
             Contains("'roles' are those of a profiler's file"));
  CHECK_THAT(errors_of(read_text(with_timing("segment = \"30 Hz\"\nvisualization = \"1 ms\"\nsteps = 2\nroles = {}"))),
             Contains("'roles' belongs to a recording"));
}
