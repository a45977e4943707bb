#pragma once
/// `evenstep size`: the least latency, lead and rings with which nothing underruns for a given timing. Only the maps are run
/// (docs/sizing.md).

#include <optional>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/recordings/recording.h"
#include "evenstep/reports/size_record.h"
#include "evenstep/text/diagnostic.h"

namespace evenstep {

struct SizeOptions {
  /// The rate of the device, which a recording does not contain; it has a tick where the first step begins.
  Rate sampling{1000, 1};
  Emission emission = Emission::hold;  ///< a recording does not contain this either
  std::optional<double> rate;          ///< share of segments that may underrun, in (0, 1); its latency is found as well
  double confidence = 0.95;            ///< confidence of the bound on the rate, in (0, 1)
  double damping_N_s_per_m = 1;        ///< of hand and device, for the stiffness that the closed loop allows
};

struct SizeResult {
  SizeRecord record;
  std::vector<SegmentTiming> segments;  ///< those that were sized
  std::vector<Diagnostic> errors;       ///< empty: the record is complete
};

/// For the timing of the scenario, with its devices and map parameters. The latencies and policies that it asks for are
/// ignored.
SizeResult size_scenario(const Scenario& scenario, const SizeOptions& options);

/// For a recording: timing.csv (recordings/timing_csv.h), a list of steps with the header begin_ns,end_ns, or a profiler's
/// file with roles (recordings/recording.h). The segments are those of the file. If it has no visualizations and only one
/// segment, they are those of the cycle found in it; if there is no cycle either, every step is a segment, and then only the
/// loop of `phase_locked` makes sense, not `paper`.
SizeResult size_recording(const std::string& path, const SizeOptions& options, const RecordingOptions& recording = {});
/// The same for segments in memory, which must contain a step.
SizeRecord size_segments(std::vector<SegmentTiming> segments, const std::string& name, const SizeOptions& options);

}  // namespace evenstep
