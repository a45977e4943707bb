#include "evenstep/sim/busy_device.h"

#include <algorithm>

#include "opencl/cl_commands.h"
#include "opencl_kernels.h"

namespace evenstep {
namespace {

using namespace internal;

constexpr std::int64_t kGroupsPerUnit = 8;  // enough for every compute unit, even if they are dealt out unevenly

class OpenClBusy final : public BusyDevice {
 public:
  OpenClBusy(ClDevice device, const SolverOptions& options)
      : commands_(std::move(device), static_cast<std::size_t>(options.work_group_size)) {
    const std::int64_t units = std::max<std::int64_t>(describe(commands_.device()).compute_units, 1);
    items_ = static_cast<std::size_t>(units * kGroupsPerUnit * options.work_group_size);
    results_ = commands_.buffer(items_ * sizeof(float));
    commands_.build(kBurnSource, "");
    kernel_ = commands_.kernel("burn");
    kernel_.add(results_, cl_int{1});
    run(1);
  }

  void run(std::int64_t rounds) override {
    kernel_.set(1, static_cast<cl_int>(std::clamp<std::int64_t>(rounds, 1, 1'000'000'000)));
    commands_.enqueue(kernel_, items_);
    commands_.finish();
  }

 private:
  ClCommands commands_;
  std::size_t items_ = 0;
  ClBuffer results_;
  BoundKernel kernel_;
};

}  // namespace

std::unique_ptr<BusyDevice> make_busy_device(const SolverOptions& options) {
  return std::make_unique<OpenClBusy>(choose_device(options), options);
}

}  // namespace evenstep
