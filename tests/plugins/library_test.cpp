// Parts in a shared object are as good as registered ones, and each of their faults is reported at its place.
#include <array>
#include <filesystem>
#include <fstream>

#include "evenstep/plugins/plugin.h"
#include "support.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::string module(const std::string& name) { return std::string(EVENSTEP_MODULES) + "/" + name + ".so"; }
std::string scene_in(const std::string& path, const std::string& options = "{}") {
  return fmt::format("scene={{ library = \"{}\", options = {} }}", path, options);
}
std::string parts_in_c() { return scene_in(module("parts")); }

std::string refusal(const std::vector<std::string>& set) { return errors_of(set, builtin()); }

}  // namespace

TEST_CASE("A solver in a library gives the bits of the same solver registered, with any seed, order of ties and threads") {
  const RunRecord registered = record({kMySpring});
  const RunRecord in_library = record({scene_in(module("none"))}, builtin());
  // This solver computes the first tool only.
  CHECK(in_library.strategies.front().solver.name == "faulty");
  CHECK(in_library.strategies.front().solver.lacks.size() == 5);
  const RunRecord c = record({parts_in_c()}, builtin());
  for (const StrategyRecord& one : c.strategies) {
    const auto& twin = strategy(registered, one.name);
    REQUIRE(one.devices.size() == twin.devices.size());
    for (std::size_t device = 0; device < one.devices.size(); ++device) {
      REQUIRE(one.devices[device].steps.size() == twin.devices[device].steps.size());
      for (std::size_t n = 0; n < one.devices[device].steps.size(); ++n)
        REQUIRE(one.devices[device].steps[n].force_N == twin.devices[device].steps[n].force_N);
    }
  }
  CHECK(record({parts_in_c()}, builtin(), {.threads = 2, .repeat = true}).trace_hash == c.trace_hash);
  // The digest of this solver begins with the seed that it was given.
  CHECK(record({parts_in_c(), "run.seed=2"}, builtin()).trace_hash != c.trace_hash);
}

TEST_CASE("Device, map and timing source can be in a library, too") {
  const std::string part = fmt::format("{{ library = \"{}\" }}", module("parts"));
  const RunRecord run = record({parts_in_c(), "run.strategies=[\"direct\", \"foreign\"]", "remap.foreign=" + part,
                                "device.left.driver=foreign", "device.left.foreign=" + part},
                               builtin());
  const RunRecord mine =
      record({parts_in_c(), "run.strategies=[\"direct\", \"foreign\"]", "remap.foreign={ name = \"my-pacer\" }",
              "device.left.driver=foreign", "device.left.foreign={ name = \"my-arm\" }"});
  CHECK(run.trace_hash == mine.trace_hash);
  const RunRecord timed =
      record({parts_in_c(), fmt::format("timing={{ foreign = {} }}", part), "run.strategies=[\"direct\"]"}, builtin());
  CHECK(strategy(timed, "direct").steps.size() > 200);
}

TEST_CASE("A library beside the other keys of a device, a remap or a timing is short for a foreign part") {
  const std::string key = fmt::format("library = \"{}\"", module("parts"));
  const std::string motion = "motion = { kind = \"sine\", amplitude = [\"2 cm\", \"0 m\", \"0 m\"], frequency = \"1 Hz\" }";
  const auto all = [&](const std::string& device, const std::string& remap, const std::string& timing) {
    return record({parts_in_c(), "run.strategies=[\"direct\", \"foreign\"]", "remap=" + remap, "timing=" + timing,
                   fmt::format("device=[{{ name = \"left\", {}, {} }}]", motion, device)},
                  builtin());
  };
  const RunRecord brief = all(key, "{ " + key + " }", fmt::format("{{ {}, options = {{ jitter = 0.1 }} }}", key));
  const RunRecord whole =
      all(fmt::format("driver = \"foreign\", foreign = {{ {} }}", key), fmt::format("{{ foreign = {{ {} }} }}", key),
          fmt::format("{{ foreign = {{ {}, options = {{ jitter = 0.1 }} }} }}", key));
  CHECK(brief.trace_hash == whole.trace_hash);
  CHECK_THAT(refusal({fmt::format("remap={{ {}, foreign = {{ {} }} }}", key, key)}), Contains("does not go with 'foreign'"));
  CHECK_THAT(refusal({"remap={ options = {} }"}), Contains("'options' is about a 'library', and there is none"));
}

TEST_CASE("What a library can do is found out, and what it lacks is left out") {
  const RunRecord run =
      record({parts_in_c(), "expect=[{ signal = \"solver.direct\", metric = \"energy_growth\", max = 0.1 }]",
              "device.left.render={ kind = \"local\" }"},
             builtin());
  CHECK(run.strategies.front().solver.lacks == std::vector<std::string>{"particles"});
  const RunOutcome lacking = own_parts::run(
      {scene_in(module("none")), "expect=[{ signal = \"solver.direct\", metric = \"energy_growth\", max = 0.1 }]"},
      builtin());
  CHECK_THAT(text_of(lacking.errors), Contains("the solver 'faulty' has no energy"));
}

TEST_CASE("A library that is none, or another one, is refused with what is wrong with it") {
  const TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  std::ofstream(folder / "text.so") << "not a library\n";
  std::ofstream(folder / "empty.so");
  std::ofstream(folder / "cut.so") << std::string(
      "\x7f"
      "ELF\x02\x01\x01",
      7);
  // The same library, but for one field of its ELF header: e_machine is at byte 18, e_type at byte 16.
  const auto changed = [&](const char* name, std::streamoff at, char to) {
    fs::copy_file(module("none"), folder / name);
    std::fstream(folder / name, std::ios::in | std::ios::out | std::ios::binary).seekp(at).put(to);
    return (folder / name).string();
  };
  for (const auto& [path, error] : std::vector<std::array<std::string, 2>>{
           {changed("other.so", 18, '\x7f'), "was built for another processor"},
           {changed("class.so", 4, '\x01'), "was built for another processor"},
           {changed("program.so", 16, '\x02'), "is no shared object; link it with -shared"},
           {"nowhere/libmine.so", "'nowhere/libmine.so' No such file or directory"},
           {folder.string(), "is a folder"},
           {(folder / "text.so").string(), "is no shared object"},
           {(folder / "empty.so").string(), "is no shared object"},
           {(folder / "cut.so").string(), "is cut off"},
           {"/dev/null", "is no file"},
           {EVENSTEP_TEST_PROCESS, "it"},  // a program, which the dynamic linker refuses
           {module("no_symbol"), "it exports no function evenstep_plugin_v1; is it a plug-in, and made for this ABI (1)?"},
           {module("abi"), "it was built for ABI 2, and this evenstep has 1; build it with the plugin.h of this evenstep"},
           {module("size"), "its evenstep_plugin has 56 bytes, and here it has 48"},
           {module("table_size"), "its table of solver functions has 64 bytes, and here it has 72"},
           {module("no_step"), "its solver has no function 'step', without which there is none"},
           {module("half_device"), "its device has no function 'read'"},
           {module("half_map"), "its map has no function 'boundary'"},
           {module("half_timing"), "its timing has no function 'create'"},
           {module("map_size"), "its table of map functions has 64 bytes, and here it has 56"},
           {module("timing_size"), "its table of timing functions has 40 bytes, and here it has 32"},
           {module("empty_name"), "it has no name; set evenstep_plugin.name"},
           {module("no_name"), "it has no name; set evenstep_plugin.name"},
           {module("nothing"), "its evenstep_plugin_v1() returns nothing"},
           {module("entry_throws"), "its evenstep_plugin_v1() threw an exception"},
           {module("empty"), "it has no solver, device, map or timing"}}) {
    INFO(path);
    const std::string errors = refusal({scene_in(path)});
    CHECK_THAT(errors, Contains("'library': '" + path + "'"));
    CHECK_THAT(errors, Contains(error));
  }
  CHECK_THAT(refusal({fmt::format("remap.foreign={{ library = \"{}\" }}", module("none"))}),
             Contains("('faulty') has no map"));
  CHECK_THAT(
      refusal({fmt::format("timing={{ foreign = {{ library = \"{}\", options = {{ refuse = 1 }} }} }}", module("parts"))}),
      Contains("the timing source 'parts in C': create returned 1: no such GPU"));
}

TEST_CASE("A path in a scenario is counted from the scenario, and a bare name is looked for nowhere else") {
  const TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  fs::create_directories(folder / "libraries");
  fs::copy_file(module("none"), folder / "libraries/mine.so");
  const auto written = [&](const std::string& path) {
    std::ofstream(folder / "a.toml") << "format = 1\n[run]\nduration = \"0.1 s\"\n[timing]\nsegment = \"30 Hz\"\n"
                                     << "visualization = \"11.1 ms\"\nsteps = 15\n[scene]\nlibrary = \"" << path
                                     << "\"\n[[device]]\nname = \"left\"\n";
    return read_scenario((folder / "a.toml").string());
  };
  const ReadResult read = written("libraries/mine.so");
  INFO(text_of(read.error_or({})));
  REQUIRE(read);
  CHECK(std::get<ForeignScene>(read->scene.body).name == "faulty");
  CHECK_THAT(read->resolved_toml, Contains((folder / "libraries/mine.so").string()));
  const ReadResult refused = written("libc.so.6");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().front().line == 9);
  CHECK(refused.error().front().column == 11);
  CHECK_THAT(refused.error().front().message, Contains("No such file"));
}

TEST_CASE("What goes wrong inside a library ends the run, with its words, its step and exit code 3") {
  for (const auto& [scene, error] : std::vector<std::array<std::string, 2>>{
           {scene_in(module("throws")), "the solver 'faulty', step 0: step threw an exception: out of cheese"},
           {scene_in(module("throws_int")), "the solver 'faulty', step 0: step threw something that is no std::exception"},
           {scene_in(module("silent")), "the solver 'faulty', step 0: step returned 42"},
           {scene_in(module("parts"), "{ fail_at = 7 }"), "the solver 'parts in C', step 7: step returned 1: cannot go on"},
           {scene_in(module("parts"), "{ refuse = 1 }"),
            "the solver 'parts in C': create returned 1: no such mesh?at \"x\"?"}}) {
    INFO(scene);
    const RunOutcome outcome = run({scene}, builtin());
    CHECK(outcome.exit == ExitCode::run_failed);
    CHECK_THAT(outcome.failure, Contains(error));
    CHECK_FALSE(outcome.remedy.empty());
  }
  const RunOutcome expected = run({scene_in(module("parts"), "{ fail_at = 7, fail_with = 3 }"),
                                   "expect_stop={ reason = \"unstable-step\", at_least_step = 7, at_most_step = 7 }"},
                                  builtin());
  INFO(expected.failure);
  CHECK(expected.exit == ExitCode::pass);
}

TEST_CASE("A registered solver's name can stand as the kind of a scene") {
  const std::vector<std::string> by_kind{R"(scene={ kind = "my-spring", options = { stiffness = 200 } })"};
  CHECK(record(by_kind).trace_hash == record({kMySpring}).trace_hash);
  CHECK_THAT(errors_of({R"(scene={ kind = "my-sprig" })"}, registry()), Contains("did you mean 'my-spring'"));
  CHECK_THAT(errors_of({R"(scene={ kind = "sping" })"}, registry()), Contains("must be \"spring\""));
}
