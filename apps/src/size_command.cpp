#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "commands.h"
#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/pages/campaign_pages.h"
#include "evenstep/recordings/timing_csv.h"
#include "recording_options.h"

namespace evenstep::app {
namespace {

struct SizeArguments {
  std::string program;
  std::string file;
  std::vector<std::string> set;
  std::string sampling, emission, damping, rate, confidence, figure, report, timing;
  bool json = false, other_maps = false;
  RecordingArguments recording;
};

/// A period or a rate; empty on an error, which is then printed.
std::optional<Rate> sampling_rate(const std::string& text) {
  const Result<Rate> rate = parse_rate(text);
  if (rate) return *rate;
  const Result<Duration> period = parse_duration(text);
  if (period && period->ns > 0 && period->ns <= 1'000'000'000) return Rate{1'000'000'000, period->ns};
  print({{"--sampling", 0, 0,
          fmt::format("\"{}\" is no period of at most 1 s, such as \"1 ms\", and no rate, such as \"1 kHz\"", text)}});
  return std::nullopt;
}

/// Between 0 and 1; empty on an error, which is then printed.
std::optional<double> share(const std::string& option, const std::string& text) {
  const Result<double> parsed = parse_si(text, Dimension::ratio);
  if (parsed && *parsed > 0 && *parsed < 1) return *parsed;
  print({{option, 0, 0, parsed ? fmt::format("\"{}\" must be above 0 % and below 100 %", text) : parsed.error()}});
  return std::nullopt;
}

/// --rate and --confidence; false on an error, which is then printed.
bool read_rate(const SizeArguments& arguments, SizeOptions& options) {
  if (arguments.rate.empty() && !arguments.confidence.empty()) {
    print({{"--confidence", 0, 0, "goes with --rate, which says of what; for example --rate \"0.1 %\""}});
    return false;
  }
  if (arguments.rate.empty()) return true;
  options.rate = share("--rate", arguments.rate);
  if (!options.rate || arguments.confidence.empty()) return options.rate.has_value();
  const std::optional<double> confidence = share("--confidence", arguments.confidence);
  options.confidence = confidence.value_or(options.confidence);
  return confidence.has_value();
}

std::optional<SizeOptions> options_of(const SizeArguments& arguments) {
  SizeOptions options;
  if (!arguments.sampling.empty()) {
    const std::optional<Rate> rate = sampling_rate(arguments.sampling);
    if (!rate) return std::nullopt;
    options.sampling = *rate;
  }
  options.other_maps = arguments.other_maps;
  if (arguments.emission == "linear") options.emission = Emission::linear;
  if (!arguments.damping.empty()) {
    const Result<double> damping = parse_si(arguments.damping, Dimension::damping);
    if (!damping || *damping <= 0) {
      print({{"--damping", 0, 0, damping ? "must be above 0 N s/m" : damping.error()}});
      return std::nullopt;
    }
    options.damping_N_s_per_m = *damping;
  }
  if (!read_rate(arguments, options)) return std::nullopt;
  return options;
}

SizeResult sized(const SizeArguments& arguments, const SizeOptions& options, const RecordingOptions& recording,
                 const Registry& registry) {
  if (std::filesystem::path(arguments.file).extension() != ".toml") {
    if (arguments.set.empty()) return size_recording(arguments.file, options, recording);
    return {{}, {}, {{"--set", 0, 0, "belongs to a scenario (*.toml); a recording has no keys to set"}}};
  }
  if (!arguments.sampling.empty() || !arguments.emission.empty())
    return {{},
            {},
            {{arguments.file, 0, 0, "--sampling and --emission belong to a recording; a scenario says so in [[device]]"}}};
  const ReadResult read = read_scenario(arguments.file, {arguments.set, std::nullopt, registry});
  if (!read) return {{}, {}, read.error()};
  return size_scenario(*read, options);
}

/// False on an error, which is then printed.
bool write_figure(const std::string& path, const SizeRecord& record) {
  const std::string figure = size_svg(record);
  if (figure.empty()) {
    print({{path, 0, 0, "there is no curve to draw: too many steps, or none; size a part of the recording"}});
    return false;
  }
  return write_text(path, figure);
}

/// The command that does this again.
std::string again(const SizeArguments& arguments) {
  std::string command = fmt::format("{} size {}", arguments.program, shell_file(arguments.file));
  for (const std::string& set : arguments.set) command += " --set " + shell_word(set);
  const auto option = [&](const char* name, const std::string& value) {
    if (!value.empty()) command += fmt::format(" {} {}", name, shell_word(value));
  };
  option("--sampling", arguments.sampling);
  option("--emission", arguments.emission);
  option("--damping", arguments.damping);
  option("--rate", arguments.rate);
  option("--confidence", arguments.confidence);
  const RecordingArguments& recording = arguments.recording;
  option("--segment", recording.segment);
  option("--visualization", recording.visualization);
  option("--step", recording.step);
  option("--step-begin", recording.step_begin);
  option("--process", recording.process);
  option("--steps", recording.steps > 0 ? fmt::format("{}", recording.steps) : "");
  option("--step-time", recording.step_time);
  option("--format", recording.format);
  option("--name", recording.columns.name);
  option("--begin", recording.columns.begin);
  option("--end", recording.columns.end);
  option("--duration", recording.columns.duration);
  option("--unit", recording.columns.unit);
  if (arguments.other_maps) command += " --other-maps";
  option("--timing", arguments.timing);
  option("--report", arguments.report);
  return command;
}

/// False on an error, which is then printed.
bool write_report(const SizeArguments& arguments, const SizeRecord& record) {
  return arguments.report.empty() || write_text(arguments.report, size_page(record, again(arguments)));
}

/// False on an error, which is then printed.
bool write_timing(const std::string& path, SizeResult& result) {
  if (!write_text(path, format_timing_csv(result.segments))) return false;
  result.record.trace = path;
  result.record.trace_roles.clear();
  return true;
}

ExitCode size(const SizeArguments& arguments, const std::atomic<bool>&, const Registry& registry) {
  const std::optional<SizeOptions> options = options_of(arguments);
  if (!options) return ExitCode::usage;
  const std::optional<RecordingOptions> recording = recording_options(arguments.recording);
  if (!recording) return ExitCode::usage;
  SizeResult result = sized(arguments, *options, *recording, registry);
  if (!result.errors.empty()) {
    print(result.errors);
    return ExitCode::usage;
  }
  if (!arguments.figure.empty() && !write_figure(arguments.figure, result.record)) return ExitCode::usage;
  if (!arguments.timing.empty() && !write_timing(arguments.timing, result)) return ExitCode::usage;
  if (!write_report(arguments, result.record)) return ExitCode::usage;
  fmt::print("{}", arguments.json ? size_json(result.record) : size_text(result.record));
  return ExitCode::pass;
}

}  // namespace

void add_size(Commands& commands) {
  auto [command, arguments] = commands.add<SizeArguments>(
      "size", "the least latency, lead and rings for which nothing underruns, what sets them, and what they cost", size);
  arguments.program = commands.program();
  command.operand("file", arguments.file,
                  "a scenario, or a recording: timing.csv, a list of steps begin_ns,end_ns, or a profiler's file");
  command.repeated("--set", arguments.set, "path=value, overrides the scenario");
  command.option("--sampling", arguments.sampling,
                 "of a recording: the device's period or rate, \"1 ms\" (default) or \"8 kHz\"");
  command.option("--emission", arguments.emission, {"hold", "linear"},
                 "of a recording: how its forces are played, hold (default) or linear");
  command.option("--damping", arguments.damping, "of hand and device, \"1 N s/m\" (default), for the loop's stiffness");
  command.option("--rate", arguments.rate, "of segments that may underrun, \"0.1 %\": what latency that takes, too");
  command.option("--confidence", arguments.confidence, "how sure the rate is to be, \"95 %\" (default)");
  command.option("--figure", arguments.figure, "file.svg: latency against velocity jump, of any path and of the maps");
  command.option("--report", arguments.report, "file.html: all of it as one page");
  command.option("--timing", arguments.timing, "file.csv: the segments that were sized, for [timing] trace");
  command.flag("--other-maps", arguments.other_maps,
               "also JACK's loop and liblsl's line, for comparison (docs/alternatives.md)");
  command.flag("--json", arguments.json, "the numbers instead of the table");
  add_recording_options(command, arguments.recording);
}

}  // namespace evenstep::app
