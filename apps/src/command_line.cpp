#include "evenstep/apps/command_line.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <system_error>

#include "commands.h"
#include "evenstep/harness/version.h"
#include "evenstep/text/suggest.h"

namespace evenstep {
namespace app {

// Each command is defined in a file of its own.
using AddCommand = void(CLI::App&, Invocation&);
AddCommand add_run, add_check, add_devices, add_list, add_study, add_fit, add_size, add_sweep, add_merge, add_shrink,
    add_diff, add_schema;
/// In the order of --help.
constexpr AddCommand* kCommands[] = {add_run,  add_check, add_devices, add_list,   add_study, add_fit,
                                     add_size, add_sweep, add_merge,   add_shrink, add_diff,  add_schema};

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
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace

namespace {

using Names = std::vector<std::string_view>;

/// For a call that was not understood: the first word that is no command, or the first option that its command does not
/// have, with the nearest one. Empty if the fault is another one.
std::string mistyped(const CLI::App& cli, const std::vector<std::string>& words) {
  if (words.empty()) return {};
  std::vector<std::string> texts;
  const CLI::App* command = nullptr;
  for (const CLI::App* one : cli.get_subcommands(nullptr)) {
    texts.push_back(one->get_name());
    if (texts.back() == words[0]) command = one;
  }
  if (command == nullptr) {
    if (words[0].starts_with('-')) return {};
    return "unknown command '" + words[0] + "'" + internal::suggestion(words[0], Names(texts.begin(), texts.end()));
  }
  texts.clear();
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_lnames()) texts.push_back("--" + name);
  }
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || name == "--" || std::find(texts.begin(), texts.end(), name) != texts.end()) continue;
    return "unknown option '" + name + "' of " + words[0] + internal::suggestion(name, Names(texts.begin(), texts.end()));
  }
  return {};
}

/// "help" and "help COMMAND" are --help and COMMAND --help.
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.empty() || words[0] != "help") return words;
  words.erase(words.begin());
  words.emplace_back("--help");
  return words;
}

}  // namespace

int command_line(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_logger_mt("evenstep"));
  spdlog::set_pattern("%v");
  take_signals();

  CLI::App cli{"Deterministic tests of haptic interaction under irregular simulation steps."};
  cli.name("evenstep");
  cli.set_version_flag("--version", std::string("evenstep ") + kVersion);
  cli.require_subcommand(1);
  cli.footer(
      "Exit: 0 pass, 1 expectation failed or no verdict, 2 usage or scenario error, 3 run failed, 4 not reproducible, 130 "
      "interrupted.");
  app::Invocation invocation{interrupted};
  for (app::AddCommand* const add : app::kCommands) add(cli, invocation);

  const std::vector<std::string> words = words_of(argc, argv);
  try {
    cli.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes them from the back
  } catch (const CLI::ParseError& error) {
    const bool asked_for_help = error.get_exit_code() == 0;
    const std::string mistake = asked_for_help ? "" : mistyped(cli, words);
    if (mistake.empty())
      cli.exit(error);
    else
      spdlog::error("evenstep: error: {}", mistake);
    return asked_for_help ? 0 : static_cast<int>(ExitCode::usage);
  }
  // Whoever reads as much as they want of a list, and then closes the pipe, has what they want.
  const bool only_lists = cli.got_subcommand("list") || cli.got_subcommand("schema");
  const int closed_pipe = static_cast<int>(only_lists ? ExitCode::pass : ExitCode::run_failed);
  try {
    const ExitCode code = invocation.chosen();
    if (std::fflush(stdout) != 0) return closed_pipe;
    return static_cast<int>(code);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::broken_pipe) return closed_pipe;
    spdlog::error("evenstep: error: {}", error.what());
    return static_cast<int>(ExitCode::run_failed);
  } catch (const std::exception& error) {
    spdlog::error("evenstep: error: {}", error.what());
    return static_cast<int>(ExitCode::run_failed);
  }
}

}  // namespace evenstep
