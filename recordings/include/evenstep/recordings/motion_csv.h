#pragma once
/// A recorded hand: t_s,x_m,y_m,z_m, times increasing. Times are rounded to 1 ns.

#include <string>
#include <vector>

#include "evenstep/device/motion.h"
#include "evenstep/text/diagnostic.h"

namespace evenstep::internal {

struct MotionCsv {
  RecordedMotion motion;
  std::vector<Diagnostic> errors;
};
MotionCsv read_motion_csv(const std::string& path);
MotionCsv parse_motion_csv(const std::string& text, const std::string& name);

}  // namespace evenstep::internal
