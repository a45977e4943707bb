#pragma once
/// The drivers of DriverSpec, one row each, in its order.

#include <string>
#include <string_view>
#include <vector>

#include "check.h"

namespace evenstep::internal {

struct ScenarioReading;

struct DriverFormat {
  std::string_view name;
  std::vector<Field> (*fields)();
  DriverSpec (*read)(const ScenarioReading& reading, const Table& device);
};
const std::vector<DriverFormat>& driver_formats();
/// Why a simulated device of this driver cannot return after it was unplugged; empty: it can.
std::string why_no_return(const DriverSpec& driver);
/// "reference|pid|foreign"
std::string_view driver_words();

}  // namespace evenstep::internal
