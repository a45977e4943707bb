#pragma once
/// The commands of the command line, one file each. Results go to stdout, everything else to stderr (spdlog).

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/harness/run.h"

namespace evenstep::app {

struct RunArguments {
  std::vector<std::string> paths;
  std::string clock = "virtual";
  std::optional<std::uint64_t> seed;
  std::vector<std::string> set;
  std::string out;
  bool repeat = false;
  std::optional<std::uint64_t> permute_ties;
  int threads = 0;
  bool json = false;
  std::vector<std::string> devices;  ///< NAME=PATH or PATH
  bool forces = false;
  bool include_long = false;  ///< also what carries the tag "long" and is only found in a folder
};

struct StudyArguments {
  std::string file;
  std::vector<std::string> set;
  std::string out, advise;
  bool json = false;
};

ExitCode run(const RunArguments& arguments, const std::atomic<bool>& interrupted);
/// Exit 1 where nothing meets what --advise asks for.
ExitCode study(const StudyArguments& arguments, const std::atomic<bool>& interrupted);
ExitCode check(const std::vector<std::string>& paths, const std::vector<std::string>& set);
ExitCode devices(bool json);
ExitCode list(const std::vector<std::string>& paths);
struct SizeArguments {
  std::string file;
  std::vector<std::string> set;
  std::string sampling, emission, damping, rate, confidence;
  bool json = false;
};
struct SweepArguments {
  std::string file;
  std::vector<std::string> set;
  std::string shard, out;
  int threads = 0;
  std::optional<std::int64_t> stop_after;
  bool resume = false;
  bool json = false;
};
ExitCode sweep(const SweepArguments& arguments, const std::atomic<bool>& interrupted);
struct MergeArguments {
  std::vector<std::string> parts;
  std::string out;
  bool json = false;
};
ExitCode merge(const MergeArguments& arguments);
struct ShrinkArguments {
  std::string file;
  std::vector<std::string> set;
  std::optional<std::uint64_t> seed;
  std::optional<std::int64_t> expect;
  std::int64_t max_runs = 2000;
  std::string out;
};
ExitCode shrink(const ShrinkArguments& arguments, const std::atomic<bool>& interrupted);
ExitCode size(const SizeArguments& arguments);
ExitCode fit(const std::string& file, bool json);
ExitCode diff(const std::string& a, const std::string& b);

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
