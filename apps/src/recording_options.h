#pragma once
/// The options of the commands that take a recording: what the names in a profiler's file stand for, and what a recording
/// does not say.

#include <optional>
#include <string>

#include "command.h"
#include "evenstep/recordings/recording.h"
#include "evenstep/text/option_values.h"
#include "evenstep/time/time.h"

namespace evenstep::app {

struct RecordingArguments {
  std::string segment, visualization, step, step_begin, process, step_time, format, preset;
  std::int64_t steps = 0, header = 0;
  CsvColumns columns;
};

void add_recording_options(Command& command, RecordingArguments& arguments);
/// nullopt after an error, which is then printed.
std::optional<RecordingOptions> recording_options(const RecordingArguments& arguments);
/// The options that were given, as they are typed, each after a blank.
std::string recording_words(const RecordingArguments& arguments);

/// The value of this option; empty on an error, which is then printed. Parsers: evenstep/text/option_values.h.
template <class Value>
std::optional<Value> option_value(const std::string& option, const Result<Value>& parsed) {
  if (parsed) return *parsed;
  print({{option, 0, 0, parsed.error()}});
  return std::nullopt;
}

}  // namespace evenstep::app
