#pragma once
/// The deterministic scheduler: it runs coroutines on a clock that is passed in. The same code serves virtual and wall time;
/// only the waiting differs. Events run in the order (time, lane, sequence) and never earlier than the event before them.
///
///   co_await scheduler.until(tick_time(rate, k), Lane::device, "tick");
///   co_await scheduler.external(step.end, &work, "step");
///
/// On both clocks now() is the key time of the event being run: for a timer its scheduled time, for a completion its stamp.
/// How late the event really ran is Arrival::lateness(). A stamp that would sort before the last event run becomes that
/// event's time + 1 ns. Not thread-safe, except for completed() and request_stop(). A loop that cannot become a coroutine
/// runs on a thread that the scheduler steps: stepped_thread.h.

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

/// When an await was due and when it really ran by the clock. The two are equal under a virtual clock.
struct Arrival {
  RealTime scheduled;
  RealTime actual;
  constexpr Duration lateness() const { return actual - scheduled; }
};

/// Exceeding a limit ends the run with RunEnd::limit and a message that names the limit, so a run cannot hang.
struct SchedulerLimits {
  std::int64_t events_per_instant = 100'000;  ///< more on one nanosecond is a livelock (a lane keeps awaiting now())
  std::int64_t total_events = 2'000'000'000;  ///< a day at 20 kHz
  std::int64_t pending_events = 1'000'000;    ///< the queue; evenstep's own lanes need fewer than 20
};

struct SchedulerOptions {
  SchedulerLimits limits;
  std::optional<std::uint64_t> permute_ties;  ///< seed: permutes the sequence numbers among equal (time, lane)
  bool keep_events = true;                    ///< whether to fill events(); the chained hash is kept in any case
};

enum class RunEnd {
  reached_end,  ///< the next event lies at or after the end asked for
  idle,         ///< no event is left
  stopped,      ///< request_stop() was called; the event being run was finished
  limit,        ///< one of the SchedulerLimits was exceeded
  failed,       ///< a task threw
};
struct RunStatus {
  RunEnd end = RunEnd::idle;
  std::string message;         ///< which limit, or what() of the exception; otherwise empty
  std::exception_ptr failure;  ///< set for RunEnd::failed
};

class Scheduler {
 public:
  Scheduler(Clock& clock, Executor& executor, SchedulerOptions options = {});
  ~Scheduler();  ///< waits for outstanding work, then destroys unfinished tasks
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  struct Suspended;

  /// Does not change during an event; 0 before the first event.
  RealTime now() const noexcept { return now_; }
  /// The clock's time right now; equals now() under a virtual clock. The caller must record what it read, for a replay.
  RealTime live_now() const noexcept;

  /// Wakes at `at`, or at now() if `at` has passed; in both cases as a new event. Result: Arrival.
  struct Until;
  Until until(RealTime at, Lane lane, EventName name) noexcept;
  /// Wakes in a new event at now() in `lane`, so that everything that sorts before it at this instant runs first.
  Until turn(Lane lane, EventName name) noexcept;

  /// Starts `work` now (nullptr: no work, just a programmed wait) and wakes in Lane::completion. Under a virtual clock it
  /// wakes at max(programmed_end, now()), after waiting for the real result; on a wall clock at the later of the work's
  /// stamp and programmed_end. Result: Arrival. Rethrows what the work threw.
  struct External;
  External external(RealTime programmed_end, Work* work, EventName name) noexcept;

  /// Starts a lane: it runs up to its first await at once, and that await is its first event. Only before the first
  /// event, else std::logic_error.
  void spawn(Task task);

  /// Mixes a digest into the payload of the event being run. There must be one: do not call it before a lane's first await.
  void note(std::uint64_t digest) noexcept;
  void note(double value) noexcept;

  /// Runs events with time < end. Returns only when no work is outstanding. It may be called again with a later end, unless
  /// the run was stopped, exceeded a limit or failed, which is final. On a wall clock it waits only as long as something
  /// can still happen before `end`. std::logic_error if a lane of this scheduler calls it.
  RunStatus run(RealTime end);
  /// The key of the event that run_one() would run next on a virtual clock (a completion is at its programmed end).
  struct Key {
    RealTime time;
    Lane lane;
  };
  std::optional<Key> next() const;
  /// Runs exactly one event (for lock-step tests and replays). False when none is left or the run has failed.
  bool run_one();
  RunStatus status() const;

  std::uint64_t trace_hash() const noexcept;  ///< chained over every event run so far
  const std::vector<Event>& events() const noexcept;
  /// Reserves room for `count` events, so that no event has to wait while the list is moved to a larger place.
  void reserve_events(std::size_t count);
  /// Swaps events() with `empty`, which takes the events to come. Call it only between two events.
  void take_events(std::vector<Event>& empty) noexcept;
  std::int64_t event_count() const noexcept;

  /// Tells a scheduler on a wall clock that work is done; called from the executor's thread.
  void completed(Completion& completion) noexcept;
  void request_stop() noexcept;  ///< callable from any thread and from a signal handler

 private:
  struct State;
  void wake_at(RealTime at, Lane lane, Suspended& await) noexcept;
  RealTime now_;  ///< time of the event being run, or of the last one; kept here so that now() is inline
  std::unique_ptr<State> state_;
};

/// A waiting lane. It lives in the coroutine's frame, whose address does not change while it is suspended, so an await does
/// not allocate.
struct Scheduler::Suspended {
  Scheduler* scheduler = nullptr;
  EventName name;
  std::coroutine_handle<Task::promise_type> handle = nullptr;
  Arrival arrival = {};
  Completion* completion = nullptr;  ///< that of the started work, if any; owned by the scheduler's pool
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

// Inline, so that an awaitable is constructed in place in the frame of its lane.
inline Scheduler::Until Scheduler::until(RealTime at, Lane lane, EventName name) noexcept {
  return {{this, name}, at, lane};
}
inline Scheduler::Until Scheduler::turn(Lane lane, EventName name) noexcept { return until(now_, lane, name); }
inline Scheduler::External Scheduler::external(RealTime programmed_end, Work* work, EventName name) noexcept {
  return {{this, name}, programmed_end, work};
}

static_assert(std::is_trivially_copyable_v<Scheduler::Until> && std::is_trivially_copyable_v<Scheduler::External>,
              "g++ 12 destroys non-trivial temporaries inside co_await twice");

}  // namespace evenstep
