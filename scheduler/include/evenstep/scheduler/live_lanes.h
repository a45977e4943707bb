#pragma once
/// The threads of a run on a wall clock: a worker that runs a solver's steps, and a thread that runs a scheduler. There are
/// no others.

#include <functional>
#include <memory>

#include "evenstep/clock/clock.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/work.h"

namespace evenstep {

/// One thread that runs the work given to it in order, stamps each piece with `clock` when it is done and notifies its
/// scheduler. Under a virtual clock it gives the same results as InlineExecutor, bit for bit.
class WorkerExecutor final : public Executor {
 public:
  explicit WorkerExecutor(const Clock& clock);
  ~WorkerExecutor() override;  ///< finishes all work that was started
  void start(Completion& completion) override;
  void wait(Completion& completion) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Runs body on a thread of its own; join() waits for it and rethrows what it threw. The destructor joins.
class LaneThread {
 public:
  explicit LaneThread(std::function<void()> body);
  ~LaneThread();
  void join();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace evenstep
