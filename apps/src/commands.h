#pragma once
/// What the commands have in common. Each command is one file, which adds a subcommand with its options and sets the
/// function to run if this command was given. Results go to stdout, everything else to stderr (spdlog).

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "evenstep/harness/run.h"
#include "evenstep/sim/solver.h"

namespace evenstep::app {

/// The scenario files, each once: files as given, and for a folder all *.toml below it in order of path, but not those in
/// run folders. If a folder has none, prints an error and returns nullopt.
std::optional<std::vector<std::string>> scenario_files(const std::vector<std::string>& paths);
/// A path as typed; if nothing is there and it is not absolute, the same path among the files that were installed with the
/// program (share/evenstep beside the folder that the program is in), if there is such a file.
std::string here_or_installed(const std::string& path);
void print(const std::vector<Diagnostic>& errors);
/// Prints why and returns false if it cannot be written.
bool write_text(const std::string& path, const std::string& text);
bool write_text(const std::string& path, const std::function<void(std::ostream&)>& write);
/// Where run folders go without --out: to runs/ in the working directory, or, if that cannot be written, to a folder of this
/// user among the temporary files.
std::filesystem::path default_place();
/// Lines about the stability of a tissue: method and substeps; longest stable substep, largest stiffness and the particle
/// that sets them. Empty for a spring. Throws SolverError for a scene that no solver accepts.
std::string stability_lines(const Scenario& scenario);
/// The last of them, if the scene is above its limit; empty otherwise.
std::string instability_line(const Scenario& scenario);
/// What such a SolverError says, at the place of the scene in the file.
Diagnostic refusal_of(const Scenario& scenario, const SolverError& error);
/// Lines with alpha, alpha* and the laws for the devices that render locally, per strategy; empty if there is none.
std::string rendering_lines(const Scenario& scenario);

}  // namespace evenstep::app
