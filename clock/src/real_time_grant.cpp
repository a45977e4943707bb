#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>

#include <cerrno>
#include <system_error>

#include "evenstep/clock/wall_clock.h"

namespace evenstep {
namespace {

void add_refusal(std::string& refusal, const std::string& what, int error, const std::string& remedy) {
  if (!refusal.empty()) refusal += "; ";
  refusal += what + " refused: " + std::generic_category().message(error);
  if (error == EPERM || error == ENOMEM || error == EAGAIN) refusal += " (" + remedy + ")";
}

}  // namespace

RealTimeGrant request_real_time(int fifo_priority) {
  // The default slack allows the kernel to wake an ordinary thread 50 us late to save power; this call removes it.
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);

  RealTimeGrant grant;
  sched_param parameters{};
  parameters.sched_priority = fifo_priority;
  grant.fifo = sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;  // 0: the calling thread
  if (!grant.fifo) {
    const int error = errno;
    const std::string priority = std::to_string(fifo_priority);
    add_refusal(grant.refusal, "SCHED_FIFO priority " + priority, error,
                "allow it with `ulimit -r " + priority + "` or CAP_SYS_NICE");
  }
  // MCL_CURRENT only: with MCL_FUTURE every later thread stack and GPU mapping would be pinned, or fail at the limit.
  grant.memory_locked = mlockall(MCL_CURRENT) == 0;
  if (!grant.memory_locked) {
    const int error = errno;
    add_refusal(grant.refusal, "mlockall", error, "allow it with `ulimit -l unlimited` or CAP_IPC_LOCK");
  }
  return grant;
}

void leave_real_time() {
  const sched_param ordinary{};
  sched_setscheduler(0, SCHED_OTHER, &ordinary);  // allowed to everybody
}

}  // namespace evenstep
