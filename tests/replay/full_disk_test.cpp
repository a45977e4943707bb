// A disk that is full for ever or for a while. Without rights these tests cannot make a small disk. Instead, /dev/full takes
// nothing at all, and a limit on the size of files (RLIMIT_FSIZE) takes a part of a block.

#include <sys/resource.h>
#include <sys/wait.h>
#include <csignal>

#include "evenstep/harness/run.h"
#include "recordings.h"
#include "scenarios.h"
#include "src/log/writer.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

void limit_files_to(rlim_t bytes) {
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur = bytes;
  ::setrlimit(RLIMIT_FSIZE, &limit);
}

struct LimitedFiles {
  explicit LimitedFiles(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    limit_files_to(bytes);
  }
  ~LimitedFiles() { limit_files_to(RLIM_INFINITY); }
};

const std::vector<std::string> kShort{"remap.latency=\"60 ms\"",
                                      "remap.lead=\"20 ms\"",
                                      "run.duration=\"0.5 s\"",
                                      "run.strategies=[\"phase_locked\"]",
                                      "run.warmup=\"0 s\"",
                                      "expect=[{ signal = \"left.interaction.phase_locked\", metric = \"back_steps\", "
                                      "max = 100000 }]"};

RunOutcome recorded_run(const std::string& path) {
  RunOptions options;
  options.clock = ClockKind::wall;
  options.record_to = path;
  return run_scenario(read("paper/figure-1-spring.toml", kShort), options);
}

}  // namespace

TEST_CASE("lanes are refused, and never wait, while a disk takes nothing, nothing is lost once it does again") {
  const TemporaryFolder folder;
  const std::string path = folder / "x";
  auto writer = internal::InputLogWriter::create(path, made_up_head());
  REQUIRE(writer);
  std::int64_t taken = 0;
  {
    const LimitedFiles full(10'000);  // the limit is within a block
    while ((*writer)->offer(internal::BlockKind::device, encoded(device_slice(taken)))) ++taken;
    CHECK(taken > 100);  // the ring is full
    const InputLogResult meanwhile = read_input_log(path);
    CHECK((!meanwhile || meanwhile->bytes <= 10'000));
  }
  while (!(*writer)->offer(internal::BlockKind::device, encoded(device_slice(taken)))) {
  }
  (*writer)->stop();
  CHECK((*writer)->finish().empty());
  const InputLogResult read = read_input_log(path);
  INFO(errors_of(read));
  REQUIRE(read);
  CHECK(read->inputs[0].ticks.size() == static_cast<std::size_t>(20 * (taken + 1)));
}

TEST_CASE("a run whose recording finds no room goes on to its end, and does not pass") {
  const RunOutcome outcome = recorded_run("/dev/full");
  INFO(outcome.failure);
  CHECK(outcome.record.strategies.at(0).devices.at(0).ticks.size() > 300);
  REQUIRE(outcome.results.size() == 1);
  CHECK(outcome.results[0].verdict == ExpectationResult::Verdict::pass);
  CHECK(outcome.repeat_difference.empty());
  CHECK(outcome.exit == ExitCode::run_failed);
  CHECK(outcome.verdict == RunVerdict::error);
  CHECK_THAT(outcome.failure, Catch::Contains("/dev/full: the recording is lost: No space left on device"));
}

TEST_CASE("a run whose disk gets full says how much is missing, and the rest replays") {
  const TemporaryFolder folder;
  const std::string path = folder / "x";
  RunOutcome outcome;
  {
    const LimitedFiles full(20'000);
    outcome = recorded_run(path);
  }
  INFO(outcome.failure);
  CHECK(outcome.exit == ExitCode::run_failed);
  CHECK_THAT(outcome.failure, Catch::Contains("not complete: File too large") && Catch::Contains("it replays until 0."));
  const InputLogResult log = read_input_log(path);
  REQUIRE(log);
  CHECK_FALSE(log->end);
  CHECK(log->until() > RealTime{0});
  const std::size_t lost = outcome.record.strategies.at(0).devices.at(0).ticks.size() - log->inputs[0].ticks.size();
  CHECK_THAT(outcome.failure, Catch::Contains(std::to_string(lost) + " of "));
}

TEST_CASE("a recording of nothing is no file") {
  const TemporaryFolder folder;
  {
    auto writer = internal::InputLogWriter::create(folder / "x", made_up_head());
    REQUIRE(writer);
    CHECK(std::filesystem::exists(folder / "x"));
  }
  CHECK_FALSE(std::filesystem::exists(folder / "x"));
}

TEST_CASE("a recording is never overwritten, and is for the wall clock") {
  const TemporaryFolder folder;
  const std::string path = folder / "x";
  std::ofstream(path) << "precious";
  const RunOutcome refused = recorded_run(path);
  CHECK(refused.exit == ExitCode::usage);
  REQUIRE(refused.errors.size() == 1);
  CHECK_THAT(refused.errors[0].message, Catch::Contains("exists already"));
  CHECK(bytes_of(path).size() == 8);
  RunOptions options;
  options.record_to = folder / "y";
  const RunOutcome in_virtual_time = run_scenario(read("paper/figure-1-spring.toml", kShort), options);
  REQUIRE(in_virtual_time.errors.size() == 1);
  CHECK_THAT(in_virtual_time.errors[0].message, Catch::Contains("--clock wall"));
  options.clock = ClockKind::wall;
  options.record_to = folder / "no-folder/y";
  CHECK(run_scenario(read("paper/figure-1-spring.toml", kShort), options).exit == ExitCode::run_failed);
}
