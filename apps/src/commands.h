#pragma once
/// What the commands share. A command is one file: it adds a subcommand with its options, and sets what runs when it is the one
/// that was given. Results go to stdout, everything else to stderr (spdlog).

#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evenstep/harness/run.h"

namespace evenstep::app {

/// One call of the program.
struct Invocation {
  const std::atomic<bool>& interrupted;         ///< by a signal
  std::function<ExitCode()> chosen = nullptr;   ///< what the command that was given does; set while arguments are parsed
};

/// A subcommand whose options are in `Arguments`, run by `run(arguments, interrupted)`.
template <class Arguments, class Run>
std::pair<CLI::App*, std::shared_ptr<Arguments>> add_command(CLI::App& cli, Invocation& invocation, const std::string& name,
                                                             const std::string& meaning, Run run) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* const command = cli.add_subcommand(name, meaning);
  command->callback([&invocation, arguments, run] {
    invocation.chosen = [&invocation, arguments, run] { return run(*arguments, invocation.interrupted); };
  });
  return {command, arguments};
}

/// --set, any number of times, each with one value.
inline CLI::Option* add_set(CLI::App& command, std::vector<std::string>& set, const std::string& meaning) {
  return command.add_option("--set", set, meaning)->expected(1)->allow_extra_args(false)->take_all();
}

/// Files as given, folders as all *.toml below them in order of path. Prints an error and returns nullopt if one is not
/// there.
std::optional<std::vector<std::string>> scenario_files(const std::vector<std::string>& paths);
void print(const std::vector<Diagnostic>& errors);
/// Of run folders without --out: runs/ here; where this folder cannot be written, one of the user's own among the temporary
/// files.
std::filesystem::path default_place();
/// Of a tissue: method and substeps; longest stable substep, largest stiffness and the particle that sets them. Empty for a
/// spring. Throws SolverError for a scene that no solver takes.
std::string stability_lines(const Scenario& scenario);
/// alpha, alpha* and the laws of the devices that render locally, per strategy; empty without one.
std::string rendering_lines(const Scenario& scenario);

}  // namespace evenstep::app
