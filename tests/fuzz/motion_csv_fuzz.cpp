// Any bytes as a recorded motion.
#include <cmath>

#include "evenstep/recordings/motion_csv.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string input(reinterpret_cast<const char*>(data), size);
  const internal::MotionCsv csv = internal::parse_motion_csv(input, "motion.csv");
  require_read_or_refused(csv.ok(), csv.error_or({}));
  if (!csv) return 0;
  require(!csv->rows.empty(), "a motion without rows");
  for (std::size_t n = 0; n < csv->rows.size(); ++n) {
    const auto& [time, position_m] = csv->rows[n];
    require(n == 0 || time > csv->rows[n - 1].first, "time does not increase");
    for (int axis = 0; axis < 3; ++axis) require(std::isfinite(position_m[axis]), "a position is not finite");
  }
  return 0;
}
