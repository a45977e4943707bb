#pragma once
/// A recording of step timing from any file: a timing.csv, or what a profiler wrote, with roles for its names.

#include <string>
#include <vector>

#include "evenstep/recordings/roles.h"

namespace evenstep {

struct RecordingOptions {
  Roles roles;
  ProfileOptions profile;
};

/// Whether the file begins like a timing.csv or like a plain list of steps; roles have no meaning for such a file.
bool is_timing_csv(const std::string& path);

using Recording = Result<std::vector<SegmentTiming>, std::vector<Diagnostic>>;
/// A timing.csv (timing_csv.h; also a plain list of steps, if `steps_too`), or else a profiler's file with roles.
Recording read_recording(const std::string& path, const RecordingOptions& options = {}, bool steps_too = false);

}  // namespace evenstep
