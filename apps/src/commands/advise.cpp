#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/advise.h"
#include "evenstep/harness/run_folder.h"
#include "src/commands.h"
#include "src/progress.h"
#include "src/recording_options.h"

namespace evenstep::app {
namespace {

struct AdviseArguments {
  std::string program;
  std::string file;
  std::vector<std::string> set, bandwidths, renderers, what_ifs;
  std::string sampling, step_size, damping, mass, firmware_rate, rate, out;
  std::int64_t threads = 0;
  bool json = false;
  RecordingArguments recording;
};

/// Empty on an error, which is then printed.
std::optional<Rate> rate_between(const std::string& option, const std::string& text, double least_Hz, double most_Hz) {
  const Result<Rate> rate = parse_rate(text);
  const double Hz = rate ? static_cast<double>(rate->num) / static_cast<double>(rate->den) : 0;
  if (rate && Hz >= least_Hz && Hz <= most_Hz) return *rate;
  print({{option, 0, 0,
          rate ? fmt::format("\"{}\" is not between {:g} and {:g} Hz", text, least_Hz, most_Hz) : rate.error()}});
  return std::nullopt;
}

/// The options that are texts with units; false on an error, which is then printed.
bool read_quantities(const AdviseArguments& arguments, AdviseOptions& options) {
  const auto put = [](auto& value, const auto& read) {
    if (read) value = *read;
    return read.has_value();
  };
  if (!arguments.sampling.empty() &&
      !put(options.sampling, option_value("--sampling", parse_period_or_rate(arguments.sampling))))
    return false;
  if (!arguments.step_size.empty() &&
      !put(options.step_size, option_value("--step-size", parse_period_or_rate(arguments.step_size))))
    return false;
  if (!arguments.rate.empty() && !put(options.rate, option_value("--rate", parse_share(arguments.rate)))) return false;
  if (!arguments.damping.empty() &&
      !put(options.damping_N_s_per_m,
           option_value("--damping", parse_above_zero(arguments.damping, Dimension::damping, "N s/m"))))
    return false;
  if (!arguments.mass.empty() &&
      !put(options.mass_kg, option_value("--mass", parse_above_zero(arguments.mass, Dimension::mass, "kg"))))
    return false;
  return arguments.firmware_rate.empty() ||
         put(options.firmware_rate, rate_between("--firmware-rate", arguments.firmware_rate, 100, 100'000));
}

std::optional<AdviseOptions> options_of(const AdviseArguments& arguments) {
  AdviseOptions options;
  if (!read_quantities(arguments, options)) return std::nullopt;
  if (!arguments.bandwidths.empty()) options.bandwidths.clear();
  for (const std::string& text : arguments.bandwidths) {
    const std::optional<Rate> bandwidth = rate_between("--bandwidth", text, 1e-3, 1000);
    if (!bandwidth) return std::nullopt;
    if (std::find(options.bandwidths.begin(), options.bandwidths.end(), *bandwidth) == options.bandwidths.end())
      options.bandwidths.push_back(*bandwidth);
  }
  for (const std::string& text : arguments.what_ifs) {
    if (!options.governors) options.governors.emplace();
    if (text == "none") continue;
    const Result<WhatIf> what_if = parse_what_if(text);
    if (!what_if) {
      print({{"--what-if", 0, 0, what_if.error() + "; \"none\" compares no change of the simulator"}});
      return std::nullopt;
    }
    options.governors->push_back(*what_if);
  }
  if (arguments.renderers.empty()) return options;
  const std::vector<std::string> known = std::move(options.renderers);
  options.renderers.clear();
  for (const std::string& renderer : arguments.renderers) {
    if (std::find(known.begin(), known.end(), renderer) == known.end()) {
      print({{"--renderer", 0, 0, fmt::format("\"{}\" is none of {}", renderer, fmt::join(known, ", "))}});
      return std::nullopt;
    }
    if (std::find(options.renderers.begin(), options.renderers.end(), renderer) == options.renderers.end())
      options.renderers.push_back(renderer);
  }
  return options;
}

AdviseResult advised(const AdviseArguments& arguments, const AdviseOptions& options, const RecordingOptions& recording,
                     const Registry& registry) {
  const auto refused = [](const std::string& where, const std::string& why) -> AdviseResult {
    return {{}, {}, {{where, 0, 0, why}}, false};
  };
  if (std::filesystem::path(arguments.file).extension() != ".toml") {
    if (arguments.set.empty()) return advise_recording(arguments.file, options, recording);
    return refused("--set", "belongs to a scenario (*.toml); a recording has no keys to set");
  }
  if (!arguments.sampling.empty())
    return refused(arguments.file, "--sampling belongs to a recording; a scenario says so in [[device]]");
  if (!arguments.step_size.empty())
    return refused(arguments.file, "--step-size belongs to a recording; a scenario says so in [scene] step_size");
  const ReadResult read = read_scenario(arguments.file, {arguments.set, std::nullopt, registry});
  if (!read) return {{}, {}, read.error(), false};
  return advise_scenario(*read, options);
}

std::string folder_for(const AdviseArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  return (default_place() / (std::filesystem::path(arguments.file).stem().string() + "-advise")).string();
}

/// As wide as the terminal that shows it, within reason.
std::size_t columns_of_output() {
  constexpr std::size_t kFewest = 60;
  winsize size{};
  if (!isatty(STDOUT_FILENO) || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kAdviceColumns;
  return std::clamp<std::size_t>(size.ws_col, kFewest, kAdviceColumns);
}

/// The command that does this again.
std::string again(const AdviseArguments& arguments) {
  std::string command = fmt::format("{} advise {}", arguments.program, shell_file(arguments.file));
  const auto option = [&](const char* name, const std::string& value) {
    if (!value.empty()) command += fmt::format(" {} {}", name, shell_word(value));
  };
  for (const std::string& set : arguments.set) option("--set", set);
  option("--sampling", arguments.sampling);
  option("--step-size", arguments.step_size);
  for (const std::string& bandwidth : arguments.bandwidths) option("--bandwidth", bandwidth);
  for (const std::string& renderer : arguments.renderers) option("--renderer", renderer);
  for (const std::string& what_if : arguments.what_ifs) option("--what-if", what_if);
  option("--rate", arguments.rate);
  option("--damping", arguments.damping);
  option("--mass", arguments.mass);
  option("--firmware-rate", arguments.firmware_rate);
  option("--out", arguments.out);
  return command + recording_words(arguments.recording);
}

ExitCode give_advice(const AdviseArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  std::optional<AdviseOptions> options = options_of(arguments);
  if (!options) return ExitCode::usage;
  const std::optional<RecordingOptions> recording = recording_options(arguments.recording);
  if (!recording) return ExitCode::usage;
  const std::string folder = folder_for(arguments);
  if (const std::string objection = run_folder_objection(folder, kAdviceFile); !objection.empty()) {
    spdlog::error("error: {}", objection);
    return ExitCode::run_failed;
  }
  AdviseResult result;
  {
    Progress progress(isatty(STDERR_FILENO));
    options->threads = static_cast<int>(arguments.threads);
    options->interrupted = &interrupted;
    options->progress = [&](double fraction) { progress.update("advise", fraction); };
    result = advised(arguments, *options, *recording, registry);
  }
  if (!result.errors.empty()) {
    print(result.errors);
    return ExitCode::usage;
  }
  if (!result.damage.empty()) spdlog::warn("{}: {}", arguments.file, result.damage);
  if (result.interrupted) return ExitCode::interrupted;
  fmt::print("{}", arguments.json ? advice_json(result.record) : advice_text(result.record, columns_of_output()));
  if (const std::string error = write_advice_folder(folder, result, again(arguments)); !error.empty()) {
    spdlog::error("error: {}", error);
    return ExitCode::run_failed;
  }
  const AdviceChoice* const use = choice_to_use(result.record, true);
  if (!arguments.json)
    fmt::print(
        "\nscenarios, figure and report in {}; for example: {} run {}\n", folder, arguments.program,
        shell_file((std::filesystem::path(folder) / choice_file(use ? *use : result.record.choices.front())).string()));
  return ExitCode::pass;
}

}  // namespace

void add_advise(Commands& commands) {
  auto [command, arguments] = commands.add<AdviseArguments>(
      "advise", "what a timing can have: map, latency and renderer, what each costs, and which are Pareto-optimal",
      give_advice);
  arguments.program = commands.program();
  command.operand("file", arguments.file,
                  "a scenario, or a recording: timing.csv, a list of steps begin_ns,end_ns, or a profiler's file");
  command.repeated("--set", arguments.set, "path=value, overrides the scenario");
  command.option("--sampling", arguments.sampling,
                 "of a recording: the device's period or rate, \"1 ms\" (default) or \"8 kHz\"");
  command.option(
      "--step-size", arguments.step_size,
      "of a recording: what a step simulates, \"11.1 ms\" or \"90 Hz\": if steps follow that clock, clocked is a choice");
  command.repeated("--bandwidth", arguments.bandwidths, "of phase_locked, each a choice; default \"1 Hz\" and \"2 Hz\"");
  command.repeated("--renderer", arguments.renderers,
                   "hold, linear, local or device_spring, each a choice; default all (docs/forces/stiffness.md)");
  command.repeated(
      "--what-if", arguments.what_ifs,
      "a change of the simulator, each a choice: \"spread\", \"split 2\", \"budget 20 ms\", \"pace 90 %\", \"own-lane\"; "
      "default such ones; none");
  command.option("--rate", arguments.rate,
                 "of segments that may be late in the second choice of latency, \"1 %\" (default)");
  command.option("--damping", arguments.damping, "of hand and device, \"1 N s/m\" (default)");
  command.option("--mass", arguments.mass, "of hand and device, \"0.2 kg\" (default)");
  command.option("--firmware-rate", arguments.firmware_rate,
                 "at which a device renders springs by itself, \"4 kHz\" (default)");
  command.option("--out,-o", arguments.out,
                 "folder for the scenarios, advice.json, the figure and the report; default runs/<name>-advise");
  command.option("--threads", arguments.threads, Range{0, 1024}, "choices at a time; 0 (default): one per core");
  command.flag("--json", arguments.json, "advice.json instead of the table");
  add_recording_options(command, arguments.recording);
}

}  // namespace evenstep::app
