// Cost of one event of the scheduler, in the hold model: every lane waits, again and again, for a pseudo-random time after
// its last event, so the number of pending events stays what it is. Trace hash on, as always.
//   build/bench/bench_scheduler_events --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true
#include <benchmark/benchmark.h>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/scheduler/scheduler.h"

namespace {

using namespace evenstep;

constexpr Duration kSlice{1'000'000};  ///< of virtual time per run(): a few events per lane
constexpr std::int64_t kEventsKept = 1'000'000;

/// 0.1 to 1.15 ms: never two equal lanes, hardly ever a tie.
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

// Parts of it.
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
