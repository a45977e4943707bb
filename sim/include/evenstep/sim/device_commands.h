#pragma once
/// What a device reports of the commands that a solver has given it: the four times of OpenCL's profiling events
/// (CL_PROFILING_COMMAND_QUEUED, _SUBMIT, _START and _END), in ns of the device's own clock. Its zero may lie anywhere, so
/// only differences of these times can be compared with the host's clock.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace evenstep {

struct DeviceCommand {
  std::string_view name;  ///< of the kernel, or "read", "write", "fill", "copy"; valid as long as the program runs
  std::uint64_t queued_ns = 0, submitted_ns = 0, started_ns = 0, ended_ns = 0;  ///< all 0 if the device does not say

  /// Whether the device has said them: four of them, in order, and none so late that differences overflow.
  bool has_times() const {
    return queued_ns > 0 && queued_ns <= submitted_ns && submitted_ns <= started_ns && started_ns <= ended_ns &&
           ended_ns <= INT64_MAX;
  }
};

/// The commands since the last take(), in the order in which they were given. For the thread that calls the solver.
class CommandLog {
 public:
  virtual ~CommandLog() = default;
  virtual std::size_t size() const = 0;  ///< costs nothing
  /// Waits until all of them have ended. Costs a few calls of OpenCL for each.
  virtual std::vector<DeviceCommand> take() = 0;
};

/// An OpenCL device, as it describes itself.
struct OpenClDescription {
  std::string device, platform, version, driver;  ///< version: of OpenCL and the platform
  std::int64_t compute_units = 0;
  std::int64_t clock_MHz = 0;            ///< the highest that is configured
  std::int64_t timer_resolution_ns = 0;  ///< of the times of its commands; 0 if it does not say
  std::int64_t memory_bytes = 0;
};

}  // namespace evenstep
