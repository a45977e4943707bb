// Sweeps and shrinking with a library or a process. The contents of these files count, not their places.
#include <filesystem>
#include <fstream>

#include "evenstep/campaigns/shrink.h"
#include "evenstep/campaigns/sweep.h"
#include "support.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace own_parts;
namespace fs = std::filesystem;

namespace {

/// A folder with the scenario and the file that its scene names.
class Folder : public TemporaryFolder {
 public:
  /// Writes a scenario whose timing varies. `first` comes before the tables.
  void write_scenario(const std::string& scene, const std::string& first) const {
    write("a.toml",
          "format = 1\n" + first +
              "\n[run]\nduration = \"0.3 s\"\nstrategies = [\"phase_locked\"]\n[timing]\nsegment = \"30 Hz\"\n"
              "visualization = \"11.1 ms\"\nsteps = 15\njitter = { visualization = \"lognormal 10 %\" }\n[scene]\n" +
              scene +
              "\n[[device]]\nname = \"left\"\n[[expect]]\nsignal = \"left.force.phase_locked\"\nmetric = \"underruns\"\n"
              "equals = 0\n");
  }
  /// The digest of the sweep. By it another process knows that the sweep is the same.
  std::string swept() const {
    SweepOptions options;
    options.folder = *this / "sweep";
    fs::remove_all(options.folder);
    fs::create_directories(options.folder);
    const SweepOutcome outcome = run_sweep(*this / "a.toml", options);
    INFO(text_of(outcome.errors) << outcome.failure);
    REQUIRE(outcome.exit == ExitCode::pass);
    return outcome.header.scenario;
  }
};

const std::string kModules = EVENSTEP_MODULES;
const std::string kSweep = "sweep = { seeds = [1, 2] }\nremap = { latency = \"30 ms\" }";

}  // namespace

TEST_CASE("A sweep is another one when the library holds something else, and the same one when it lies elsewhere") {
  const Folder here, there;
  here.write_scenario("library = \"mine.so\"", kSweep);
  there.write_scenario("library = \"mine.so\"", kSweep);
  fs::copy_file(kModules + "/none.so", here.path() / "mine.so");
  fs::copy_file(kModules + "/none.so", there.path() / "mine.so");
  const std::string first = here.swept();
  CHECK(there.swept() == first);
  // It needs another name, because a library that was opened stays as it was.
  fs::copy_file(kModules + "/parts.so", here.path() / "yours.so");
  here.write_scenario("library = \"yours.so\"", kSweep);
  CHECK(here.swept() != first);
}

TEST_CASE("A sweep is another one when a file that the command names holds something else") {
  const Folder here, there;
  const std::string scene = fmt::format("command = [\"{}\", \"good\", \"mesh.txt\"]", EVENSTEP_TEST_PROCESS);
  for (const Folder* folder : {&here, &there}) {
    folder->write_scenario(scene, kSweep);
    folder->write("mesh.txt", "a liver");
  }
  const std::string first = here.swept();
  CHECK(there.swept() == first);
  here.write("mesh.txt", "a spleen");
  CHECK(here.swept() != first);
}

TEST_CASE("What shrink writes runs by itself, with a library and with a process that reads files of its folder") {
  const Folder folder;
  fs::copy_file(kModules + "/parts.so", folder.path() / "mine.so");
  fs::copy_file(EVENSTEP_TEST_PROCESS, folder.path() / "solver");
  for (const std::string scene : {"library = \"mine.so\"", "command = [\"./solver\", \"good\"]"}) {
    INFO(scene);
    folder.write_scenario(scene, "remap = { latency = \"11 ms\" }");
    ShrinkOptions options;
    options.folder = folder / "shrunk";
    const ShrinkOutcome outcome = shrink_scenario(folder / "a.toml", options);
    INFO(text_of(outcome.errors) << outcome.failure);
    REQUIRE(outcome.exit == ExitCode::pass);
    const ReadResult read = read_scenario(outcome.file);
    INFO(text_of(read.error_or({})));
    REQUIRE(read);
    CHECK(run_scenario(*read, {}).exit == ExitCode::expectation_failed);
  }
}
