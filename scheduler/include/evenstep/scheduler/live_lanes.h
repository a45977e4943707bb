#pragma once
/// The threads of a run on a wall clock: a worker that runs a solver's steps, and a thread that runs a scheduler. There are
/// no others.

#include <functional>
#include <memory>

#include "evenstep/clock/clock.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/work.h"

namespace evenstep {

/// One thread that runs the work given to it in order, stamps each piece with `clock` when it is done and notifies its
/// scheduler. Under a virtual clock it gives the same results as InlineExecutor, bit for bit.
class WorkerExecutor final : public Executor {
 public:
  explicit WorkerExecutor(const Clock& clock);
  /// Its thread asks for this SCHED_FIFO priority; grant() says what it got.
  WorkerExecutor(const Clock& clock, int fifo_priority);
  ~WorkerExecutor() override;  ///< finishes all work that was started
  void start(Completion& completion) override;
  void wait(Completion& completion) override;
  const RealTimeGrant& grant() const { return grant_; }

 private:
  struct State;
  std::unique_ptr<State> state_;
  RealTimeGrant grant_;
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
