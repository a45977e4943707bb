#include "evenstep/scheduler/stepped_thread.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include "evenstep/scheduler/live_lanes.h"
#include "src/loop_thread.h"

namespace evenstep {

using internal::clock_of_this_thread;

/// The loop's clock, and the baton: the side that has the baton runs, the other waits.
struct SteppedThread::State final : BlockingClock {
  enum class Holder { scheduler, thread };
  struct Sleep {
    RealTime at;
    Lane lane = Lane::launch;
  };

  Scheduler& scheduler;
  const SteppedThreadOptions options;
  const BlockingLoop loop;
  Sleep asked;                 // written by the thread before it hands over
  std::exception_ptr failure;  // likewise

  std::mutex mutex;
  std::condition_variable handed_over;
  Holder baton = Holder::scheduler;  // this and the next two: guarded by mutex
  bool stopping = false;
  bool ended = false;
  std::optional<LaneThread> thread;  // used by the scheduler's side only, as is_stuck
  bool is_stuck = false;

  State(Scheduler& s, SteppedThreadOptions o, BlockingLoop l) : scheduler(s), options(o), loop(std::move(l)) {}

  // ---- The loop's side

  RealTime now() const override { return scheduler.live_now(); }
  void sleep_until(RealTime at) override { sleep_until(at, options.lane); }
  void sleep_until(RealTime at, Lane lane) override {
    if (clock_of_this_thread != this)
      throw std::logic_error(who() + ": its clock was asked to sleep by another thread, which the scheduler does not step");
    std::unique_lock lock(mutex);
    if (!stopping) {
      asked = {at, lane};
      pass_to(Holder::scheduler);
      handed_over.wait(lock, [this] { return baton == Holder::thread; });
    }
    if (stopping) internal::leave_loop();
  }
  void run_loop() {
    try {
      internal::run_until_stopped(loop, *this);
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    ended = true;
    pass_to(Holder::scheduler);
  }

  // ---- The scheduler's side

  /// Lets the loop run to its next sleep: true. False when it has ended; throws what the loop threw.
  bool step() {
    std::unique_lock lock(mutex);
    if (stopping) return false;
    pass_to(Holder::thread);
    if (!thread) thread.emplace([this] { run_loop(); });
    if (!wait_for(lock, [this] { return baton == Holder::scheduler; })) {
      stopping = is_stuck = true;
      throw std::runtime_error(stuck());
    }
    if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
    return !ended;
  }
  void stop() noexcept {
    if (!thread) return;
    assert(clock_of_this_thread != this && "a loop cannot destroy its own thread");
    {
      std::unique_lock lock(mutex);
      stopping = true;
      pass_to(Holder::thread);
      if (!wait_for(lock, [this] { return ended; })) {
        std::fprintf(stderr, "evenstep: %s; the run is over and the thread cannot be ended\n", stuck().c_str());
        std::terminate();
      }
    }
    thread.reset();
  }

 private:
  void pass_to(Holder next) {
    baton = next;
    handed_over.notify_one();  // only the other side can be waiting
  }
  template <class Condition>
  bool wait_for(std::unique_lock<std::mutex>& lock, Condition condition) {
    constexpr std::int64_t kThirtyYears_ns = 1'000'000'000'000'000'000;  // more would overflow the end of the wait
    if (options.real_time_limit) {
      const std::chrono::nanoseconds limit(std::min(options.real_time_limit->ns, kThirtyYears_ns));
      return handed_over.wait_for(lock, limit, condition);
    }
    handed_over.wait(lock, condition);
    return true;
  }
  std::string who() const { return std::string("the stepped thread '") + options.name.text + "'"; }
  std::string stuck() const {
    return who() + " did not come back to sleep_until() within " + std::to_string(options.real_time_limit->ns / 1'000'000) +
           " ms of real time, at " + std::to_string(scheduler.now().ns) +
           " ns: it spins, or waits for something else than its clock (a lock, a queue, another thread: the scheduler lets "
           "nothing else run meanwhile); if its work takes that long, raise real_time_limit";
  }
};

/// Ends the thread with its lane, also if the scheduler is destroyed first. A thread that is stuck would not end: that error
/// must reach the caller of run(), who may know how to free it.
struct SteppedThread::EndWithLane {
  State& state;
  ~EndWithLane() {
    if (!state.is_stuck) state.stop();
  }
};

Task SteppedThread::lane(Scheduler& scheduler, std::shared_ptr<State> state) {
  const EndWithLane end{*state};
  while (state->step()) {
    co_await scheduler.until(state->asked.at, state->asked.lane, state->options.name);
  }
}

SteppedThread::SteppedThread(Scheduler& scheduler, SteppedThreadOptions options, BlockingLoop loop)
    : state_(std::make_shared<State>(scheduler, options, std::move(loop))) {
  if (clock_of_this_thread != nullptr)
    throw std::logic_error("a stepped thread cannot start another: start all of them before the run");
  scheduler.spawn(lane(scheduler, state_));
}

SteppedThread::~SteppedThread() { state_->stop(); }

}  // namespace evenstep
