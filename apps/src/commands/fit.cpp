#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "evenstep/campaigns/fit_report.h"
#include "src/commands.h"
#include "src/recording_options.h"

namespace evenstep::app {

namespace {

struct FitArguments {
  std::string file;
  bool json = false;
  RecordingArguments recording;
};

ExitCode fit(const FitArguments& arguments, const std::atomic<bool>&) {
  const std::string& file = arguments.file;
  const std::optional<RecordingOptions> options = recording_options(arguments.recording);
  if (!options) return ExitCode::usage;
  std::string damage;
  const Recording csv = read_recording(file, *options, false, &damage);
  if (!csv) {
    print(csv.error());
    return ExitCode::usage;
  }
  if (!damage.empty()) spdlog::warn("{}: {}", file, damage);
  const std::string objection = fit_objection(*csv);
  if (!objection.empty()) {
    print({{file, 0, 0, objection}});
    return ExitCode::usage;
  }
  const TimingFit fitted = fit_timing(*csv);
  const FitComparison comparison = compare(fitted, *csv);
  fmt::print("{}", arguments.json ? fit_json(fitted, comparison, file) : fit_toml(fitted, comparison, file));
  return ExitCode::pass;
}

}  // namespace

void add_fit(Commands& commands) {
  auto [command, arguments] = commands.add<FitArguments>(
      "fit", "propose a [timing] table for a recording, and say whether it can stand for the recording", fit);
  command.operand("timing.csv", arguments.file, "segment,kind,index,begin_ns,end_ns; or a profiler's file");
  command.flag("--json", arguments.json, "the numbers instead of the table");
  add_recording_options(command, arguments.recording);
}

}  // namespace evenstep::app
