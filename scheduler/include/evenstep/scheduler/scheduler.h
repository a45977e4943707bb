#pragma once
/// The deterministic scheduler: coroutines on an injected clock, one code for virtual and wall time; only the waiting
/// differs. Events run in the order (time, lane, sequence) and never earlier than the event before them.
///
///   co_await scheduler.until(tick_time(rate, k), Lane::device, "tick");
///   co_await scheduler.external(step.end, &work, "step");
///
/// now() is the key time of the event being run on both clocks: for a timer its scheduled time, for a completion its
/// stamp; how late it ran is Arrival::lateness(). A stamp that would sort before the last event run becomes that event's
/// time + 1 ns. Not thread-safe except completed() and request_stop().

#include <array>
#include <atomic>
#include <coroutine>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "evenstep/clock/clock.h"
#include "evenstep/scheduler/event.h"
#include "evenstep/scheduler/task.h"
#include "evenstep/scheduler/work.h"

namespace evenstep {

/// When an await was due and when it really ran (live clock). Equal under a virtual clock.
struct Arrival {
  RealTime scheduled;
  RealTime actual;
  constexpr Duration lateness() const { return actual - scheduled; }
};

/// Every limit ends the run with RunEnd::limit and a message that names it; none hangs.
struct SchedulerLimits {
  std::int64_t events_per_instant = 100'000;      ///< more on one nanosecond is a livelock (a lane that awaits now())
  std::int64_t total_events = 2'000'000'000;      ///< a day at 20 kHz
  std::int64_t pending_events = 1'000'000;        ///< the queue; evenstep's own lanes need fewer than 20
};

struct SchedulerOptions {
  SchedulerLimits limits;
  std::optional<std::uint64_t> permute_ties;      ///< seed: permutes the sequence numbers among equal (time, lane)
  bool keep_events = true;                        ///< fill events(); the chained hash is always kept
};

enum class RunEnd {
  reached_end,  ///< the next event lies at or after the end asked for
  idle,         ///< no event left
  stopped,      ///< request_stop(), after the event being run
  limit,        ///< a SchedulerLimits was exceeded
  failed,       ///< a task threw
};
struct RunStatus {
  RunEnd end = RunEnd::idle;
  std::string message;             ///< which limit, or what() of the exception; empty otherwise
  std::exception_ptr failure;      ///< RunEnd::failed
};

class Scheduler {
 public:
  Scheduler(Clock& clock, Executor& executor, SchedulerOptions options = {});
  ~Scheduler();  ///< waits for outstanding work, then destroys unfinished tasks
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  struct Suspended;

  /// Frozen during an event; 0 before the first.
  RealTime now() const noexcept { return now_; }
  /// A live read of the clock; equals now() under a virtual clock. Whoever uses it records it.
  RealTime live_now() const noexcept;

  /// Wakes at `at` (at now() if that is past, as an event of its own). Result: Arrival.
  struct Until;
  Until until(RealTime at, Lane lane, EventName name) noexcept;
  /// An event of its own at now(), in `lane`: lets everything that sorts before it at this instant run first.
  Until turn(Lane lane, EventName name) noexcept;

  /// Starts `work` now (nullptr: nothing, the await is a programmed wait) and wakes in Lane::completion. Virtual clock:
  /// at max(programmed_end, now()), having waited for the real result. Wall clock: at the later of the work's stamp and
  /// programmed_end. Result: Arrival. Rethrows what the work threw.
  struct External;
  External external(RealTime programmed_end, Work* work, EventName name) noexcept;

  /// Starts a lane; its first event is the first thing it awaits. Runs up to there at once. Before run() only.
  void spawn(Task task);

  /// Mixes a digest into the payload of the event being run (there must be one: not before a lane's first await).
  void note(std::uint64_t digest) noexcept;
  void note(double value) noexcept;

  /// Runs events with time < end. Returns only when no work is outstanding. May be called again with a later end, unless
  /// it was stopped, went over a limit or failed: that is final. A wall clock is waited for only while something can
  /// still happen before `end`.
  RunStatus run(RealTime end);
  /// Key of the event that run_one() would run next on a virtual clock (completions at their programmed end).
  struct Key { RealTime time; Lane lane; };
  std::optional<Key> next() const;
  /// Runs exactly one event (lock-step tests, replay). False when none is left or the run has failed.
  bool run_one();
  RunStatus status() const;

  std::uint64_t trace_hash() const noexcept;            ///< chained over every event run so far
  const std::vector<Event>& events() const noexcept;
  std::int64_t event_count() const noexcept;

  void completed(Completion& completion) noexcept;      ///< an executor's thread: work is done, wake up (wall clock)
  void request_stop() noexcept;                         ///< any thread, also a signal handler

 private:
  struct State;
  void wake_at(RealTime at, Lane lane, Suspended& await) noexcept;
  RealTime now_;  ///< of the event being run, or of the last one; here, so that a lane reads it without a call
  std::unique_ptr<State> state_;
};

/// A lane that waits. It lives in the coroutine's frame, whose address is stable while suspended: an await allocates nothing.
struct Scheduler::Suspended {
  Scheduler* scheduler = nullptr;
  EventName name;
  std::coroutine_handle<Task::promise_type> handle = nullptr;
  Arrival arrival;
  Completion* completion = nullptr;  ///< of started work; owned by the scheduler's pool
};

struct Scheduler::Until : Suspended {
  RealTime at;
  Lane lane = Lane::completion;
  bool await_ready() const noexcept { return false; }
  /// Inline, so that the time goes to the queue in a register, not through the memory where the lane keeps it.
  void await_suspend(std::coroutine_handle<Task::promise_type> lane_handle) noexcept {
    handle = lane_handle;
    scheduler->wake_at(at, lane, *this);
  }
  Arrival await_resume() const noexcept { return arrival; }
};

struct Scheduler::External : Suspended {
  RealTime programmed_end;
  Work* work = nullptr;
  bool await_ready() const noexcept { return false; }
  void await_suspend(std::coroutine_handle<Task::promise_type> lane_handle) noexcept;
  Arrival await_resume();
};

// Inline: an awaitable is made where its lane keeps it.
inline Scheduler::Until Scheduler::until(RealTime at, Lane lane, EventName name) noexcept { return {{this, name}, at, lane}; }
inline Scheduler::Until Scheduler::turn(Lane lane, EventName name) noexcept { return until(now_, lane, name); }
inline Scheduler::External Scheduler::external(RealTime programmed_end, Work* work, EventName name) noexcept {
  return {{this, name}, programmed_end, work};
}

static_assert(std::is_trivially_copyable_v<Scheduler::Until> && std::is_trivially_copyable_v<Scheduler::External>,
              "g++ 12 destroys non-trivial temporaries inside co_await twice");

}  // namespace evenstep
