// The cost of one event of the scheduler in the hold model: every lane waits again and again for a pseudo-random time after
// its last event, so the number of pending events does not change. The trace hash is on, as always.
//   scripts/bench.sh scheduler
#include <benchmark/benchmark.h>

#include <coroutine>
#include <functional>
#include <memory>
#include <queue>
#include <tuple>
#include <vector>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/stepped_thread.h"
#include "src/event_queue.h"

namespace {

using namespace evenstep;

constexpr Duration kSlice{1'000'000};  ///< virtual time per run(), a few events per lane
constexpr std::int64_t kEventsKept = 1'000'000;

/// 0.1 to 1.15 ms, so that no two lanes are equal and ties are rare.
Duration next_delay(std::uint64_t& state) {
  state = state * 6364136223846793005ULL + 1442695040888963407ULL;
  return {100'000 + static_cast<std::int64_t>(state >> 44)};
}

Task hold(Scheduler& scheduler, std::uint64_t seed) {
  for (std::uint64_t state = spread(seed);;) {
    co_await scheduler.until(scheduler.now() + next_delay(state), Lane::device, "tick");
  }
}

void events(benchmark::State& state, bool keep_events) {
  InlineExecutor executor;
  std::int64_t count = 0;
  double kept_bytes = 0;
  for (bool more = true; more;) {
    VirtualClock clock;
    Scheduler scheduler(clock, executor, {.keep_events = keep_events});
    for (int lane = 0; lane < state.range(0); ++lane) scheduler.spawn(hold(scheduler, static_cast<std::uint64_t>(lane)));
    RealTime end{0};
    while (scheduler.event_count() < kEventsKept && (more = state.KeepRunning())) scheduler.run(end = end + kSlice);
    count += scheduler.event_count();
    kept_bytes += static_cast<double>(scheduler.events().capacity() * sizeof(Event));
    benchmark::DoNotOptimize(scheduler.trace_hash());
  }
  state.counters["s_per_event"] =
      benchmark::Counter(static_cast<double>(count), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["bytes_per_event"] = kept_bytes / static_cast<double>(count);
}
BENCHMARK_CAPTURE(events, hash_only, false)->Arg(2)->Arg(8)->Arg(20)->Arg(1'000);
BENCHMARK_CAPTURE(events, hash_and_kept, true)->Arg(2)->Arg(8)->Arg(20)->Arg(1'000);

/// The same lanes as blocking loops, each on its own thread, to see what handing over to a thread and back costs. Measured
/// are the CPU time of the whole process and real time.
void blocking_loops(benchmark::State& state) {
  InlineExecutor executor;
  VirtualClock clock;
  Scheduler scheduler(clock, executor, {.keep_events = false});
  std::vector<std::unique_ptr<SteppedThread>> loops;
  for (std::int64_t lane = 0; lane < state.range(0); ++lane) {
    loops.push_back(std::make_unique<SteppedThread>(scheduler, SteppedThreadOptions{.name = "tick", .lane = Lane::device},
                                                    [lane](BlockingClock& time) {
                                                      std::uint64_t draws = spread(static_cast<std::uint64_t>(lane));
                                                      for (;;) time.sleep_until(time.now() + next_delay(draws));
                                                    }));
  }
  for (auto _ : state) scheduler.run_one();
}
BENCHMARK(blocking_loops)->Arg(2)->Arg(8)->MeasureProcessCPUTime();

/// The yardstick: the same lanes, queue and hash in the smallest loop that can run them. It has no limits, external work,
/// stop or arrival times, and no clock behind an interface.
class LeanCore {
 public:
  struct Lane {
    struct promise_type {
      Lane get_return_object() { return {std::coroutine_handle<promise_type>::from_promise(*this)}; }
      std::suspend_never initial_suspend() noexcept { return {}; }
      std::suspend_always final_suspend() noexcept { return {}; }
      void return_void() {}
      void unhandled_exception() {}
    };
    std::coroutine_handle<promise_type> handle;
  };
  struct Until : Scheduler::Suspended {
    LeanCore* core = nullptr;
    RealTime at;
    bool await_ready() const noexcept { return false; }
    void await_suspend(std::coroutine_handle<> lane) noexcept {
      handle = std::coroutine_handle<Task::promise_type>::from_address(lane.address());
      core->queue_.push({at, evenstep::Lane::device, ++core->sequence_}, *this);
    }
    void await_resume() const noexcept {}
  };

  ~LeanCore() {
    for (const Lane& lane : lanes_) lane.handle.destroy();
  }
  void spawn(Lane lane) { lanes_.push_back(lane); }
  RealTime now() const { return now_; }
  Until until(RealTime at, EventName name) { return {{nullptr, name}, this, at}; }
  void run_one() {
    const internal::EventKey key = queue_.top().key;
    Scheduler::Suspended* const await = queue_.top().lane;
    queue_.take();
    now_ = key.time();
    const EventName name = await->name;
    await->handle.resume();
    queue_.close_gap();
    hash_ = chain(hash_, {now_, key.lane(), name, 0});
  }
  std::uint64_t hash() const { return hash_; }

 private:
  internal::EventQueue queue_;
  std::vector<Lane> lanes_;
  RealTime now_;
  std::uint64_t sequence_ = 0, hash_ = 0;
};

LeanCore::Lane hold(LeanCore& core, std::uint64_t seed) {
  for (std::uint64_t state = spread(seed);;) co_await core.until(core.now() + next_delay(state), "tick");
}

void lean_core(benchmark::State& state) {
  LeanCore core;
  for (int lane = 0; lane < state.range(0); ++lane) core.spawn(hold(core, static_cast<std::uint64_t>(lane)));
  for (auto _ : state) core.run_one();
  benchmark::DoNotOptimize(core.hash());
}
BENCHMARK(lean_core)->Arg(2)->Arg(8)->Arg(20)->Arg(1'000);

/// For comparison: the priority queue of the standard library with a std::function per event, without hash, limits or clock.
void std_queue(benchmark::State& state) {
  struct Timer {
    std::int64_t at_ns;
    std::uint64_t sequence;
    std::function<void()> run;
    bool operator<(const Timer& other) const { return std::tie(other.at_ns, other.sequence) < std::tie(at_ns, sequence); }
  };
  std::priority_queue<Timer> queue;
  std::uint64_t sequence = 0;
  std::vector<std::uint64_t> draws;
  for (std::int64_t lane = 0; lane < state.range(0); ++lane) draws.push_back(spread(static_cast<std::uint64_t>(lane)));
  std::function<void(std::size_t, std::int64_t)> arm = [&](std::size_t lane, std::int64_t now_ns) {
    const std::int64_t at_ns = now_ns + next_delay(draws[lane]).ns;
    queue.push({at_ns, ++sequence, [&arm, lane, at_ns] { arm(lane, at_ns); }});
  };
  for (std::size_t lane = 0; lane < draws.size(); ++lane) arm(lane, 0);
  for (auto _ : state) {
    const Timer timer = queue.top();
    queue.pop();
    timer.run();
  }
}
BENCHMARK(std_queue)->Arg(2)->Arg(8)->Arg(20)->Arg(1'000);

/// The lower limit: the same number of lanes resumed one after the other, each with its draw, without a queue and an order.
struct Turn {
  struct promise_type {
    Turn get_return_object() { return {std::coroutine_handle<promise_type>::from_promise(*this)}; }
    std::suspend_never initial_suspend() noexcept { return {}; }
    std::suspend_always final_suspend() noexcept { return {}; }
    void return_void() {}
    void unhandled_exception() {}
  };
  std::coroutine_handle<promise_type> handle;
};
Turn draw_in_turn(std::uint64_t seed, std::int64_t& at_ns) {
  for (std::uint64_t state = spread(seed);;) {
    at_ns += next_delay(state).ns;
    co_await std::suspend_always{};
  }
}
void resumed_in_turn(benchmark::State& state) {
  std::int64_t at_ns = 0;
  std::vector<Turn> lanes;
  for (std::int64_t lane = 0; lane < state.range(0); ++lane)
    lanes.push_back(draw_in_turn(static_cast<std::uint64_t>(lane), at_ns));
  std::size_t next = 0;
  for (auto _ : state) {
    lanes[next].handle.resume();
    if (++next == lanes.size()) next = 0;
  }
  benchmark::DoNotOptimize(at_ns);
  for (const Turn& lane : lanes) lane.handle.destroy();
}
BENCHMARK(resumed_in_turn)->Arg(8)->Arg(1'000);

// Parts of an event.
void chained_hash(benchmark::State& state) {
  std::uint64_t hash = 0;
  Event event{{0}, Lane::device, "tick", 0};
  for (auto _ : state) {
    event.time = event.time + Duration{1'000};
    hash = chain(hash, event);
  }
  benchmark::DoNotOptimize(hash);
}
BENCHMARK(chained_hash);

void virtual_wait(benchmark::State& state) {
  VirtualClock virtual_clock;
  Clock* clock = &virtual_clock;
  benchmark::DoNotOptimize(clock);
  RealTime at{0};
  for (auto _ : state) benchmark::DoNotOptimize(clock->wait_until(at = at + Duration{1'000}));
}
BENCHMARK(virtual_wait);

}  // namespace

BENCHMARK_MAIN();
