// A sweep gives the same bytes in one process, on threads, in shards, and when it goes on after a cut. And what merge
// refuses.
#include "evenstep/campaigns/sweep.h"
#include "evenstep/apps/shell.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "catch.h"
#include "evenstep/scheduler/parallel_for.h"
#include "files.h"
#include "src/sweep/lines.h"

using namespace evenstep;
using Catch::Contains;
using test::contents;
using testing::TemporaryFolder;

namespace {

const char* const kPlain = "[sweep]\nseeds = \"3..8\"\ngrid = { \"remap.latency\" = [\"13 ms\", \"17 ms\", \"30 ms\"] }\n";
const char* const kStopping =
    "[sweep]\nseeds = \"3..8\"\nstop_after = 4\ngrid = { \"remap.latency\" = [\"30 ms\", \"15 ms\", \"13 ms\"] }\n";

struct Small {
  explicit Small(const std::string& sweep) : scenario(folder.write("small.toml", test::small_scenario(sweep))) {}

  SweepOutcome run(const std::string& out, Shard shard = {}, int threads = 1, bool resume = false) const {
    SweepOptions options;
    options.shard = shard;
    options.threads = threads;
    options.resume = resume;
    options.folder = folder / out;
    const SweepOutcome outcome = run_sweep(scenario, options);
    INFO(outcome.failure);
    REQUIRE(outcome.errors.empty());
    return outcome;
  }
  /// The files of this many shards.
  std::vector<std::string> shards(int of) const {
    std::vector<std::string> parts;
    for (int i = 1; i <= of; ++i) parts.push_back(run(fmt::format("of-{}", of), {i, of}).file);
    return parts;
  }

  TemporaryFolder folder;
  std::string scenario;
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
    lines.push_back(text.substr(begin, end + 1 - begin));
  return lines;
}

std::vector<SweepPoint> points_of(const SweepOutcome& outcome) {
  std::vector<SweepPoint> points;
  const std::vector<std::string> lines = lines_of(contents(outcome.file));
  for (std::size_t i = 1; i < lines.size(); ++i)
    points.push_back(internal::read_point_line(outcome.header, lines[i].substr(0, lines[i].size() - 1)));
  return points;
}

/// Lines that were changed, with their checksums computed again.
std::string resummed(const std::string& text) {
  std::string out;
  for (std::string line : lines_of(text)) {
    line.resize(line.rfind(",\"check\":"));
    out += internal::with_checksum(line + "}") + "\n";
  }
  return out;
}

std::string only_error(const SweepOutcome& outcome) {
  REQUIRE(outcome.errors.size() == 1);
  CHECK(outcome.exit == ExitCode::usage);
  return text(outcome.errors.front());
}

}  // namespace

TEST_CASE("Threads give the bytes of one thread and shards in any order merge to them") {
  const std::string sweep = GENERATE(std::string(kPlain), std::string(kStopping));
  const Small small(sweep);
  const SweepOutcome whole = small.run("one");
  const std::string bytes = contents(whole.file);
  CHECK(whole.summary.all.failed > 0);
  CHECK(whole.summary.all.passed > 0);
  CHECK(whole.exit == ExitCode::expectation_failed);
  for (const int threads : {2, 4}) CHECK(contents(small.run(fmt::format("threads-{}", threads), {}, threads).file) == bytes);
  for (int of = 2; of <= 5; ++of) {
    std::vector<std::string> parts = small.shards(of);
    for (int turn = 0; turn < of; ++turn) {
      std::rotate(parts.begin(), parts.begin() + 1, parts.end());
      if (turn % 2 == 1) std::reverse(parts.begin(), parts.end());
      const SweepOutcome merged = merge_sweep(parts, small.folder / "merged.jsonl");
      REQUIRE(merged.errors.empty());
      CHECK(contents(merged.file) == bytes);
      CHECK(merged.exit == whole.exit);
      CHECK(sweep_json(merged.header, merged.summary, [](const SweepPoint&) { return "x"; }) ==
            sweep_json(whole.header, whole.summary, [](const SweepPoint&) { return "x"; }));
    }
  }
}

TEST_CASE("A sweep that stops after K failures ends with the K-th by number") {
  const Small small(kStopping);
  const SweepOutcome whole = small.run("one", {}, 4);
  CHECK(whole.summary.stopped);
  CHECK(whole.summary.all.failed == 4);
  CHECK(points_of(whole).back().verdict == SweepVerdict::fail);
  CHECK(whole.summary.all.runs() < whole.header.points());
}

TEST_CASE("A sweep that was cut anywhere in its last two lines goes on to the same bytes", "[sweep]") {
  const Small small(kPlain);
  const std::string bytes = contents(small.run("whole").file);
  const std::vector<std::string> lines = lines_of(bytes);
  const std::size_t from = bytes.size() - lines.back().size() - lines[lines.size() - 2].size();
  const std::string file = small.folder / "cut/sweep.jsonl", partial = file + ".partial";
  std::filesystem::create_directory(small.folder / "cut");
  for (std::size_t length = from; length <= bytes.size(); ++length) {
    std::filesystem::remove(file);
    small.folder.write("cut/sweep.jsonl.partial", bytes.substr(0, length));
    const SweepOutcome outcome = small.run("cut", {}, 1, true);
    REQUIRE(outcome.failure.empty());
    if (contents(file) != bytes) FAIL("cut after " << length << " bytes");
    REQUIRE_FALSE(std::filesystem::exists(partial));
  }
}

TEST_CASE("A sweep that was cut in its header starts again and one that ended is not run again") {
  const Small small(kPlain);
  const std::string bytes = contents(small.run("whole").file);
  std::filesystem::create_directory(small.folder / "cut");
  small.folder.write("cut/sweep.jsonl.partial", bytes.substr(0, 40));
  CHECK(contents(small.run("cut", {}, 1, true).file) == bytes);
  std::int64_t runs = 0;
  SweepOptions options;
  options.folder = small.folder / "cut";
  options.resume = true;
  options.progress = [&](std::int64_t, std::int64_t, std::int64_t) { ++runs; };
  const SweepOutcome again = run_sweep(small.scenario, options);
  CHECK(runs == 0);
  CHECK(again.exit == ExitCode::expectation_failed);
  CHECK(again.summary.all.runs() == 15);
}

TEST_CASE("An interrupted sweep keeps what it has and goes on to the same bytes") {
  const Small small(kPlain);
  const std::string bytes = contents(small.run("whole").file);
  std::atomic<bool> interrupted{false};
  SweepOptions options;
  options.folder = small.folder / "part";
  options.interrupted = &interrupted;
  options.threads = 1;  // one of two could wait for the processor until the other one has done all
  options.progress = [&](std::int64_t done, std::int64_t, std::int64_t) { interrupted = done >= 4; };
  const SweepOutcome first = run_sweep(small.scenario, options);
  CHECK(first.exit == ExitCode::interrupted);
  CHECK(first.summary.all.runs() == 4);
  CHECK(contents(first.file) == bytes.substr(0, contents(first.file).size()));

  const SweepOutcome refused = run_sweep(small.scenario, options);
  CHECK(refused.exit == ExitCode::run_failed);
  CHECK_THAT(refused.failure, Contains("--resume"));
  CHECK(contents(small.run("part", {}, 2, true).file) == bytes);
}

TEST_CASE("An interrupted sweep does not say what it has found, as it does not know the points that are missing") {
  const Small small(std::string(kPlain) + "find = { smallest = \"remap.latency\" }\n");
  std::atomic<bool> interrupted{false};
  SweepOptions options;
  options.folder = small.folder / "part";
  options.interrupted = &interrupted;
  options.threads = 1;
  options.progress = [&](std::int64_t done, std::int64_t, std::int64_t) { interrupted = done >= 14; };  // of 15
  const SweepOutcome first = run_sweep(small.scenario, options);
  CHECK(first.exit == ExitCode::interrupted);
  CHECK_FALSE(first.summary.find);
  const SweepCommand no_command = [](const SweepPoint&) { return std::string(); };
  CHECK_THAT(sweep_text(first.header, first.summary, no_command), !Contains("smallest"));
  const SweepOutcome whole = small.run("part", {}, 1, true);
  REQUIRE(whole.summary.find);
  CHECK_THAT(sweep_text(whole.header, whole.summary, no_command), Contains("smallest remap.latency"));
}

TEST_CASE("A finished sweep that was cut off afterwards, in a line or between two, is resumed to the same bytes") {
  const Small small(kPlain);
  const std::string bytes = contents(small.run("whole").file);
  for (const std::size_t kept : {bytes.size() - 1, bytes.rfind('\n', bytes.size() - 2) + 1, bytes.size() / 2}) {
    small.folder.write("whole/sweep.jsonl", bytes.substr(0, kept));
    INFO(kept << " of " << bytes.size() << " bytes");
    CHECK(contents(small.run("whole", {}, 1, true).file) == bytes);
  }
}

TEST_CASE("A finished sweep that stopped early, or is another one's, is as it was after --resume") {
  const Small small(kStopping);
  const std::string file = small.run("whole").file, bytes = contents(file);
  REQUIRE(contents(small.run("whole", {}, 1, true).file) == bytes);
  std::string other = bytes;
  other.replace(other.find("\"scenario\":\"") + 12, 4, "0000");
  small.folder.write("whole/sweep.jsonl", other);
  CHECK_FALSE(small.run("whole", {}, 1, true).failure.empty());
  CHECK(contents(file) == other);
  CHECK_FALSE(std::filesystem::exists(file + ".partial"));
}

TEST_CASE("A sweep does not go on with lines of another one or with damaged ones") {
  const Small small(kPlain);
  const std::string bytes = contents(small.run("whole").file);
  std::vector<std::string> lines = lines_of(bytes);
  std::filesystem::create_directory(small.folder / "cut");
  const auto failure_with = [&](const std::string& partial) {
    small.folder.write("cut/sweep.jsonl.partial", partial);
    SweepOptions options;
    options.folder = small.folder / "cut";
    options.resume = true;
    const SweepOutcome outcome = run_sweep(small.scenario, options);
    CHECK(outcome.exit == ExitCode::run_failed);
    CHECK(contents(small.folder / "cut/sweep.jsonl.partial") == partial);  // no work is lost
    return outcome.failure;
  };
  std::string other = lines[0];
  other.replace(other.find("\"scenario\":\"") + 12, 1, "g");
  CHECK_THAT(failure_with(other + lines[1]), Contains("partial:1: error: the line does not agree with its checksum"));
  CHECK_THAT(failure_with(resummed(other) + lines[1]), Contains("sweep.jsonl.partial:1: error: is of another sweep"));
  CHECK_THAT(failure_with(lines[0] + lines[2]), Contains(":2: error: the line is of point 1, where 0 is due"));
  std::string damaged = lines[1];
  damaged.replace(damaged.find("\"seed\":") + 7, 1, "9");
  CHECK_THAT(failure_with(lines[0] + damaged), Contains(":2: error: the line does not agree with its checksum: it is dam"));
  CHECK_THAT(failure_with(resummed(lines[0] + damaged)), Contains(":2: error: the line has other values than point 0"));
  CHECK_THAT(failure_with(lines[0] + "{}\n"), Contains(":2: error: the line has no checksum"));
  const std::string unknown = internal::with_checksum("{\"index\":0}") + "\n";
  CHECK_THAT(failure_with(lines[0] + unknown), Contains(":2: error: the line is not a line"));
}

TEST_CASE("Merge refuses gaps and overlaps and damaged or foreign parts and writes nothing then") {
  const Small small(kPlain);
  const std::vector<std::string> parts = small.shards(3);
  const std::string out = small.folder / "merged.jsonl";
  CHECK_THAT(only_error(merge_sweep({parts[0], parts[2]}, out)),
             Contains("lack 5 of 15 points: 1, 4, 7, 10, 13; shard 2 of 3 is missing"));
  CHECK_THAT(only_error(merge_sweep({parts[0], parts[1]}, out)),
             Contains("lack 5 of 15 points: 2, 5, 8, 11, 14; shard 3 of 3 is missing"));
  CHECK_THAT(only_error(merge_sweep({parts[0], parts[1], parts[2], parts[1]}, out)),
             Contains("sweep-2-of-3.jsonl:2:1: error: point 1 is in") && Contains("sweep-2-of-3.jsonl:2 already"));
  const auto with = [&](const std::string& part) { return only_error(merge_sweep({parts[0], part, parts[2]}, out)); };
  const std::string good = contents(parts[1]);
  CHECK_THAT(with(small.folder.write("torn", good.substr(0, good.size() - 1))),
             Contains("torn:6:1: error: the line has no end"));
  CHECK_THAT(with(small.folder.write("empty", "")), Contains("empty:1:1: error: the line has no end"));
  CHECK_THAT(with(small.folder / "absent"), Contains("absent"));
  CHECK_THAT(with(small.folder.write("header", "{\"format\":1}\n")),
             Contains("header:1:1: error: the line has no checksum"));
  const auto changed = [&](const std::string& name, const std::string& at, const std::string& to) {
    std::string text = good;
    text.replace(text.find(at) + at.size(), to.size(), to);
    CHECK_THAT(with(small.folder.write(name, text)), Contains("does not agree with its checksum: it is damaged"));
    return small.folder.write(name, resummed(text));
  };
  CHECK_THAT(with(changed("scenario", "\"scenario\":\"", "g")), Contains("is of another scenario"));
  CHECK_THAT(with(changed("build", "\"build\":\"", "9")), Contains("is of another build"));
  CHECK_THAT(with(changed("worst", "\"keep_worst\":", "9")), Contains("is of another sweep"));
  CHECK_THAT(with(changed("index", "\"index\":", "2")),
             Contains("index:2:1: error: the line has other values than point 2"));
  CHECK_THAT(with(changed("verdict", "\"verdict\":\"", "pasz")), Contains("verdict:2:1: error: the line verdict \"pasz"));
  CHECK_FALSE(std::filesystem::exists(out));
  CHECK_FALSE(std::filesystem::exists(out + ".merging"));
}

TEST_CASE("A part whose points are missing or not in order is named") {
  const Small small(kPlain);
  const std::vector<std::string> parts = small.shards(3);
  const std::string out = small.folder / "merged.jsonl";
  const std::vector<std::string> good = lines_of(contents(parts[1]));
  const auto with = [&](const std::string& text) {
    return only_error(merge_sweep({parts[0], small.folder.write("part", text), parts[2]}, out));
  };
  CHECK_THAT(with(good[0] + good[1] + good[2]),
             Contains("lack 3 of 15 points: 7, 10, 13; point 7 belongs into") && Contains("/part"));
  CHECK_THAT(with(good[0] + good[2] + good[1]), Contains("part:3:1: error: the line is of point 1, after point 4"));
  CHECK_THAT(with(good[0] + good[1] + good[1]), Contains("part:3:1: error: the line is of point 1, after point 1"));
  CHECK_THAT(with(good[0] + good[1] + good[0]), Contains("part:3:1: error: the line is not a line"));
  CHECK_THAT(only_error(merge_sweep({parts[0]}, out)), Contains("; shards 2, 3 of 3 are missing"));
  const std::vector<std::string> halves = small.shards(2);
  const std::string quarter = small.run("quarter", {2, 4}).file;
  CHECK_THAT(only_error(merge_sweep({halves[0], quarter}, out)), Contains("points: 3, 7, 11; is a shard missing?"));
}

TEST_CASE("The status of a sweep is read from its parts while they are being written") {
  const Small small(kPlain);
  const std::vector<std::string> parts = small.shards(3);
  const std::string good = contents(parts[1]);
  std::filesystem::remove(parts[1]);
  std::filesystem::remove(parts[2]);
  const std::vector<std::string> lines = lines_of(good);
  small.folder.write("of-3/sweep-2-of-3.jsonl.partial", lines[0] + lines[1] + lines[2] + lines[3].substr(0, 50));
  const auto status = sweep_status(small.folder / "of-3");
  REQUIRE(status.ok());
  REQUIRE(status->parts.size() == 2);
  CHECK(status->parts[0].ended);
  CHECK(status->parts[0].done == 5);
  CHECK_FALSE(status->parts[1].ended);
  CHECK(status->parts[1].done == 2);
  CHECK(status->parts[1].items == 5);
  CHECK(status->summary.all.runs() == 7);
  CHECK(status->summary.all.failed == status->parts[0].failed + status->parts[1].failed);
  CHECK_FALSE(status->summary.worst.empty());
  CHECK_THAT(sweep_status(small.folder / "absent").error(), Contains("absent"));
  CHECK_THAT(sweep_status(small.folder / ".").error(), Contains("has no part of a sweep"));
  small.folder.write("of-3/sweep-3-of-3.jsonl", lines[0] + lines[1].substr(0, 50) + "\n");
  CHECK_THAT(sweep_status(small.folder / "of-3").error(),
             Contains("sweep-3-of-3.jsonl:2:1: error: the line has no checksum"));
}

TEST_CASE("Shards of different numbers merge if they have each point once") {
  const Small small(kPlain);
  const std::string whole = contents(small.run("one").file);
  const std::vector<std::string> parts = {small.run("mixed", {1, 2}).file, small.run("mixed", {2, 4}).file,
                                          small.run("mixed", {4, 4}).file};
  const std::string out = small.folder / "merged.jsonl";
  REQUIRE(merge_sweep(parts, out).errors.empty());
  CHECK(contents(out) == whole);
}

TEST_CASE("A merge that was killed is simply run again and one beside another is refused") {
  const Small small(kPlain);
  const std::vector<std::string> parts = small.shards(2);
  const std::string out = small.folder / "merged.jsonl";
  small.folder.write("merged.jsonl.merging", std::string(100'000, 'x'));
  REQUIRE(merge_sweep(parts, out).errors.empty());
  CHECK(contents(out) == contents(small.run("one").file));
  CHECK_FALSE(std::filesystem::exists(out + ".merging"));
  const int other = ::open((out + ".merging").c_str(), O_RDWR | O_CREAT, 0600);
  REQUIRE(::flock(other, LOCK_EX) == 0);
  CHECK_THAT(merge_sweep(parts, out).failure, Contains("is being written by another process"));
  ::close(other);
}

TEST_CASE("Any damaged byte of a part is refused with its file and line") {
  const Small small("[sweep]\nseeds = \"3..5\"\n");
  const std::vector<std::string> parts = small.shards(2);
  const std::string good = contents(parts[1]);
  REQUIRE(merge_sweep(parts, small.folder / "whole").errors.empty());
  std::size_t line = 1;
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string damaged = good;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    INFO("byte " << at);
    const std::string part = small.folder.write("damaged", damaged);
    const std::string error = only_error(merge_sweep({parts[0], part}, small.folder / "merged"));
    // A missing line end joins two lines. The error names the first of them.
    CHECK_THAT(error, Contains(fmt::format("damaged:{}:1: error: ", line)));
    line += good[at] == '\n' ? 1 : 0;
  }
}

TEST_CASE("Parts that call the scenario by different names merge to the same bytes in any order") {
  const Small small(kPlain);
  std::vector<std::string> parts = small.shards(2);
  std::string text = contents(parts[1]);
  text.replace(text.find(small.scenario), small.scenario.size(), "elsewhere/small.toml");
  parts[1] = small.folder.write("other-name", resummed(text));
  const SweepOutcome merged = merge_sweep(parts, small.folder / "merged");
  REQUIRE(merged.errors.empty());
  CHECK(merged.header.file == std::min<std::string>(small.scenario, "elsewhere/small.toml"));
  std::reverse(parts.begin(), parts.end());
  REQUIRE(merge_sweep(parts, small.folder / "reversed").errors.empty());
  CHECK(contents(small.folder / "reversed") == contents(small.folder / "merged"));
}

TEST_CASE("The summary of a merge names the scenario as it was given and its commands run from there") {
  const Small small(kPlain);
  const SweepOutcome merged = merge_sweep(small.shards(2), small.folder / "merged");
  CHECK(merged.header.file == small.scenario);
  const std::string summary = sweep_text(merged.header, merged.summary, [&](const SweepPoint& point) {
    return point_command("evenstep", merged.header, point, merged.header.file);
  });
  CHECK_THAT(summary, Contains("evenstep run " + small.scenario + " --seed"));
}

TEST_CASE("Ordered results come in order whatever the threads and the first exception is the one of the lowest number") {
  for (const int threads : {1, 2, 7}) {
    std::string taken;
    ordered_for(
        100, threads, [](std::size_t i) { return fmt::format("{} ", i); },
        [&](std::size_t i, const std::string& made) {
          CHECK(made == fmt::format("{} ", i));
          taken += made;
          return i < 60;
        });
    CHECK(taken.ends_with(" 59 60 "));
    std::size_t last = 0;
    const auto run = [&] {
      ordered_for(
          100, threads,
          [](std::size_t i) -> std::string {
            if (i == 41 || i == 40 || i == 77) throw std::runtime_error(fmt::format("at {}", i));
            return "x";
          },
          [&](std::size_t i, const std::string&) { return last = i, true; });
    };
    CHECK_THROWS_WITH(run(), "at 40");
    CHECK(last == 39);
  }
}

TEST_CASE("The command of a point runs it again to the same trace") {
  const Small small(kPlain);
  const SweepOutcome whole = small.run("one");
  const SweepPoint point = points_of(whole)[7];
  SweepHeader header = whole.header;
  header.set = {"run.warmup=0.1 s"};
  CHECK(point_command("./run.sh", header, point, "a b.toml") ==
        "./run.sh run 'a b.toml' --seed 5 --set 'run.warmup=0.1 s' --set 'remap.latency=17 ms'");
  const ReadResult read = read_scenario(small.scenario, {{"remap.latency=17 ms"}, 5});
  REQUIRE(read);
  const RunOutcome again = run_scenario(*read, {});
  CHECK(again.record.trace_hash == point.trace_hash);
  REQUIRE(point.expect.size() == 1);
  CHECK(again.results.front().value == point.expect.front().value);
}

TEST_CASE("The shipped sweeps find what they ask for", "[sweep]") {
  TemporaryFolder folder;
  SweepOptions options;
  options.folder = folder / "out";
  // Only a tenth of the seeds of the scenario. The command line runs all of them.
  options.set = {"sweep.seeds=\"0..10\""};
  const SweepOutcome outcome = run_sweep(EVENSTEP_SOURCE_DIR "/scenarios/sizing/latency-jitter-10.toml", options);
  for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
  REQUIRE(outcome.errors.empty());
  REQUIRE(outcome.summary.find);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.summary.find->beyond == 0);
  options.set = {"sweep.seeds=\"0..10\"", "sweep.find.at_most=\"22 ms\""};
  CHECK(run_sweep(EVENSTEP_SOURCE_DIR "/scenarios/sizing/latency-jitter-10.toml", options).exit ==
        ExitCode::expectation_failed);
}
