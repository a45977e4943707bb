// Solvers in separate processes: good ones, and every way in which one can go wrong.
#include <sys/wait.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "evenstep/plugins/process_solver.h"
#include "support.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::string scene_of_process(const std::string& fault, const std::string& more = "") {
  return fmt::format("scene={{ command = [\"{}\", \"{}\"]{} }}", EVENSTEP_TEST_PROCESS, fault, more);
}

/// No process that the test has started is left, not even one for which nobody has waited.
void check_no_child() {
  int status = 0;
  CHECK(waitpid(-1, &status, WNOHANG) == -1);
  CHECK(errno == ECHILD);
}

ProcessCommand command(const std::string& fault) { return {{EVENSTEP_TEST_PROCESS, fault}, ".", Duration{20'000'000'000}}; }

/// The error of a solver that is made and asked for 8 steps.
std::string fault_of(const std::string& fault, Duration limit = {20'000'000'000}) {
  ProcessCommand faulty = command(fault);
  faulty.answer_limit = limit;
  try {
    const auto solver = process_solver(faulty)({});
    for (int n = 0; n < 8; ++n) solver->step(std::array{glm::dvec3(1e-3 * n, 0, 0)}, 1e-3);
  } catch (const std::exception& error) {
    check_no_child();
    return error.what();
  }
  return "nothing";
}

}  // namespace

TEST_CASE("A solver in a process gives the forces of the same solver in this one, with any order of ties and threads") {
  const RunRecord registered = record({kMySpring});
  const RunRecord in_process = record({scene_of_process("good")}, builtin());
  CHECK(in_process.strategies.front().solver.lacks == std::vector<std::string>{"contacts", "energy", "particles"});
  for (const StrategyRecord& one : in_process.strategies) {
    const auto& twin = strategy(registered, one.name);
    for (std::size_t device = 0; device < one.devices.size(); ++device) {
      REQUIRE(one.devices[device].steps.size() == twin.devices[device].steps.size());
      for (std::size_t n = 0; n < one.devices[device].steps.size(); ++n)
        REQUIRE(one.devices[device].steps[n].force_N == twin.devices[device].steps[n].force_N);
    }
  }
  CHECK(record({scene_of_process("good")}, builtin(), {.threads = 2, .repeat = true}).trace_hash == in_process.trace_hash);
  check_no_child();
}

TEST_CASE("A process is told its tools, step, seed and options, and runs in the scenario's folder") {
  const RunOutcome outcome = run({scene_of_process("where", ", options = { mesh = \"ü\" }, directory = \"/usr\""),
                                  "run.strategies=[\"direct\"]", "run.seed=7"},
                                 builtin());
  CHECK(outcome.exit == ExitCode::pass);
  ProcessCommand there = command("where");
  there.folder = "/";
  const auto solver = process_solver(there)({.options = "{\"mesh\":1}", .step_s = 0.125, .seed = 7});
  solver->step(std::array{glm::dvec3(1, 0, 0)}, 0.125);
  CHECK(solver->step(std::array{glm::dvec3(0, 0.5, 0)}, 0.125).force_N[0] == glm::dvec3(-0.0, -100, -0.0));
  const std::uint64_t digest = solver->state_digest();
  solver->reset();
  CHECK(solver->state_digest() == 0);
  solver->step(std::array{glm::dvec3(1, 0, 0)}, 0.125);
  solver->step(std::array{glm::dvec3(0, 0.5, 0)}, 0.125);
  CHECK(solver->state_digest() == digest);
}

TEST_CASE("A process that goes wrong is a clear error, and nothing of it is left") {
  const Duration short_limit{300'000'000};
  CHECK(fault_of("good") == "nothing");
  CHECK(fault_of("chatty") == "nothing");
  CHECK(fault_of("exits") ==
        "ended (exit status 3) before its first line was whole; its standard error ends with: no such mesh");
  CHECK(fault_of("half_line") == "ended (exit status 0) before its first line was whole; it has written '{\"proto'");
  CHECK(fault_of("mute", short_limit) == "did not answer the first line within 0.3 s");
  CHECK(fault_of("prints") == "the first line of its standard output is no JSON object: 'Loading mesh ...'");
  CHECK_THAT(fault_of("long_line"), Contains("the first line of its standard output is longer than 4096 bytes"));
  CHECK(fault_of("other_protocol") ==
        "the first line of its standard output does not say \"protocol\": 1: '{\"protocol\": 2}'");
  CHECK_THAT(fault_of("other_has"), Contains("has something else than \"contacts\""));
  CHECK(fault_of("hangs", short_limit) == "has written 0 of the 56 bytes of its answer within 0.3 s");
  CHECK(fault_of("exits_at_5") ==
        "ended (exit status 7) after 0 of the 56 bytes of its answer; its standard error ends with: ZeroDivisionError: "
        "division "
        "by zero");
  CHECK(fault_of("aborts_at_5") == "was ended by signal 6 (Aborted) after 0 of the 56 bytes of its answer");
  CHECK(fault_of("closes_output") == "closed its standard output after 0 of the 56 bytes of its answer");
  CHECK(fault_of("short") == "ended (exit status 0) after 28 of the 56 bytes of its answer");
  CHECK(fault_of("short_hangs", short_limit) == "has written 28 of the 56 bytes of its answer within 0.3 s");
  CHECK(
      fault_of("rubbish") ==
      "its answer begins with kind 1094795585 and number 4702111234474983745, and it was asked for kind 1 and number 5; as "
      "text it begins 'AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA...'");
  CHECK(fault_of("more") == "has written 5 bytes that nobody asked for: 'debug'");
  CHECK(fault_of("status") == "answered with status 3; its standard error ends with: the mesh is torn");
  CHECK(fault_of("status_1") == "answered with status 1");
  // Nothing reads the sixth request, which would be a SIGPIPE for a program that does not keep it off.
  CHECK(fault_of("reads_no_more", short_limit) == "has written 0 of the 56 bytes of its answer within 0.3 s");
  CHECK(fault_of("quits") == "ended (exit status 0) after 0 of the 56 bytes of its answer");
  CHECK(fault_of("stays") == "nothing");
  CHECK(fault_of("has_child") == "nothing");
}

TEST_CASE("A write to a process that reads no more leaves no SIGPIPE behind, and takes none that was there before") {
  sigset_t pipe_signal, before, pending;
  sigemptyset(&pipe_signal);
  sigaddset(&pipe_signal, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe_signal, &before);
  const auto is_pending = [&] { return sigpending(&pending), sigismember(&pending, SIGPIPE) == 1; };
  CHECK_FALSE(is_pending());
  fault_of("quits");
  CHECK_FALSE(is_pending());
  raise(SIGPIPE);
  fault_of("quits");
  CHECK(is_pending());
  const timespec at_once{};
  sigtimedwait(&pipe_signal, nullptr, &at_once);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

TEST_CASE("Contacts and energy of a solver in a process arrive, and status 2 is bad input") {
  const auto solver = process_solver(command("rich"))({});
  CHECK(solver->capabilities().contacts);
  solver->step(std::array{glm::dvec3(0)}, 1e-3);
  CHECK(solver->energy_J() == 0.5);
  REQUIRE(solver->contacts().size() == 1);
  CHECK_FALSE(solver->contacts()[0].touching);
  CHECK(solver->contacts()[0].point_m == glm::dvec3(1, 0, 0));
  const auto refusing = process_solver(command("status_2"))({});
  try {
    for (int n = 0; n < 8; ++n) refusing->step(std::array{glm::dvec3(0)}, 1e-3);
    FAIL("it should refuse");
  } catch (const SolverError& error) {
    CHECK(error.fault() == SolverFault::bad_input);
  }
}

TEST_CASE("A program that cannot be started says why, and leaves no process") {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& text) {
    const std::string file = folder.write("solver", text);
    fs::permissions(file, fs::perms::owner_all);
    try {
      process_solver({{"./solver"}, folder.path().string()})({});
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const std::string begin = "cannot be started in '" + folder.path().string() + "': ";
  CHECK(error_of("#!/no/such/interpreter\n") == begin + "No such file or directory");
  CHECK(error_of("no program\n") == begin + "Exec format error");
  check_no_child();
  ProcessCommand gone{{"./solver"}, folder.path().string()};
  fs::remove(folder / "solver");  // after the scenario was read
  CHECK_THROWS_WITH(process_solver(gone)({}), "there is no program './solver' that can be run");
  fs::create_directory(folder / "solver");
  CHECK_FALSE(program_of(gone));
}

TEST_CASE("A program is looked for in the folders of PATH that are absolute, in their order") {
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH");
  const auto found = [&](const std::string& folders) {
    setenv("PATH", folders.c_str(), 1);
    const auto program = program_of({{"evenstep-solver"}, "."});
    setenv("PATH", path.c_str(), 1);
    return program.value_or("none");
  };
  for (const char* name : {"a/evenstep-solver", "b/evenstep-solver"})
    fs::permissions(folder.write(name, "#!/bin/sh\n"), fs::perms::owner_all);
  folder.write("not-executable/evenstep-solver", "");
  CHECK(found(folder / "not-executable" + ":" + folder / "b" + ":" + folder / "a") == folder / "b/evenstep-solver");
  CHECK(found(fs::relative(folder.path() / "a").string()) == "none");
  CHECK(found("") == "none");
  unsetenv("PATH");
  CHECK_FALSE(program_of({{"sh"}, "."}));
  setenv("PATH", path.c_str(), 1);
  CHECK(program_of({{"sh"}, "."}));
  CHECK_FALSE(program_of({{""}, "."}));
}

TEST_CASE("A fault of a process, and a force that is no number, end the run with the step and exit code 3") {
  const RunOutcome outcome = run({scene_of_process("exits_at_5")}, builtin());
  CHECK(outcome.exit == ExitCode::run_failed);
  CHECK_THAT(outcome.failure, Contains("exits_at_5', step 5: ended (exit status 7)"));
  const RunOutcome nan = run({scene_of_process("nan"), "run.strategies=[\"direct\"]"}, builtin());
  CHECK(nan.exit == ExitCode::run_failed);
  CHECK_THAT(nan.failure, Contains("step 5"));
  check_no_child();
}

TEST_CASE("A command that cannot be run is an error at its place") {
  for (const auto& [scene, error] : std::vector<std::array<std::string, 2>>{
           {"{ command = [] }", "'command' names no program"},
           {"{ command = \"python3\" }", "must be a list"},
           {"{ command = [3] }", "each a string, not 3"},
           {"{ command = [\"no-such-program\"] }",
            "there is no program 'no-such-program' that can be run; it was looked for in PATH"},
           {"{ command = [\"./no-such-program\"] }", "its path is counted from"},
           {"{ command = [\"sh\"], name = \"mine\" }", "'name' does not go with 'command'"},
           {"{ command = [\"sh\"], library = \"x.so\" }", "'library' does not go with 'command'"},
           {"{ command = [\"sh\"], directory = \"/no/such\" }", "there is no folder '/no/such'"},
           {"{ command = [\"sh\"], answer_within = \"0 s\" }", "out of range"},
           {"{ kind = \"foreign\", name = \"a\", directory = \"/\" }", "'directory' is about a 'command'"},
           {"{ kind = \"foreign\" }", "write name = \"mine\", or library = \"libmine.so\""},
           {"{ kind = \"spring\", command = [\"sh\"] }", "'command' means nothing with kind = \"spring\""}}) {
    INFO(scene);
    CHECK_THAT(errors_of({"scene=" + scene}, builtin()), Contains(error));
  }
}
