#pragma once
/// `evenstep size`: the least latency, lead and rings of a timing for which nothing underruns, without running anything but
/// the maps (docs/sizing.md).

#include <optional>
#include <string>
#include <vector>

#include "evenstep/text/diagnostic.h"
#include "evenstep/format/scenario.h"
#include "evenstep/reports/size_record.h"

namespace evenstep {

struct SizeOptions {
  Rate sampling{1000, 1};                   ///< of the device, of which a recording knows nothing; a tick at its first begin
  Emission emission = Emission::hold;       ///< likewise
  std::optional<double> rate;               ///< of segments that may underrun, in (0, 1): finds what latency that takes, too
  double confidence = 0.95;                 ///< with which the rate is to be bounded, in (0, 1)
  double damping_N_s_per_m = 1;             ///< of hand and device, for the stiffness that the closed loop carries
};

struct SizeResult {
  SizeRecord record;
  std::vector<Diagnostic> errors;           ///< none: the record is whole
};

/// The timing of the scenario, with its devices and its map parameters. Latencies and policies it asks for do not matter.
SizeResult size_scenario(const Scenario& scenario, const SizeOptions& options);

/// A recording: timing.csv (harness/timing_csv.h), or a list of steps with the header begin_ns,end_ns. Segments are those of
/// the file; where it has no visualizations and one segment only, those of the cycle found in it; where there is no cycle
/// either, every step is a segment, which leaves the loop of `phase_locked` and no use for `paper`.
SizeResult size_recording(const std::string& path, const SizeOptions& options);
/// The same for segments in memory, with a step among them.
SizeRecord size_segments(std::vector<SegmentTiming> segments, const std::string& name, const SizeOptions& options);


}  // namespace evenstep
