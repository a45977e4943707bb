#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

#include <cerrno>
#include <system_error>

#include "evenstep/clock/wall_clock.h"

namespace evenstep {
namespace {

std::string refused(const std::string& what, int error, const std::string& remedy) {
  const bool may_be_allowed = error == EPERM || error == ENOMEM || error == EAGAIN;
  return what + " refused: " + std::generic_category().message(error) + (may_be_allowed ? " (" + remedy + ")" : "");
}

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
  }
  grant_.timer_slack_ns = prctl(PR_GET_TIMERSLACK, 0UL, 0UL, 0UL, 0UL);
}

RealTimeRights::~RealTimeRights() {
  sched_param parameters{};
  parameters.sched_priority = priority_before_;
  if (grant_.fifo) sched_setscheduler(0, policy_before_, &parameters);
  prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(slack_before_ns_), 0UL, 0UL, 0UL);
}

MemoryLock::MemoryLock() {
  if (mlockall(MCL_CURRENT) != 0)
    refusal_ = refused("mlockall", errno, "allow it with `ulimit -l unlimited` or CAP_IPC_LOCK");
}

MemoryLock::~MemoryLock() {
  if (refusal_.empty()) munlockall();
}

}  // namespace evenstep
