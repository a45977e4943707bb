#pragma once
/// The recorded motion of a hand, with the columns t_s,x_m,y_m,z_m. Times must increase; they are rounded to 1 ns.

#include <string>
#include <vector>

#include "evenstep/device/motion.h"
#include "evenstep/text/diagnostic.h"
#include "evenstep/time/result.h"

namespace evenstep::internal {

using MotionCsv = Result<RecordedMotion, std::vector<Diagnostic>>;
MotionCsv read_motion_csv(const std::string& path);
MotionCsv parse_motion_csv(const std::string& text, const std::string& name);

}  // namespace evenstep::internal
