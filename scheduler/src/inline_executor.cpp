#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/work.h"

namespace evenstep {

void InlineExecutor::start(Completion& completion) {
  try {
    completion.work->run();
  } catch (...) {
    completion.failure = std::current_exception();
  }
  if (completion.home != nullptr) {
    completion.stamp = completion.home->live_now();
    completion.home->completed(completion);
  }
  completion.done.store(true, std::memory_order_release);
}

}  // namespace evenstep
