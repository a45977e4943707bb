#pragma once
/// Profiling events of commands, and the times that they give.

#include "evenstep/sim/device_commands.h"
#include "opencl/cl_handle.h"

namespace evenstep::internal {

using ClEvent = ClHandle<cl_event, &ClLibrary::clReleaseEvent>;

class ClCommandLog final : public CommandLog {
 public:
  /// `name` must be valid as long as the program runs. All events belong to one in-order queue.
  void add(std::string_view name, ClEvent event) { commands_.push_back({name, std::move(event)}); }
  std::size_t size() const override { return commands_.size(); }
  std::vector<DeviceCommand> take() override;

 private:
  struct Command {
    std::string_view name;
    ClEvent event;
  };
  std::vector<Command> commands_;
};

}  // namespace evenstep::internal
