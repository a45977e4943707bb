#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "evenstep/apps/shell.h"
#include "src/commands.h"

namespace evenstep::app {
namespace fs = std::filesystem;
namespace {

struct InitArguments {
  std::string program;
  std::string folder = ".";
};

struct StarterFile {
  const char* path;
  const char* what;
  const char* text;
};

constexpr const char* kScenario =
    R"(# A scenario: a machine, a scene, a hand, and what must hold. `evenstep check` explains it, `evenstep run` judges it.
format  = 1
name    = "Our simulator: 30 Hz, 15 steps between two pictures"
because = "A hand that moves evenly must reach the physics evenly, and the force must come back evenly."

[run]
duration = "2 s"                   # of simulated time; a run takes a fraction of that
warmup   = "8 segments"            # not judged: buffers fill

# What the machine does. One segment is a visualization, in which no step is computed, and then the steps.
[timing]
segment       = "30 Hz"
visualization = "11.1 ms"
steps         = 15
# Instead of these three, your own machine:   trace = "my-steps.csv"   (columns begin_ns,end_ns, or a profiler's file)

# What is touched. "tissue" is a lattice of particles; a spring is enough to see time.
[scene]
kind      = "spring"
stiffness = "200 N/m"

# The hand's device, and what the hand does: there and back at constant velocity. The turns are not judged.
[[device]]
name   = "left"
rate   = "1 kHz"
motion = { kind = "back-and-forth", velocity = ["0.1 m/s", "0 m/s", "0 m/s"], straight = "0.8 s", turn = "0.2 s" }
render = { kind = "force", emission = "hold" }

# A force reaches the hand this long after the position that it answers was read. "minimal" is the least that works.
[remap]
latency = "13 ms"

# What must hold. An expectation names a signal, DEVICE.interaction.STRATEGY (the hand as the physics sees it) or
# DEVICE.force.STRATEGY (the force as the hand feels it), a metric and a limit. `evenstep list` shows all of them.
[[expect]]
signal  = "left.force.phase_locked"
metric  = "underruns"
equals  = 0
because = "12.85 ms are enough for this timing, so with 13 ms no force comes late"

[[expect]]
signal  = "left.interaction.phase_locked"
metric  = "velocity_jump"
max     = "0.001 step"             # with a recording: a little more than the jump that `evenstep size` prints for it
because = "at constant velocity every step sees the hand move by the same amount; a nanosecond's rounding is 5e-7 step"

[[expect]]
signal  = "left.interaction.direct"
metric  = "velocity_jump"
min     = "1 step"
because = "a control: without the remap the hand jumps after each visualization; if not, the test above shows nothing"
)";

constexpr const char* kCMake = R"(cmake_minimum_required(VERSION 3.25)
project(scenarios LANGUAGES NONE)

find_package(evenstep REQUIRED COMPONENTS program)   # not found? cmake -B build -DCMAKE_PREFIX_PATH=where/it/is

enable_testing()
evenstep_add_scenarios(DIRECTORY scenarios RECURSE)   # a test for each: ctest --test-dir build --output-on-failure
# Once there are recordings: a test for each that your latency and your rings are enough for it.
# evenstep_add_sizing(NAME loop RECORDINGS recordings LATENCY "20 ms" RINGS 64 32)
)";

constexpr const char* kGitHub =
    R"(# Runs the scenarios at every push and for every pull request. An expectation that fails is marked at its line.
name: evenstep
on: [push, pull_request]
permissions:
  contents: read
jobs:
  scenarios:
    runs-on: ubuntu-latest
    container: debian:12
    env:
      EVENSTEP_GIT: ${{ vars.EVENSTEP_GIT }}   # where evenstep is cloned from: a variable of this repository
      EVENSTEP_VERSION: main                   # a branch or tag; with a tag, results only change with your own work
    steps:
      - run: apt-get update && apt-get install -y --no-install-recommends ca-certificates git
      - uses: actions/checkout@v4
      - run: git clone --depth 1 --branch "$EVENSTEP_VERSION" "$EVENSTEP_GIT" "$RUNNER_TEMP/evenstep"
      - run: '"$RUNNER_TEMP/evenstep/run.sh" run scenarios'
      - uses: actions/upload-artifact@v4
        if: always()
        with:
          name: runs
          path: runs
)";

constexpr const char* kGitLab = R"(# Runs the scenarios in every pipeline. GitLab shows their verdicts in its list of tests.
scenarios:
  image: debian:12
  variables:
    EVENSTEP_VERSION: main   # a branch or tag; with a tag, results only change with your own work
    # EVENSTEP_GIT, where evenstep is cloned from, is a variable of this project (Settings, CI/CD).
  script:
    - apt-get update && apt-get install -y --no-install-recommends ca-certificates git
    - git clone --depth 1 --branch "$EVENSTEP_VERSION" "$EVENSTEP_GIT" /tmp/evenstep
    - /tmp/evenstep/run.sh run scenarios
  artifacts:
    when: always
    paths: [runs/]
    reports:
      junit: runs/*/junit.xml
)";

constexpr std::array<StarterFile, 4> kFiles{{{"scenarios/first.toml", "a scenario that passes, explained", kScenario},
                                             {"CMakeLists.txt", "a ctest for each scenario", kCMake},
                                             {".github/workflows/evenstep.yml", "the scenarios on GitHub", kGitHub},
                                             {".gitlab-ci.yml", "the scenarios on GitLab", kGitLab}}};

/// Writes all files, or none. What went wrong; empty if nothing did.
std::string write_files(const fs::path& folder) {
  for (std::size_t i = 0; i < kFiles.size(); ++i) {
    const fs::path path = folder / kFiles[i].path;
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    std::ofstream out(path, std::ios::binary);
    out << kFiles[i].text << std::flush;
    if (out) continue;
    const std::string why = std::generic_category().message(error ? error.value() : errno);
    for (std::size_t written = 0; written <= i; ++written) fs::remove(folder / kFiles[written].path, error);
    return fmt::format("{}: error: cannot be written: {}; nothing is left of this call's files; name another folder",
                       path.string(), why);
  }
  return "";
}

ExitCode init(const InitArguments& arguments, const std::atomic<bool>&) {
  const fs::path folder = arguments.folder;
  bool free = true;
  for (const StarterFile& file : kFiles) {
    std::error_code error;
    if (fs::symlink_status(folder / file.path, error).type() == fs::file_type::not_found) continue;
    spdlog::error("{}: error: is there already", (folder / file.path).string());
    free = false;
  }
  if (!free) {
    spdlog::error(
        "error: nothing was written; name another folder, `evenstep init FOLDER`, and take from there what you need");
    return ExitCode::usage;
  }
  if (const std::string error = write_files(folder); !error.empty()) {
    spdlog::error("{}", error);
    return ExitCode::run_failed;
  }
  for (const StarterFile& file : kFiles) fmt::print("{:<44} {}\n", (folder / file.path).string(), file.what);
  const std::string scenario = shell_file((folder / kFiles[0].path).string());
  fmt::print("next: {0} check {1}\nnext: {0} run {1}\n", arguments.program, scenario);
  return ExitCode::pass;
}

}  // namespace

void add_init(Commands& commands) {
  auto [command, arguments] = commands.add<InitArguments>(
      "init", "write a first scenario, and the files that run it with CTest, GitHub and GitLab", init);
  arguments.program = commands.program();
  command.optional_operand("folder", arguments.folder, "where; default here. Nothing that is there is replaced");
}

}  // namespace evenstep::app
