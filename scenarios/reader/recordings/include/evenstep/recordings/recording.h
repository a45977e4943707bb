#pragma once
/// A recording of step timing from any file: a timing.csv, or what a profiler wrote, with roles for its names.

#include <string>
#include <vector>

#include "evenstep/recordings/roles.h"

namespace evenstep {

struct RecordingOptions {
  Roles roles;
  ProfileOptions profile;
  std::string preset;  ///< one of role_presets(), for the roles that are not given; empty: none
};

/// Whether the file begins like a timing.csv or like a plain list of steps; roles have no meaning for such a file.
bool is_timing_csv(const std::string& path);
/// Whether it is such a list.
bool is_step_list(const std::string& path);

using Recording = Result<std::vector<SegmentTiming>, std::vector<Diagnostic>>;
/// A timing.csv, or a plain list of steps (timing_csv.h), or else a profiler's file with roles. A list gets the segments of
/// the cycle found in it (step_list.h), or, if `as_one_segment`, a single one. `damage` gets AssignedRoles::damage() of a
/// profiler's file, which whoever uses the recording must be told.
Recording read_recording(const std::string& path, const RecordingOptions& options = {}, bool as_one_segment = false,
                         std::string* damage = nullptr);

}  // namespace evenstep
