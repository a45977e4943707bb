#pragma once
/// What became of the reports that a separate thread sends to a real device.

#include <cstdint>

#include "evenstep/time/duration_histogram.h"

namespace evenstep {

struct WriteTimes {
  DurationHistogram taken;     ///< how long each write took, until the system had the report
  std::int64_t overtaken = 0;  ///< forces that a newer one replaced before they were sent
  std::int64_t rejected = 0;   ///< by the system, or by a full queue
};

}  // namespace evenstep
