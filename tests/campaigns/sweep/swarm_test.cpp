// Swarms, states that some point must reach, and the commands that run a point of a swarm again.
#include "src/sweep/swarm.h"

#include <fmt/format.h>

#include <set>

#include "cases.h"
#include "catch.h"
#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/shrink.h"
#include "evenstep/campaigns/sweep.h"
#include "evenstep/harness/run.h"
#include "files.h"
#include "src/sweep/lines.h"

using namespace evenstep;
using Catch::Contains;
using internal::faults_on;
using test::contents;
using testing::TemporaryFolder;

namespace {

const char* const kFaults =
    "[timing]\nspikes = { rate = \"20 Hz\", cost = \"6 ms\" }\ndisturbed = { from = \"0.4 s\", to = \"0.6 s\" }\n"
    "[[device]]\nname = \"left\"\n"
    "motion = { kind = \"constant-velocity\", velocity = [\"0.02 m/s\", \"0 m/s\", \"0 m/s\"] }\n"
    "faults = [{ kind = \"lost\", at = \"0.4 s\", ticks = 30 }, { kind = \"unread\", at = \"0.5 s\", ticks = 20 }]\n";
const char* const kExpect =
    "expect = [{ signal = \"left.force.phase_locked\", metric = \"recovery_time\", max = \"100 ms\" }]\n";

std::string scenario_with(const std::string& sweep) {
  return fmt::format(
      "format = 1\nextends = [\"{}/scenarios/paper/figure-1-spring.toml\"]\nname = \"swarm\"\n{}"
      "[run]\nduration = \"1.2 s\"\nwarmup = \"0.1 s\"\nstrategies = [\"phase_locked\"]\n{}[sweep]\nswarm = true\n{}",
      EVENSTEP_SOURCE_DIR, kExpect, kFaults, sweep);
}

struct Swarm {
  explicit Swarm(const std::string& sweep) : scenario(folder.write("swarm.toml", scenario_with(sweep))) {}
  SweepOutcome run(Shard shard = {}) const {
    SweepOptions options;
    options.shard = shard;
    options.threads = 1;
    options.folder = folder / fmt::format("{}-{}", shard.index, shard.of);
    const SweepOutcome outcome = run_sweep(scenario, options);
    for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
    INFO(outcome.failure);
    REQUIRE(outcome.errors.empty());
    return outcome;
  }
  std::vector<SweepPoint> points(const SweepOutcome& outcome) const {
    std::vector<SweepPoint> found;
    const std::string text = contents(outcome.file);
    for (std::size_t begin = text.find('\n') + 1, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
      found.push_back(internal::read_point_line(outcome.header, text.substr(begin, end - begin)));
    return found;
  }
  TemporaryFolder folder;
  std::string scenario;
};

const char* const kStates =
    "[[sometimes]]\nname = \"a report was lost\"\nsignal = \"left.force.*\"\nmetric = \"lost\"\nmin = 1\n"
    "[[sometimes]]\nname = \"no report was lost\"\nsignal = \"left.force.*\"\nmetric = \"lost\"\nequals = 0\n";
const char* const kPulled =
    "[[sometimes]]\nname = \"the cable was pulled\"\nsignal = \"left.force.*\"\nmetric = \"unplugged\"\nmin = 1\n";

}  // namespace

TEST_CASE("Every fault is on for about half of the seeds, and each pair of them in all four ways") {
  const std::vector<std::string> faults{"timing.hitch", "timing.spikes", "device.left.faults.0", "device.left.faults.1"};
  const std::uint64_t seeds = testing::cases(10'000);
  std::map<std::string, std::int64_t> on;
  std::map<std::pair<std::string, std::string>, std::int64_t> both;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const std::vector<std::string> left = faults_on(faults, seed);
    for (const std::string& a : left) {
      ++on[a];
      for (const std::string& b : left) ++both[{a, b}];
    }
  }
  // Five standard deviations of a binomial count are 2.5 sqrt(seeds) for one fault and 5 sqrt(3 / 16 seeds) for two.
  const double root = std::sqrt(static_cast<double>(seeds));
  for (const std::string& a : faults) {
    CHECK(std::abs(static_cast<double>(on[a]) - 0.5 * static_cast<double>(seeds)) < 2.5 * root);
    for (const std::string& b : faults) {
      if (a != b) CHECK(std::abs(static_cast<double>(both[{a, b}]) - 0.25 * static_cast<double>(seeds)) < 2.17 * root);
    }
  }
}

TEST_CASE("A fault that is added to a scenario changes no draw of the others") {
  for (std::uint64_t seed = 0; seed < testing::cases(1000); ++seed) {
    const std::vector<std::string> few = faults_on({"timing.hitch", "device.left.unplug"}, seed);
    std::vector<std::string> more =
        faults_on({"timing.changes", "timing.hitch", "timing.spikes", "device.left.unplug"}, seed);
    std::erase(more, "timing.changes");
    std::erase(more, "timing.spikes");
    REQUIRE(more == few);
  }
}

TEST_CASE("The lines of a swarm say which faults were on, and the shards of one merge to the bytes of one process") {
  const Swarm swarm("seeds = \"0..12\"\n");
  const SweepOutcome whole = swarm.run();
  CHECK(whole.exit == ExitCode::pass);
  CHECK(whole.header.swarm == std::vector<std::string>{"timing.spikes", "device.left.faults.0", "device.left.faults.1"});
  std::set<std::vector<std::string>> seen;
  for (const SweepPoint& point : swarm.points(whole)) {
    CHECK(point.faults_on == faults_on(whole.header.swarm, whole.header.seed_of(point.index)));
    seen.insert(point.faults_on);
    const bool judged = !point.faults_on.empty();
    REQUIRE(point.expect.size() == 1);
    CHECK(point.expect[0].verdict == (judged ? SweepVerdict::pass : SweepVerdict::skipped));
    CHECK(point.expect[0].value.has_value() == judged);
  }
  CHECK(seen.count(std::vector<std::string>{}) == 1);
  CHECK(seen.size() >= 4);
  const SweepOutcome merged =
      merge_sweep({swarm.run({2, 3}).file, swarm.run({1, 3}).file, swarm.run({3, 3}).file}, swarm.folder / "merged.jsonl");
  REQUIRE(merged.errors.empty());
  CHECK(contents(merged.file) == contents(whole.file));
}

TEST_CASE("The command of a point of a swarm runs the same point again") {
  const Swarm swarm("seeds = \"0..6\"\n");
  const SweepOutcome whole = swarm.run();
  std::size_t with_faults_off = 0;
  for (const SweepPoint& point : swarm.points(whole)) {
    const std::string command = point_command("evenstep", whole.header, point, swarm.scenario);
    ReadOptions options;
    options.seed = whole.header.seed_of(point.index);
    if (const std::size_t set = command.find("--set '"); set != std::string::npos) {
      ++with_faults_off;
      options.set = {command.substr(set + 7, command.size() - set - 8)};
      CHECK_THAT(options.set[0], Catch::StartsWith("run.faults_off=["));
    }
    const ReadResult scenario = read_scenario(swarm.scenario, options);
    for (const Diagnostic& error : scenario.error_or({})) UNSCOPED_INFO(text(error));
    REQUIRE(scenario);
    CHECK(run_scenario(*scenario, {}).record.trace_hash == point.trace_hash);
  }
  CHECK(with_faults_off > 0);
}

TEST_CASE("A point of a swarm whose faults line was changed is refused, even with the right checksum") {
  const Swarm swarm("seeds = \"0..2\"\n");
  const SweepOutcome whole = swarm.run();
  SweepPoint point = swarm.points(whole)[0];
  point.faults_on = whole.header.swarm == point.faults_on ? std::vector<std::string>{} : whole.header.swarm;
  CHECK_THROWS_WITH(internal::read_point_line(whole.header, internal::point_line(whole.header, point)),
                    Contains("has other faults than point 0"));
}

TEST_CASE("A state that some point reached passes, and one that none reached fails the sweep by name") {
  const Swarm reached(std::string("seeds = \"0..6\"\n") + kStates);
  const SweepOutcome good = reached.run();
  CHECK(good.exit == ExitCode::pass);
  CHECK(good.summary.reached.at(0) > 0);
  CHECK(good.summary.reached.at(0) + good.summary.reached.at(1) == 6);
  const Swarm missed(std::string("seeds = \"0..6\"\n") + kStates + kPulled);
  const SweepOutcome bad = missed.run();
  CHECK(bad.exit == ExitCode::expectation_failed);
  const std::string said = sweep_text(bad.header, bad.summary, [](const SweepPoint&) { return ""; });
  CHECK_THAT(said, Contains("0 of 6 points: the cable was pulled"));
  CHECK_THAT(said, Contains("error: no point reached it (left.force.* unplugged)"));
}

TEST_CASE("A shard never fails because of a state, and the merge does") {
  const Swarm swarm(std::string("seeds = \"0..6\"\n") + kStates + kPulled);
  std::vector<std::string> parts;
  for (int i = 1; i <= 3; ++i) {
    const SweepOutcome part = swarm.run({i, 3});
    CHECK(part.exit == ExitCode::pass);
    CHECK_THAT(sweep_text(part.header, part.summary, [](const SweepPoint&) { return ""; }), Contains("not judged"));
    parts.push_back(part.file);
  }
  const SweepOutcome merged = merge_sweep(parts, swarm.folder / "merged.jsonl");
  REQUIRE(merged.errors.empty());
  CHECK(merged.exit == ExitCode::expectation_failed);
  CHECK(contents(merged.file) == contents(swarm.run().file));
}

TEST_CASE("A sweep that stops at its failures does not judge its states") {
  const Swarm swarm(std::string("seeds = \"0..6\"\nstop_after = 1\n[recovery]\nlatency = \"1 ns\"\njump = \"0 %\"\n") +
                    kPulled);
  const SweepOutcome outcome = swarm.run();
  CHECK(outcome.exit == ExitCode::expectation_failed);
  CHECK(outcome.summary.stopped);
  CHECK_FALSE(outcome.summary.complete);
}

TEST_CASE("What a swarm cannot be is an error with its place") {
  const auto errors_of = [](const std::string& text) {
    const TemporaryFolder folder;
    const std::vector<Diagnostic> errors = check_sweep(folder.write("a.toml", text), {});
    return errors.empty() ? std::string() : evenstep::text(errors.front());
  };
  std::string without = scenario_with("");
  without.replace(without.find(kFaults), std::string(kFaults).size(), "");
  without.replace(without.find("recovery_time"), 13, "late");
  without.replace(without.find("\"100 ms\""), 8, "0");
  CHECK_THAT(errors_of(without), Contains("programs no fault"));
  CHECK_THAT(errors_of(scenario_with("[expect_stop]\nreason = \"device\"\n")), Contains("does not go with [expect_stop]"));
  std::string off = scenario_with("");
  off.replace(off.find("[run]\n"), 6, "[run]\nfaults_off = [\"timing.spikes\"]\n");
  CHECK_THAT(errors_of(off), Contains("does not go with [run] faults_off"));
  CHECK_THAT(errors_of(scenario_with("grid = { \"run.faults_off\" = [[]] }\n")),
             Contains("what is switched off is another scenario"));
}

TEST_CASE("A failing point of a swarm is shrunk with its faults off, into a file that reads") {
  const TemporaryFolder folder;
  std::string text = scenario_with("seeds = \"0..4\"\n");
  text.replace(text.find(kExpect), std::string(kExpect).size(),
               "expect = [{ signal = \"left.force.phase_locked\", metric = \"underruns\", equals = 0 }]\n");
  text += "[remap]\nlead = \"1 ms\"\nlatency = \"16 ms\"\n";
  ShrinkOptions options;
  options.set = {"run.faults_off=[\"device.left.faults.0\", \"device.left.faults.1\"]", "sweep.swarm=false"};
  options.folder = folder / "out";
  options.max_runs = 60;
  const ShrinkOutcome outcome = shrink_scenario(folder.write("s.toml", text), options);
  for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(evenstep::text(error));
  INFO(outcome.failure);
  REQUIRE(outcome.exit == ExitCode::pass);
  const ReadResult shrunk = read_scenario(outcome.file, {});
  REQUIRE(shrunk);
  CHECK(shrunk->devices[0].faults.empty());
  CHECK_FALSE(shrunk->has_faults_off);
}

TEST_CASE("A recovery from faults of the timing is not shrunk, because its recording has none") {
  const TemporaryFolder folder;
  std::string text = scenario_with("seeds = \"0..4\"\n");
  text.replace(text.find("\"100 ms\""), 8, "\"0 ms\", expect_fail = true");
  ShrinkOptions options;
  options.set = {"sweep.swarm=false", "recovery.jump=\"1000 %\"", "recovery.latency=\"1 s\""};
  options.folder = folder / "out";
  const ShrinkOutcome outcome = shrink_scenario(folder.write("s.toml", text), options);
  REQUIRE_FALSE(outcome.errors.empty());
  CHECK_THAT(evenstep::text(outcome.errors.front()), Contains("in which no fault is programmed"));
}
