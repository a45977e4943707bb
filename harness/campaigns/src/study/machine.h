#pragma once
/// What a cost was measured on, and how its repeats are summed up.

#include <cstdint>
#include <string>
#include <vector>

#include "evenstep/reports/study_record.h"

namespace evenstep::internal {

struct StudyMachine {
  std::string name, compiler;
  std::int64_t cpus = 0;
  double load = 0;  ///< runnable processes, mean over a minute; 0 if the system does not say
};
StudyMachine study_machine();

/// Of at least one repeat.
StudyCost cost_of(std::vector<double> seconds);

inline constexpr double kLeastTimed_s = 0.02;  ///< CPU time of a repeat, which goes through the motion often enough for it
inline constexpr double kMostCell_s = 20;      ///< CPU time after which a cell is not repeated any more

}  // namespace evenstep::internal
