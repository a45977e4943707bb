#pragma once
/// Work done outside the scheduler (a step on the GPU): it is started at launch, and its result is delivered at completion.

#include <atomic>
#include <exception>

#include "evenstep/time/time.h"

namespace evenstep {

class Scheduler;

/// A piece of work. It must outlive the await (the solver lane owns it). run() is called once per external(), on the
/// executor's thread. It may throw: the exception reaches the awaiting coroutine.
class Work {
 public:
  virtual void run() = 0;

 protected:
  ~Work() = default;
};

/// A piece of work that was started; lives in the scheduler's pool.
struct Completion {
  Work* work = nullptr;
  Scheduler* home = nullptr;      ///< wall clock: gets home->completed() once stamp and failure are set; else null
  std::atomic<bool> done{false};  ///< set last: after this the executor touches neither the completion nor its home
  RealTime stamp;                 ///< wall clock: the time at which run() returned
  std::exception_ptr failure;     ///< what run() threw
};

/// Runs Work. start() never throws: a failure to start is a failure of the work. For a wall clock start() should not block
/// (see InlineExecutor).
class Executor {
 public:
  virtual ~Executor() = default;
  virtual void start(Completion& completion) = 0;
  /// Blocks until completion.done. Called by the scheduler under a virtual clock when virtual time reaches the
  /// programmed end (virtual time never outruns real work), and on every clock before run() returns.
  virtual void wait(Completion& completion) = 0;
};

/// Runs the work inside start(). This is the default under a virtual clock, where the host's speed does not matter. On a
/// wall clock all lanes of the scheduler would have to wait for the work.
class InlineExecutor final : public Executor {
 public:
  void start(Completion& completion) override;
  void wait(Completion&) override {}
};

}  // namespace evenstep
