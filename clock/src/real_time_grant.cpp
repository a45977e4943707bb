#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

#include "evenstep/clock/wall_clock.h"

namespace evenstep {
namespace {

std::string refused(const std::string& what, int error, const std::string& remedy) {
  const bool may_be_allowed = error == EPERM || error == ENOMEM || error == EAGAIN;
  return what + " refused: " + std::generic_category().message(error) + (may_be_allowed ? " (" + remedy + ")" : "");
}

/// The kernel's struct sched_attr in its first version; glibc 2.36 does not declare it.
struct Scheduling {
  std::uint32_t size = sizeof(Scheduling), policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime_ns = 0, deadline_ns = 0, period_ns = 0;
};

/// Asks for a time slice for the calling thread, which must have the ordinary policy; 0 asks for the system's default.
/// Returns the slice that the thread then has, or 0 if this kernel has no slices.
std::int64_t ask_for_slice(std::uint64_t slice_ns) {
  Scheduling now;
  if (syscall(SYS_sched_getattr, 0, &now, sizeof(now), 0U) != 0 || now.policy != SCHED_OTHER) return 0;
  now.runtime_ns = slice_ns;
  if (syscall(SYS_sched_setattr, 0, &now, 0U) != 0) return 0;
  if (syscall(SYS_sched_getattr, 0, &now, sizeof(now), 0U) != 0) return 0;
  return static_cast<std::int64_t>(now.runtime_ns);
}

constexpr std::uint64_t kShortestSlice_ns = 100'000;  // the kernel grants no shorter one

}  // namespace

RealTimeRights::RealTimeRights(int fifo_priority) : policy_before_(sched_getscheduler(0)) {  // 0: the calling thread
  sched_param parameters{};
  sched_getparam(0, &parameters);
  priority_before_ = parameters.sched_priority;
  // The default slack allows the kernel to wake an ordinary thread 50 us late to save power; this call removes it.
  slack_before_ns_ = prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL);
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);

  grant_.priority = parameters.sched_priority = fifo_priority;
  grant_.fifo = sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;
  if (!grant_.fifo) {
    const int error = errno;
    const std::string priority = std::to_string(fifo_priority);
    grant_.refusal =
        refused("SCHED_FIFO priority " + priority, error, "allow it with `ulimit -r " + priority + "` or CAP_SYS_NICE");
    grant_.slice_ns = ask_for_slice(kShortestSlice_ns);
  }
  grant_.timer_slack_ns = prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL);
}

RealTimeRights::~RealTimeRights() {
  sched_param parameters{};
  parameters.sched_priority = priority_before_;
  if (grant_.fifo) sched_setscheduler(0, policy_before_, &parameters);
  if (grant_.slice_ns != 0) ask_for_slice(0);
  prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack_before_ns_), 0UL, 0UL, 0UL);
}

MemoryLock::MemoryLock() {
  if (mlockall(MCL_CURRENT) != 0)
    refusal_ = refused("mlockall", errno, "allow it with `ulimit -l unlimited` or CAP_IPC_LOCK");
}

MemoryLock::~MemoryLock() {
  if (refusal_.empty()) munlockall();
}

WakeLatency::WakeLatency(std::int32_t most_us, const std::string& device)
    : file_(::open(device.c_str(), O_WRONLY | O_CLOEXEC)) {
  if (file_ >= 0 && ::write(file_, &most_us, sizeof most_us) == sizeof most_us) return;
  const int error = errno;
  refusal_ = device + ": " + std::generic_category().message(error);
  if (error == EACCES || error == EPERM)
    refusal_ +=
        " (root may; so may a group that a udev rule names: KERNEL==\"cpu_dma_latency\", GROUP=\"...\", MODE=\"0660\")";
  if (error == ENOENT) refusal_ += " (a container, or a kernel without CONFIG_CPU_IDLE)";
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

WakeLatency::~WakeLatency() {
  if (file_ >= 0) ::close(file_);
}

void leave_real_time() {
  const sched_param ordinary{};
  sched_setscheduler(0, SCHED_OTHER, &ordinary);  // allowed to everybody
}

}  // namespace evenstep
