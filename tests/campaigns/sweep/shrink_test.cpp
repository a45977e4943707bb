// From a failing scenario to the smallest timing that fails.
#include "evenstep/campaigns/shrink.h"

#include <fmt/format.h>

#include <set>

#include "catch.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/underrun_rate.h"
#include "evenstep/recordings/timing_csv.h"
#include "files.h"
#include "src/shrink/search.h"
#include "src/shrink/timing.h"

using namespace evenstep;
using Catch::Contains;
using test::contents;
using testing::TemporaryFolder;

namespace {

constexpr std::int64_t kVisualization = 8'000'000, kStep = 1'500'000;
constexpr std::size_t kSteps = 16, kSegments = 20;

struct Spike {
  std::size_t segment, step;
  std::int64_t ns;
};

/// Segments of 32 ms without a gap. Every third step is off by up to 5 us, and these spikes are added.
std::string recording(const std::vector<Spike>& spikes) {
  std::string csv = "segment,kind,index,begin_ns,end_ns\n";
  std::int64_t now = 0;
  const auto row = [&](std::size_t segment, const char* kind, std::size_t index, std::int64_t length) {
    csv += fmt::format("{},{},{},{},{}\n", segment, kind, index, now, now + length);
    now += length;
  };
  for (std::size_t k = 0; k < kSegments; ++k) {
    row(k, "visualization", 0, kVisualization);
    for (std::size_t i = 0; i < kSteps; ++i) {
      std::int64_t length = kStep;
      if ((k + i) % 3 == 0) length += static_cast<std::int64_t>((k * 7 + i * 13) % 11 * 1000) - 5000;
      for (const Spike& spike : spikes) length += spike.segment == k && spike.step == i ? spike.ns : 0;
      row(k, "step", i, length);
    }
  }
  return csv;
}

/// A force is late if its step ends more than latency - lead = 12 ms after the begin of its slot.
std::string scenario(const TemporaryFolder& folder, const std::vector<Spike>& spikes, const std::string& more = "") {
  folder.write("t.csv", recording(spikes));
  return folder.write(
      "late.toml",
      "format = 1\nname = \"late\"\n[run]\nwarmup = \"2 segments\"\nstrategies = [\"direct\", \"paper\"]\n"
      "[timing]\ntrace = \"t.csv\"\n[scene]\nkind = \"spring\"\n[[device]]\nname = \"left\"\nphase = \"0.01 segment\"\n"
      "render = { kind = \"force\", emission = \"hold\" }\n"
      "motion = { kind = \"constant-velocity\", velocity = [\"0.1 m/s\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.1 s\" }\n"
      "[remap]\nlead = \"2 ms\"\nlatency = \"14 ms\"\n"
      "[[expect]]\nsignal = \"left.force.paper\"\nmetric = \"underruns\"\nequals = 0\n"
      "[[expect]]\nsignal = \"left.interaction.direct\"\nmetric = \"velocity_jump\"\nmax = \"1 step\"\n" +
          more);
}

ShrinkOutcome shrunk(const TemporaryFolder& folder, const std::string& path, ShrinkOptions options = {},
                     const std::string& out = "out") {
  options.folder = folder / out;
  const ShrinkOutcome outcome = shrink_scenario(path, options);
  for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
  INFO(outcome.failure);
  REQUIRE(outcome.exit == ExitCode::pass);
  return outcome;
}

/// The pieces as timing.csv has them, without idle rows. Building a timing from its shape must give the same pieces.
std::string pieces(const std::vector<SegmentTiming>& segments) {
  std::string out;
  const RealTime origin = segments.empty() ? RealTime{} : segments.front().begin;
  for (const SegmentTiming& segment : segments) {
    if (segment.visualization && segment.visualization->begin < segment.visualization->end)
      out += fmt::format("{}: {}-{}\n", segment.index, (segment.visualization->begin - origin).ns,
                         (segment.visualization->end - origin).ns);
    for (const Interval& step : segment.steps)
      out += fmt::format("{} {}-{}\n", segment.index, (step.begin - origin).ns, (step.end - origin).ns);
  }
  return out;
}

std::vector<SegmentTiming> as_run(const Scenario& scenario) {
  std::vector<SegmentTiming> segments;
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  SegmentTiming segment;
  while (timing->next(segment) && segment.begin < RealTime{scenario.run_duration.ns}) segments.push_back(segment);
  return segments;
}

}  // namespace

TEST_CASE(
    "One spike among many small deviations is left alone and shrunk to the nanosecond at which it makes a force late") {
  const TemporaryFolder folder;
  for (const std::size_t step : {0U, 5U, 15U}) {
    const ShrinkOutcome outcome = shrunk(folder, scenario(folder, {{12, step, 11'000'000}}));
    REQUIRE(outcome.perturbations.size() == 1);
    const Perturbation& spike = outcome.perturbations.front();
    CHECK(spike.kind == Perturbation::Kind::step);
    CHECK(spike.segment == 12);
    CHECK(spike.step == step);
    CHECK(spike.nominal == kStep);
    // Step j ends V + s + j (s - slot) after the begin of its slot, which is 9.5 ms - j * 0.5 ms. It is late from
    // 12 ms + 1 ns on.
    CHECK(spike.deviation == 12'000'000 - (9'500'000 - static_cast<std::int64_t>(step) * 500'000) + 1);
    CHECK(outcome.minimal);
    CHECK(outcome.perturbations_before > 90);
    CHECK(outcome.duration < outcome.duration_before);
    CHECK(outcome.duration > Duration{12 * 32'000'000});
    CHECK(outcome.after.value == 1.0);
    CHECK(outcome.after.signal == "left.force.paper");
  }
}

TEST_CASE("Two spikes that are late only together are both kept and together no longer than they must be", "[sweep]") {
  const TemporaryFolder folder;
  const ShrinkOutcome outcome = shrunk(folder, scenario(folder, {{9, 5, 3'200'000}, {9, 7, 3'200'000}, {14, 3, 2'000'000}}));
  REQUIRE(outcome.perturbations.size() == 2);
  CHECK(outcome.perturbations[0].step == 5);
  CHECK(outcome.perturbations[1].step == 7);
  // Step 7 ends 6 ms after its slot's begin.
  CHECK(outcome.perturbations[0].deviation + outcome.perturbations[1].deviation == 6'000'001);
}

TEST_CASE("What is written reads back alone and fails the same expectation, and shrinking it again changes nothing",
          "[sweep]") {
  const TemporaryFolder folder;
  const ShrinkOutcome first = shrunk(folder, scenario(folder, {{12, 5, 6'000'000}}));
  const std::string toml = contents(first.file);
  CHECK_THAT(toml, Contains("# left.force.paper underruns fails with the timing of late.toml"));
  CHECK_THAT(toml, Contains("step 5 of segment 12: 6500001 ns instead of 1500000"));
  CHECK_THAT(toml, !Contains("extends") && !Contains(folder / ""));
  const TemporaryFolder elsewhere;
  elsewhere.write("late-shrunk.csv", contents(folder / "out/late-shrunk.csv"));
  const std::string copy = elsewhere.write("late-shrunk.toml", toml);
  const ReadResult read = read_scenario(copy);
  REQUIRE(read);
  CHECK(read->strategies == std::vector<StrategyKind>{StrategyKind::paper});
  const RunOutcome run = run_scenario(*read, {});
  REQUIRE(run.results.size() == 1);
  CHECK(run.results.front().verdict == ExpectationResult::Verdict::fail);
  const ShrinkOutcome again = shrunk(elsewhere, copy);
  REQUIRE(again.perturbations.size() == 1);
  CHECK(again.perturbations.front().deviation == first.perturbations.front().deviation);
  CHECK(contents(elsewhere / "out/late-shrunk-shrunk.csv") == contents(folder / "out/late-shrunk.csv"));
}

TEST_CASE("The same scenario shrinks to the same files") {
  const TemporaryFolder folder;
  const std::string path = scenario(folder, {{12, 5, 6'000'000}, {13, 2, 6'000'000}});
  const ShrinkOutcome a = shrunk(folder, path, {}, "a"), b = shrunk(folder, path, {}, "b");
  CHECK(a.runs == b.runs);
  for (const char* name : {"/late-shrunk.toml", "/late-shrunk.csv"})
    CHECK(contents(folder / ("a" + std::string(name))) == contents(folder / ("b" + std::string(name))));
}

TEST_CASE("The expectation to shrink for is the first that fails or the one of a line") {
  const TemporaryFolder folder;
  const std::string path = scenario(folder, {{12, 5, 6'000'000}});
  ShrinkOptions options;
  options.expect_line = 22;
  CHECK(shrunk(folder, path, options).before.signal == "left.interaction.direct");
  options.expect_line = 3;
  const ShrinkOutcome outcome = shrink_scenario(path, options);
  CHECK(outcome.exit == ExitCode::usage);
  REQUIRE(outcome.errors.size() == 1);
  CHECK_THAT(text(outcome.errors.front()), Contains("late.toml:3:1: error: --expect: no expectation begins in this line"));
}

TEST_CASE("A scenario that passes is refused and a search that runs out of runs says so") {
  const TemporaryFolder folder;
  ShrinkOptions options;
  options.expect_line = 18;
  const ShrinkOutcome passes = shrink_scenario(scenario(folder, {}), options);
  CHECK(passes.exit == ExitCode::usage);
  REQUIRE(passes.errors.size() == 1);
  CHECK_THAT(passes.errors.front().message, Contains("does not fail, so there is nothing to shrink"));
  options = {};
  options.max_runs = 12;
  const ShrinkOutcome cut = shrunk(folder, scenario(folder, {{12, 5, 6'000'000}}), options);
  CHECK_FALSE(cut.minimal);
  CHECK(cut.runs <= 13);
  CHECK(cut.after.verdict == ExpectationResult::Verdict::fail);
}

TEST_CASE(
    "A real recording is shrunk although its steps per second are a fraction of large numbers, and no copy of it is left",
    "[sweep]") {
  const TemporaryFolder folder;
  for (const char* name : {"paperlike-free-basic", "concurrent-paced30-basic-sub9"}) {
    INFO(name);
    const std::string stem = fmt::format("{}-late", name);
    const std::string path = folder.write(
        stem + ".toml",
        fmt::format("format = 1\n[run]\nwarmup = \"1 s\"\nstrategies = [\"phase_locked\"]\n[timing]\ntrace = "
                    "\"{}/scenarios/recorded/{}.csv\"\n[scene]\nkind = \"spring\"\n[[device]]\nname = \"left\"\n[remap]\n"
                    "lead = \"2 ms\"\nlatency = \"18 ms\"\n[[expect]]\nsignal = \"left.force.phase_locked\"\nmetric = "
                    "\"underruns\"\nequals = 0\n",
                    EVENSTEP_SOURCE_DIR, name));
    ShrinkOptions options;
    options.max_runs = 25;
    const ShrinkOutcome outcome = shrunk(folder, path, options, name);
    CHECK(outcome.after.verdict == ExpectationResult::Verdict::fail);
    std::set<std::string> left;
    for (const auto& entry : std::filesystem::directory_iterator(folder / name))
      left.insert(entry.path().filename().string());
    CHECK(left == std::set<std::string>{stem + "-shrunk.csv", stem + "-shrunk.toml"});
  }
}

TEST_CASE("Where one of many perturbations fails alone, one is left, although halves of them fail together first") {
  // Each of eighteen spikes makes a force late alone. Two short ones in one segment do so only together, and halving finds
  // these first.
  std::vector<Spike> spikes{{3, 5, 3'200'000}, {3, 7, 3'200'000}};
  for (std::size_t k = 4; k < 13; ++k) {
    spikes.push_back({k, 2, 9'000'000});
    spikes.push_back({k, 9, 9'000'000});
  }
  const TemporaryFolder folder;
  const ShrinkOutcome outcome = shrunk(folder, scenario(folder, spikes));
  CHECK(outcome.perturbations.size() == 1);
}

TEST_CASE("A rate of underruns over many seeds shrinks by a seed that underruns and any other is told which one does",
          "[sweep]") {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& name, const std::string& latency, int seeds) {
    std::string text = test::small_scenario("latency = \"" + latency + "\"\n");
    const std::string never = "metric = \"underruns\", equals = 0";
    text.replace(text.find(never), never.size(),
                 fmt::format("metric = \"underrun_rate\", max = \"5 %\", confidence = \"95 %\", seeds = {}", seeds));
    return folder.write(name, text);
  };
  const std::string path = with("rate.toml", "20.2 ms", 20);
  const Scenario scenario = *read_scenario(path);
  const std::vector<StrategyPlan> plans = plan(scenario);
  std::optional<std::uint64_t> clean, hit;
  for (std::uint64_t seed = 1; seed < 100 && !(clean && hit); ++seed) {
    Scenario one = scenario;
    one.timing.programmed.seed = seed;
    const internal::RateSignal force{"", StrategyKind::phase_locked, internal::UnderrunSide::force, 0};
    (internal::count_underrun_segments(one, force, plans[0].lead, plans[0].latency, 1).hit == 0 ? clean : hit) = seed;
  }
  REQUIRE(clean);
  REQUIRE(hit);
  ShrinkOptions options;
  options.seed = *hit;
  const ShrinkOutcome outcome = shrunk(folder, path, options);
  CHECK(outcome.perturbations.size() < 20);
  CHECK_THAT(contents(outcome.file), Contains("underrun_rate") && !Contains("confidence") && !Contains("seeds"));
  options.seed = *clean;
  const ShrinkOutcome refused = shrink_scenario(path, options);
  CHECK(refused.exit == ExitCode::usage);
  REQUIRE(refused.errors.size() == 1);
  const std::string message = text(refused.errors.front());
  CHECK_THAT(message, Contains(fmt::format("over 20 seeds, of which a recording has one, and seed {} alone keeps", *clean)));
  options.seed = std::stoull(message.substr(message.find("add --seed ") + 11));
  shrunk(folder, path, options, "remedy");
  const ShrinkOutcome unsure = shrink_scenario(with("sure.toml", "60 ms", 1), {});
  REQUIRE(unsure.errors.size() == 1);
  CHECK_THAT(unsure.errors.front().message, Contains("too few to be sure"));
}

TEST_CASE("Drawn timings shrink to a few of their lengths") {
  const TemporaryFolder folder;
  const std::string path = folder.write("small.toml", test::small_scenario("latency = \"19 ms\"\n"));
  const ShrinkOutcome outcome = shrunk(folder, path);
  CHECK(outcome.perturbations_before > 100);
  CHECK(outcome.perturbations.size() < 20);
  CHECK(outcome.minimal);
}

TEST_CASE("A timing is what its lengths build again, whatever the timing") {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"/scenarios/timing", "/scenarios/recorded"}) {
    for (const auto& entry : std::filesystem::directory_iterator(EVENSTEP_SOURCE_DIR + std::string(folder)))
      if (entry.path().extension() == ".toml") files.push_back(entry.path());
  }
  CHECK(files.size() > 20);
  for (const std::filesystem::path& file : files) {
    INFO(file);
    const ReadResult read = read_scenario(file.string());
    REQUIRE(read);
    Scenario scenario = *read;
    if (scenario.timing.trace.empty()) scenario.run_duration = std::min(scenario.run_duration, Duration{2'000'000'000});
    const internal::TimingShape shape(scenario);
    std::vector<SegmentTiming> wanted = as_run(scenario);
    const std::vector<SegmentTiming> built = shape.build(shape.perturbations(), shape.segments());
    CHECK(built.size() == wanted.size());
    if (pieces(built) != pieces(wanted)) {
      CHECK(pieces(built).substr(0, 2000) == pieces(wanted).substr(0, 2000));
      FAIL_CHECK("differs");
    }
    // Written and read as a recording, it is the same.
    const TimingCsv csv = parse_timing_csv(format_timing_csv(built), "csv");
    CHECK(csv);
    CHECK(pieces(*csv) == pieces(built));
  }
}

TEST_CASE("The fewest that fail are found for every set of up to two culprits and are minimal for any rule that is not") {
  const auto always = [] { return true; };
  for (std::size_t count = 1; count <= 17; ++count) {
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = a; b < count; ++b) {
        const auto fails = [&](const std::vector<std::size_t>& set) {
          return std::count(set.begin(), set.end(), a) > 0 && std::count(set.begin(), set.end(), b) > 0;
        };
        std::vector<std::size_t> wanted{a};
        if (b != a) wanted.push_back(b);
        CHECK(internal::fewest(count, fails, always) == wanted);
      }
    }
  }
  // A set fails if its sum is large enough, be it of many small numbers or of a few large ones. Whatever set is found, no
  // member of it can be left out.
  const auto weight = [](const std::vector<std::size_t>& set) {
    std::size_t sum = 0;
    for (const std::size_t i : set) sum += i * i % 23;
    return sum;
  };
  for (std::size_t least = 1; least < 300; least += 7) {
    const auto found = internal::fewest(
        40, [&](const auto& set) { return weight(set) >= least; }, always);
    REQUIRE(weight(found) >= least);
    for (std::size_t i = 0; i < found.size(); ++i) {
      std::vector<std::size_t> less = found;
      less.erase(less.begin() + static_cast<std::ptrdiff_t>(i));
      CHECK(weight(less) < least);
    }
  }
  CHECK(internal::fewest(
            9, [](const auto&) { return true; }, always)
            .empty());
  CHECK(internal::fewest(
            0, [](const auto&) { return true; }, always)
            .empty());
}

TEST_CASE("what fails because a loop dropped simulated time is shrunk to one place where it drops, and replays so") {
  const TemporaryFolder folder;
  // A picture of 150 ms every two seconds, and at most 3 steps of 20 ms in a frame: five steps are dropped each time.
  const std::string path = folder.write(
      "drops.toml",
      "format = 1\nname = \"drops\"\n[run]\nduration = \"7 s\"\nwarmup = \"1 s\"\nstrategies = [\"clocked\"]\n"
      "[timing]\nloop = \"accumulator\"\nsegment = \"60 Hz\"\nvisualization = \"4 ms\"\nstep = \"0.4 ms\"\nmax_steps = 3\n"
      "hitch = { every = \"2 s\", visualization = \"150 ms\" }\n[scene]\nkind = \"spring\"\nstep_size = \"50 Hz\"\n"
      "[[device]]\nname = \"left\"\nrender = { kind = \"force\", emission = \"hold\" }\n"
      "motion = { kind = \"constant-velocity\", velocity = [\"0.1 m/s\", \"0 m/s\", \"0 m/s\"], start = \"smooth 0.1 s\" }\n"
      "[remap]\ndropped = \"jump\"\n"
      "[[expect]]\nsignal = \"left.interaction.clocked\"\nmetric = \"velocity_jump\"\nmax = \"1.5 step\"\n");
  const ShrinkOutcome outcome = shrunk(folder, path);
  REQUIRE(outcome.perturbations.size() == 1);
  const Perturbation& drop = outcome.perturbations.front();
  CHECK(drop.kind == Perturbation::Kind::dropped);
  CHECK(drop.nominal == 0);
  CHECK(drop.deviation == 2);  // one step dropped jumps by a step, two by two
  CHECK_THAT(text(drop), Contains("simulated time dropped before step 0 of segment") && Contains(": 2 steps"));
  CHECK_THAT(contents(folder / "out/drops-shrunk.csv"), Contains("simulated_ns"));
}

TEST_CASE("Bisection ends at the least number that fails in both directions") {
  const auto always = [] { return true; };
  for (std::int64_t least = 1; least <= 40; ++least) {
    for (std::int64_t from = least; from <= 40; ++from) {
      CHECK(internal::smallest(
                0, from, [&](std::int64_t v) { return v >= least; }, always) == least);
      CHECK(internal::smallest(
                0, -from, [&](std::int64_t v) { return v <= -least; }, always) == -least);
    }
  }
}
