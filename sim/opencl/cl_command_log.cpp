#include "opencl/cl_command_log.h"

namespace evenstep::internal {
namespace {

/// 0 if the device does not report the time.
std::uint64_t time_ns(const ClEvent& event, cl_profiling_info which) {
  cl_ulong ns = 0;
  const cl_int code = cl().clGetEventProfilingInfo(event.get(), which, sizeof ns, &ns, nullptr);
  return code == CL_SUCCESS ? ns : 0;
}

}  // namespace

std::vector<DeviceCommand> ClCommandLog::take() {
  std::vector<DeviceCommand> taken;
  if (commands_.empty()) return taken;
  const cl_event last = commands_.back().event.get();  // when it has ended, so have all others
  check_cl(cl().clWaitForEvents(1, &last), "clWaitForEvents");
  taken.reserve(commands_.size());
  for (const auto& [name, event] : commands_) {
    taken.push_back({name, time_ns(event, CL_PROFILING_COMMAND_QUEUED), time_ns(event, CL_PROFILING_COMMAND_SUBMIT),
                     time_ns(event, CL_PROFILING_COMMAND_START), time_ns(event, CL_PROFILING_COMMAND_END)});
  }
  commands_.clear();
  return taken;
}

}  // namespace evenstep::internal
