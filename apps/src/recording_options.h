#pragma once
/// The options of all commands that take a profiler's file: which of its names are what.

#include <optional>
#include <string>

#include "command.h"
#include "evenstep/recordings/recording.h"

namespace evenstep::app {

struct RecordingArguments {
  std::string segment, visualization, step, step_begin, process, step_time, format;
  std::int64_t steps = 0;
  CsvColumns columns;
};

void add_recording_options(Command& command, RecordingArguments& arguments);
/// nullopt after an error, which is then printed.
std::optional<RecordingOptions> recording_options(const RecordingArguments& arguments);

}  // namespace evenstep::app
