#include "evenstep/apps/command_line.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>
#include <vector>

#include "commands.h"
#include "evenstep/apps/shell.h"
#include "output.h"

namespace evenstep {
namespace app {

// Each command is defined in a file of its own.
using AddCommand = void(Commands&);
AddCommand add_run, add_check, add_devices, add_list, add_study, add_record, add_replay, add_import, add_fit, add_size,
    add_advise, add_sweep, add_catalogue, add_merge, add_shrink, add_diff, add_compare, add_index, add_init, add_schema,
    add_shell_texts;
/// In the order of --help.
struct Group {
  const char* name;
  std::vector<AddCommand*> commands;
};
const std::array kGroups = std::to_array<Group>({{"Test", {add_run, add_check, add_diff, add_compare, add_index}},
                                                 {"Choose", {add_size, add_advise, add_fit, add_study}},
                                                 {"Record", {add_devices, add_record, add_import, add_replay}},
                                                 {"Many runs", {add_sweep, add_catalogue, add_merge, add_shrink}},
                                                 {"Set up", {add_init, add_list, add_schema, add_shell_texts}}});

}  // namespace app

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

/// The first signal asks the run to end in order; a second one ends the process.
void on_signal(int signal) {
  if (interrupted.exchange(true)) std::signal(signal, SIG_DFL), std::raise(signal);
}

void take_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, on_signal);
  // A write that fails is an error of that write; it must not end a run that drives a device.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

/// Whether the command is asked for its text alone: a reader that closes the pipe has read as much of it as it wants.
bool only_prints(std::string_view command) {
  constexpr std::array kSuch =
      std::to_array<std::string_view>({"list", "schema", "completion", "manual", "help", "--help", "-h", "--version"});
  return std::find(kSuch.begin(), kSuch.end(), command) != kSuch.end();
}

/// Does what the call asks for.
ExitCode run_command(app::Commands& commands, int argc, char** argv) {
  try {
    const auto asked = commands.parse(argc, argv);
    if (const auto* const printed = std::get_if<ExitCode>(&asked)) return *printed;
    return std::get<std::function<ExitCode()>>(asked)();
  } catch (const std::exception& error) {
    // What cannot be printed is said at the end, in one way for all commands.
    if (!std::ferror(stdout)) spdlog::error("evenstep: error: {}", error.what());
    return ExitCode::run_failed;
  }
}

}  // namespace

int command_line(int argc, char** argv, const Registry& registry) {
  // run.sh says how it was called, because nobody starts the program in its build folder.
  const std::string program = program_words(std::getenv("EVENSTEP_CALLED_AS"), argc > 0 ? argv[0] : nullptr);
  app::prepare_output(program);
  take_signals();

  app::Commands commands(interrupted, registry, program);
  for (const app::Group& group : app::kGroups) {
    commands.begin_group(group.name);
    for (app::AddCommand* const add : group.commands) add(commands);
  }
  const ExitCode code = run_command(commands, argc, argv);
  return static_cast<int>(app::finish_output(code, only_prints(argc > 1 ? argv[1] : "")));
}

}  // namespace evenstep
