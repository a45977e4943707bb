#pragma once
/// Work done outside the scheduler (a GPU step): started at launch, its result delivered at completion.

#include <atomic>
#include <exception>

#include "evenstep/time/time.h"

namespace evenstep {

class Scheduler;

/// What runs. It outlives the await (the solver lane owns it). run() is called once per external(), on the executor's
/// thread, and may throw: the exception reaches the awaiting coroutine.
class Work {
 public:
  virtual void run() = 0;

 protected:
  ~Work() = default;
};

/// One started piece of work; lives in the scheduler's pool.
struct Completion {
  Work* work = nullptr;
  Scheduler* home = nullptr;         ///< where not null (wall clock): told by home->completed(), after stamp and failure
  std::atomic<bool> done{false};     ///< set last: an executor's final access to the completion and its home
  RealTime stamp;                    ///< live time at which run() returned (wall clock)
  std::exception_ptr failure;        ///< what run() threw
};

/// Runs Work. start() never blocks on a wall clock and never throws: a failure to start is a failure of the work.
class Executor {
 public:
  virtual ~Executor() = default;
  virtual void start(Completion& completion) = 0;
  /// Blocks until completion.done. Called by the scheduler under a virtual clock when virtual time reaches the
  /// programmed end (virtual time never outruns real work), and on every clock before run() returns.
  virtual void wait(Completion& completion) = 0;
};

/// Runs the work inside start(): the default under a virtual clock, where the host's speed is invisible. On a wall clock
/// every lane of the scheduler waits for it.
class InlineExecutor final : public Executor {
 public:
  void start(Completion& completion) override;
  void wait(Completion&) override {}
};

}  // namespace evenstep
