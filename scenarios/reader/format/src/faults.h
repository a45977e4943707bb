#pragma once
/// The faults that a scenario programs, by the names that [run] faults_off and a swarm use: "timing.hitch",
/// "device.left.faults.2".

#include <string>
#include <vector>

#include "evenstep/format/document.h"

namespace evenstep::internal {

/// Where a fault is written: in a table [timing], or of a device.
struct FaultPlace {
  std::string name;
  std::string key;         ///< of [timing], or of the device: "hitch", "faults", "evdev.meddled_at"
  std::size_t device = 0;  ///< by its number; unused in [timing]
  std::size_t entry = 0;   ///< of `faults`
  bool of_timing = false;
};
/// The faults of a document. If some are switched off, `entry` counts those that are left, the name all that were written.
std::vector<FaultPlace> fault_places(const Value& document);

}  // namespace evenstep::internal
