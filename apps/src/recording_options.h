#pragma once
/// The options of the commands that take a recording: what the names in a profiler's file stand for, and what a recording
/// does not say.

#include <optional>
#include <string>

#include "command.h"
#include "evenstep/recordings/recording.h"
#include "evenstep/text/quantity.h"
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

/// A period of at most 1 s or a rate; empty on an error of this option, which is then printed.
std::optional<Rate> period_or_rate(const std::string& option, const std::string& text);
std::optional<Rate> sampling_rate(const std::string& text);
/// Between 0 and 1; empty on an error, which is then printed.
std::optional<double> share(const std::string& option, const std::string& text);
/// Above 0; empty on an error, which is then printed.
std::optional<double> above_zero(const std::string& option, const std::string& text, Dimension dimension, const char* unit);

}  // namespace evenstep::app
