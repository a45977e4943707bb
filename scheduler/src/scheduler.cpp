#include "evenstep/scheduler/scheduler.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <stdexcept>
#include <string>
#include <utility>

#include "src/completion_pool.h"
#include "src/event_queue.h"

namespace evenstep {

using internal::EventKey;
using internal::InFlight;

struct Scheduler::State {
  Scheduler& scheduler;
  Clock& clock;
  Executor& executor;
  const SchedulerOptions options;
  const bool is_virtual;

  std::vector<Task> tasks;
  internal::EventQueue queue;
  internal::TieOrder ties;
  internal::CompletionPool pool;
  internal::Inbox inbox;  // written by executors' threads
  // Set by a stop, which any thread may request, and by whatever ends a run for good: one check per event, not four.
  std::atomic<bool> interrupted{false};
  std::int64_t in_flight = 0;  // wall clock: started work whose completion is not in the queue yet

  RealTime& now;  // the scheduler's
  EventKey last{{}, Lane::completion, 0};
  bool running_event = false;
  bool spawning = false;
  std::uint64_t payload = 0;
  std::int64_t events_at_instant = 0;
  std::int64_t event_count = 0;
  std::uint64_t hash = 0;
  std::vector<Event> events;
  RunStatus status;

  State(Scheduler& s, Clock& c, Executor& e, SchedulerOptions o)
      : scheduler(s),
        clock(c),
        executor(e),
        options(std::move(o)),
        is_virtual(c.is_virtual()),
        ties(options.permute_ties),
        now(s.now_) {}

  RealTime live_now() const { return is_virtual ? now : clock.now(); }
  void refuse_inside_a_lane() const;
  bool over() const { return status.end == RunEnd::stopped || status.end == RunEnd::limit || status.end == RunEnd::failed; }

  bool within(std::int64_t count, std::int64_t limit, const char* limit_name, EventName event, RealTime at) {
    if (count > limit) exceeded(limit, limit_name, event, at);
    return count <= limit;
  }
  [[gnu::cold]] void exceeded(std::int64_t limit, const char* limit_name, EventName event, RealTime at);
  bool room_for(EventName event);
  void wake_at(RealTime at, Lane lane, Suspended& await);
  void launch(External& await);

  void run(RealTime end, std::int64_t most_events);
  void admit_completed();
  bool advance(RealTime end);
  bool stop_now();
  void run_next();
  void note_end_of(std::coroutine_handle<Task::promise_type> handle);
  void wait_for(InFlight& work);
  void drain();
};

void Scheduler::State::refuse_inside_a_lane() const {
  if (running_event || spawning) throw std::logic_error("a lane called run() or run_one() of the scheduler that runs it");
}

// ---- Limits

void Scheduler::State::exceeded(std::int64_t limit, const char* limit_name, EventName event, RealTime at) {
  if (over()) return;
  interrupted.store(true, std::memory_order_relaxed);
  status = {RunEnd::limit,
            std::string("limit ") + limit_name + " = " + std::to_string(limit) + " exceeded by event '" + event.text +
                "' at " + std::to_string(at.ns) + " ns",
            nullptr};
}

bool Scheduler::State::room_for(EventName event) {
  const std::int64_t pending = static_cast<std::int64_t>(queue.size()) + in_flight;
  return within(pending + 1, options.limits.pending_events, "pending_events", event, now);
}

// ---- What a lane asks for

[[gnu::always_inline]] inline void Scheduler::State::wake_at(RealTime at, Lane lane, Suspended& await) {
  if (room_for(await.name)) queue.push({std::max(at, now), lane, ties.next()}, await);
}

void Scheduler::State::launch(External& await) {
  if (await.work == nullptr) return wake_at(await.programmed_end, Lane::completion, await);
  if (!room_for(await.name)) return;
  InFlight& work = pool.take();
  work.work = await.work;
  work.lane = &await;
  work.programmed_end = await.programmed_end;
  work.sequence = ties.next();
  await.completion = &work;
  if (is_virtual) {
    queue.push({std::max(work.programmed_end, now), Lane::completion, work.sequence}, await);
  } else {
    work.home = &scheduler;
    ++in_flight;
  }
  executor.start(work);
}

// ---- The loop

/// Wall clock: finished work becomes an event at the later of its stamp and its programmed end. The sequence number is
/// that of its launch, as under a virtual clock, so that a replay of the recorded key times breaks ties the same way.
void Scheduler::State::admit_completed() {
  InFlight* next = nullptr;
  for (InFlight* work = inbox.take_all(); work != nullptr; work = next) {
    next = work->next;
    EventKey key{std::max({work->stamp, work->programmed_end, now}), Lane::completion, work->sequence};
    if (key < last) key = {now + Duration{1}, Lane::completion, work->sequence};
    queue.push(key, *work->lane);
    --in_flight;
  }
}

/// Waits until the next event with time < end is due: true. False when there is none, or the run is over.
[[gnu::always_inline]] inline bool Scheduler::State::advance(RealTime end) {
  for (;;) {
    if (inbox.any()) admit_completed();
    if (interrupted.load(std::memory_order_acquire)) return stop_now();
    const bool have_event = !queue.empty() && queue.top().key.time() < end;
    if (!have_event && in_flight == 0) {
      status = {queue.empty() ? RunEnd::idle : RunEnd::reached_end, {}, nullptr};
      return false;
    }
    if (clock.wait_until(have_event ? queue.top().key.time() : end) == Wake::notified) continue;
    if (have_event) break;
    drain();  // started work may still have been stamped before `end`
  }
  if (inbox.any()) admit_completed();  // work stamped before the event we waited for runs first
  const auto& [key, lane] = queue.top();
  events_at_instant = key.time() == now ? events_at_instant + 1 : 1;
  return within(events_at_instant, options.limits.events_per_instant, "events_per_instant", lane->name, key.time()) &&
         within(event_count + 1, options.limits.total_events, "total_events", lane->name, key.time());
}

/// False, with a status that says why.
[[gnu::cold]] bool Scheduler::State::stop_now() {
  if (!over()) status = {RunEnd::stopped, {}, nullptr};
  return false;
}

[[gnu::always_inline]] inline void Scheduler::State::run_next() {
  const EventKey key = queue.top().key;
  Suspended* const await = queue.top().lane;
  queue.take();
  now = key.time();
  payload = 0;
  if (is_virtual) {
    // Virtual time never outruns real work.
    if (await->completion != nullptr) wait_for(static_cast<InFlight&>(*await->completion));
    await->arrival = {key.time(), key.time()};
  } else {
    last = key;
    await->arrival = {key.time(), clock.now()};
  }
  const auto handle = await->handle;
  const EventName name = await->name;  // the await is gone when the lane is resumed

  running_event = true;
  handle.resume();
  running_event = false;
  queue.close_gap();  // the lane has ended, or its next event is not in the queue yet

  hash = chain(hash, {key.time(), key.lane(), name, payload});
  ++event_count;
  if (options.keep_events) events.push_back({key.time(), key.lane(), name, payload});
  if (handle.done()) note_end_of(handle);
}

/// Both halves of the loop are inlined: calling them would cost a tenth of an event's time.
void Scheduler::State::run(RealTime end, std::int64_t most_events) {
  for (std::int64_t i = 0; i < most_events && advance(end); ++i) run_next();
}

void Scheduler::State::note_end_of(std::coroutine_handle<Task::promise_type> handle) {
  if (!handle.promise().failure || over()) return;
  interrupted.store(true, std::memory_order_relaxed);
  status = {RunEnd::failed, "unknown exception", handle.promise().failure};
  try {
    std::rethrow_exception(status.failure);
  } catch (const std::exception& exception) {
    status.message = exception.what();
  } catch (...) {
  }
}

void Scheduler::State::wait_for(InFlight& work) {
  if (!work.done.load(std::memory_order_acquire)) executor.wait(work);
  assert(work.done.load(std::memory_order_acquire) && "Executor::wait returned before the work was done");
}

void Scheduler::State::drain() {
  for (InFlight& work : pool.entries()) wait_for(work);
}

// ---- The public face

Scheduler::Scheduler(Clock& clock, Executor& executor, SchedulerOptions options)
    : state_(std::make_unique<State>(*this, clock, executor, std::move(options))) {}
Scheduler::~Scheduler() {
  state_->drain();
  state_->tasks.clear();  // while the rest of the state exists: objects that end with a task may still ask for the time
}

RealTime Scheduler::live_now() const noexcept { return state_->live_now(); }

void Scheduler::wake_at(RealTime at, Lane lane, Suspended& await) noexcept { state_->wake_at(at, lane, await); }
void Scheduler::External::await_suspend(std::coroutine_handle<Task::promise_type> lane_handle) noexcept {
  handle = lane_handle;
  scheduler->state_->launch(*this);
}
Arrival Scheduler::External::await_resume() {
  if (completion != nullptr) {
    const std::exception_ptr failure = std::exchange(completion->failure, nullptr);
    scheduler->state_->pool.give_back(static_cast<InFlight&>(*std::exchange(completion, nullptr)));
    if (failure) std::rethrow_exception(failure);
  }
  return arrival;
}

void Scheduler::spawn(Task task) {
  if (state_->event_count != 0 || state_->running_event) throw std::logic_error("lanes start before the run");
  const auto handle = state_->tasks.emplace_back(std::move(task)).handle_;
  const bool is_nested = std::exchange(state_->spawning, true);
  handle.resume();
  state_->spawning = is_nested;
  if (handle.done()) state_->note_end_of(handle);
}

void Scheduler::note(std::uint64_t digest) noexcept {
  assert(state_->running_event && "only an event has a payload");
  state_->payload = mix(state_->payload, digest);
}
void Scheduler::note(double value) noexcept { note(std::bit_cast<std::uint64_t>(value)); }

RunStatus Scheduler::run(RealTime end) {
  state_->refuse_inside_a_lane();
  state_->run(end, INT64_MAX);
  state_->drain();
  return state_->status;
}

bool Scheduler::run_one() {
  state_->refuse_inside_a_lane();
  const std::int64_t before = state_->event_count;
  state_->run(kNever, 1);
  return state_->event_count > before;
}

std::optional<Scheduler::Key> Scheduler::next() const {
  state_->queue.close_gap();
  if (state_->queue.empty()) return std::nullopt;
  const EventKey key = state_->queue.top().key;
  return Key{key.time(), key.lane()};
}

RunStatus Scheduler::status() const { return state_->status; }
std::uint64_t Scheduler::trace_hash() const noexcept { return state_->hash; }
const std::vector<Event>& Scheduler::events() const noexcept { return state_->events; }
void Scheduler::reserve_events(std::size_t count) { state_->events.reserve(count); }
void Scheduler::take_events(std::vector<Event>& empty) noexcept {
  empty.clear();
  state_->events.swap(empty);
}
std::int64_t Scheduler::event_count() const noexcept { return state_->event_count; }

void Scheduler::completed(Completion& completion) noexcept {
  state_->inbox.push(static_cast<InFlight&>(completion));
  state_->clock.notify();
}

void Scheduler::request_stop() noexcept {
  state_->interrupted.store(true, std::memory_order_release);
  state_->clock.notify();
}

}  // namespace evenstep
