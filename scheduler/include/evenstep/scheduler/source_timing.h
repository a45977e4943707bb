#pragma once
/// A schedule whose results come from elsewhere: from a server over a network, or from a machine with a clock of its own.
///
///   clock      an instant t of the source's own clock is t 1e6 / (1e6 + clock_ppm) on the device's, floored to ns
///   delay of   result n: `delay` + floor(u_n (`jitter` + 1 ns)), and `late_by` more with probability `late`; in the
///              device's time
///   lost       with probability `lost`, each result independently
///
/// A result comes after the next one (reordered) if its delay is longer by more than the time between the two. Draw n of
/// each stream belongs to step n, and each cause has a stream of its own, so switching one on does not shift the draws of
/// another.

#include <cstdint>
#include <memory>

#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

struct SourceSpec {
  Duration delay, jitter;      ///< >= 0
  double lost = 0, late = 0;   ///< probabilities
  Duration late_by;            ///< >= 0
  std::int64_t clock_ppm = 0;  ///< the source's clock is faster by this; above -1e6
  std::uint64_t seed = 1;
};

/// How result n comes to the device.
Transport transport(const SourceSpec& source, std::uint64_t n);

/// Converts `timing` from the source's time to the device's, and adds the transport of every result.
std::unique_ptr<StepTiming> make_source_timing(std::unique_ptr<StepTiming> timing, const SourceSpec& source);

}  // namespace evenstep
