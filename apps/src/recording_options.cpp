#include "recording_options.h"

#include <fmt/format.h>

#include "commands.h"
#include "evenstep/apps/shell.h"
#include "evenstep/text/quantity.h"

namespace evenstep::app {

void add_recording_options(Command& command, RecordingArguments& arguments) {
  command.option("--segment", arguments.segment,
                 "of a profiler's file: names that begin a segment, as an extended regular expression");
  command.option("--visualization", arguments.visualization, "of a profiler's file: names that are visualizations");
  command.option("--step", arguments.step, "of a profiler's file: names that are steps");
  command.option("--step-begin", arguments.step_begin,
                 "of a profiler's file: names that a step of several parts begins with");
  std::vector<std::string> presets;
  for (const RolePreset& preset : role_presets()) presets.emplace_back(preset.name);
  command.option("--preset", arguments.preset, presets, "of a profiler's file: the names that this engine gives to these");
  command.option("--process", arguments.process, "of a profiler's file with several processes: which of them");
  command.option("--steps", arguments.steps, Range{1, 10'000}, "of a recording of pictures: so many steps after each");
  command.option("--step-time", arguments.step_time, "of a recording of pictures: how long a step takes, \"1.2 ms\"");
  command.option("--format", arguments.format, profile_formats(), "of a profiler's file, if its begin does not tell");
  command.option("--header", arguments.header, Range{1, 100'000},
                 "of a CSV: the line that names its columns, if its cells do not tell");
  command.option("--name", arguments.columns.name, "of a CSV with other columns: the one with the name");
  command.option("--begin", arguments.columns.begin, "of a CSV with other columns: the one with the begin");
  command.option("--end", arguments.columns.end, "of a CSV with other columns: the one with the end");
  command.option("--duration", arguments.columns.duration, "of a CSV with other columns: in place of the end, the length");
  command.option("--unit", arguments.columns.unit, {"ns", "us", "ms", "s"}, "of a CSV with other columns: of its times");
}

std::optional<RecordingOptions> recording_options(const RecordingArguments& arguments) {
  RecordingOptions options;
  options.roles = {arguments.segment,
                   arguments.visualization,
                   arguments.step,
                   arguments.step_begin,
                   arguments.process,
                   arguments.steps,
                   {}};
  options.preset = arguments.preset;
  options.profile = {arguments.format, arguments.columns, arguments.header};
  if ((arguments.steps == 0) != arguments.step_time.empty()) {
    print({{"--steps", 0, 0, "and --step-time go together: so many steps, each so long"}});
    return std::nullopt;
  }
  if (arguments.step_time.empty()) return options;
  const Result<Duration> time = parse_duration(arguments.step_time);
  if (time && time->ns > 0) {
    options.roles.step_time = *time;
    return options;
  }
  print({{"--step-time", 0, 0, time ? "must be above 0 s" : time.error()}});
  return std::nullopt;
}

std::string recording_words(const RecordingArguments& arguments) {
  std::string words;
  const auto option = [&](const char* name, const std::string& value) {
    if (!value.empty()) words += fmt::format(" {} {}", name, shell_word(value));
  };
  option("--segment", arguments.segment);
  option("--visualization", arguments.visualization);
  option("--step", arguments.step);
  option("--step-begin", arguments.step_begin);
  option("--preset", arguments.preset);
  option("--process", arguments.process);
  option("--steps", arguments.steps > 0 ? fmt::format("{}", arguments.steps) : "");
  option("--step-time", arguments.step_time);
  option("--format", arguments.format);
  option("--header", arguments.header > 0 ? fmt::format("{}", arguments.header) : "");
  option("--name", arguments.columns.name);
  option("--begin", arguments.columns.begin);
  option("--end", arguments.columns.end);
  option("--duration", arguments.columns.duration);
  option("--unit", arguments.columns.unit);
  return words;
}

}  // namespace evenstep::app
