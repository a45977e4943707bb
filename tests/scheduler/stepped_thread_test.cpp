#include "evenstep/scheduler/stepped_thread.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "evenstep/scheduler/live_lanes.h"
#include "evenstep/scheduler/loop_clock.h"
#include "rig.h"
#include "wall_test_clock.h"

namespace evenstep::test {
namespace {

using Catch::Contains;

constexpr Lane kSteppedLanes[] = {Lane::completion, Lane::device, Lane::launch};
constexpr EventName kName = "turn";

// ---- The same loop as a coroutine and as a plain loop

struct Turn {
  Duration delay;
  Lane lane;
};
/// Delays of -2 to 3 ns: most instants have several events, and some lie in the past.
std::vector<Turn> random_turns(std::uint64_t seed, std::uint64_t who) {
  std::vector<Turn> turns;
  for (std::uint64_t n = 0; n < 8; ++n) {
    turns.push_back({{draw(seed * 16 + who, 2 * n, 6) - 2}, kSteppedLanes[draw(seed * 16 + who, 2 * n + 1, 3)]});
  }
  return turns;
}

/// What all loops read and write, without a lock. The thread sanitizer would notice if two loops ran at once.
struct Shared {
  Scheduler& scheduler;
  std::uint64_t state = 1;
  void take_turn(std::uint64_t who) {
    state = mix(mix(state, who), static_cast<std::uint64_t>(scheduler.now().ns));
    scheduler.note(state);
  }
};

Task as_coroutine(Scheduler& scheduler, const std::vector<Turn>& turns, std::uint64_t who, Shared& shared) {
  for (const Turn& turn : turns) {
    co_await scheduler.until(scheduler.now() + turn.delay, turn.lane, kName);
    shared.take_turn(who);
  }
}
void as_it_is(BlockingClock& clock, const std::vector<Turn>& turns, std::uint64_t who, Shared& shared) {
  for (const Turn& turn : turns) {
    clock.sleep_until(clock.now() + turn.delay, turn.lane);
    shared.take_turn(who);
  }
}
Task steps_beside(Scheduler& scheduler, WorkerExecutor* worker, Shared& shared) {
  CountingWork work;
  for (std::int64_t n = 1; n <= 5; ++n) {
    co_await scheduler.external({2 * n}, worker == nullptr ? nullptr : &work, "step");
    shared.take_turn(99);
  }
}

struct Trace {
  std::uint64_t hash = 0;
  std::vector<Event> events;
  RunEnd end = RunEnd::idle;
};
/// Lane i is a thread if bit i of `threads` is set.
Trace trace_of(std::uint64_t seed, std::uint64_t lanes, std::uint64_t threads, std::optional<std::uint64_t> permute_ties) {
  VirtualClock clock;
  WorkerExecutor worker(clock);
  Scheduler scheduler(clock, worker, {.permute_ties = permute_ties});
  Shared shared{scheduler};
  std::vector<std::vector<Turn>> turns;
  for (std::uint64_t i = 0; i < lanes; ++i) turns.push_back(random_turns(seed, i));
  std::vector<std::unique_ptr<SteppedThread>> loops;
  scheduler.spawn(steps_beside(scheduler, &worker, shared));
  for (std::uint64_t i = 0; i < lanes; ++i) {
    if ((threads >> i & 1) == 0) {
      scheduler.spawn(as_coroutine(scheduler, turns[i], i, shared));
    } else {
      loops.push_back(std::make_unique<SteppedThread>(scheduler, SteppedThreadOptions{.name = kName},
                                                      [&, i](BlockingClock& time) { as_it_is(time, turns[i], i, shared); }));
    }
  }
  scheduler.run({draw(seed, 1000, 8)});  // a run in two parts, the first of which ends where loops sleep
  const RunStatus status = scheduler.run(kNever);
  return {scheduler.trace_hash(), scheduler.events(), status.end};
}

TEST_CASE("Loops on threads and the same loops as coroutines give the same trace, 300 random schedules of 1 to 5 loops") {
  std::set<std::uint64_t> hashes;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const auto lanes = static_cast<std::uint64_t>(1 + draw(seed, 2000, 5));
    const auto some = static_cast<std::uint64_t>(1 + draw(seed, 2001, (std::int64_t{1} << lanes) - 1));
    const auto ties = seed % 2 == 0 ? std::nullopt : std::optional(seed);
    const Trace expected = trace_of(seed, lanes, 0, ties);
    const Trace trace = trace_of(seed, lanes, some, ties);
    CAPTURE(seed, lanes, some);
    REQUIRE(trace.end == RunEnd::idle);
    REQUIRE(trace.events.size() == 5 + 8 * lanes);
    REQUIRE(trace.hash == expected.hash);
    hashes.insert(trace.hash);
  }
  CHECK(hashes.size() == 300);  // the schedules really differ
}

TEST_CASE("At one instant completions run before device events before launches, whether loops or coroutines ask for them") {
  for (int threads = 0; threads < 64; ++threads) {
    VirtualRig rig;
    std::vector<int> log;
    std::vector<std::unique_ptr<SteppedThread>> loops;
    for (int i = 0; i < 6; ++i) {
      const Lane lane = kSteppedLanes[2 - i % 3];
      if ((threads >> i & 1) == 0) {
        rig.scheduler.spawn(mark(rig.scheduler, {1000}, lane, i, log));
      } else {
        loops.push_back(std::make_unique<SteppedThread>(rig.scheduler, SteppedThreadOptions{.name = "mark", .lane = lane},
                                                        [&, i](BlockingClock& time) {
                                                          time.sleep_until({1000});
                                                          log.push_back(i);
                                                        }));
      }
    }
    REQUIRE(rig.scheduler.run(kNever).end == RunEnd::idle);
    REQUIRE(log == std::vector<int>{2, 5, 1, 4, 0, 3});
  }
}

TEST_CASE("Under a virtual clock a loop's time stands still between two sleeps, and is the time it slept until") {
  VirtualRig rig;
  std::vector<RealTime> seen;
  SteppedThread loop(rig.scheduler, {}, [&](BlockingClock& time) {
    seen.push_back(time.now());
    for (const std::int64_t ns : {50, 20, 70}) {
      time.sleep_until({ns});
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      seen.push_back(time.now());
    }
  });
  CHECK(seen == std::vector<RealTime>{{0}});
  rig.scheduler.run(kNever);
  CHECK(seen == std::vector<RealTime>{{0}, {50}, {50}, {70}});
}

// ---- The end of a run

struct LogsEnd {
  std::vector<std::string>& log;
  std::string who;
  ~LogsEnd() { log.push_back(who); }
};

void endless(BlockingClock& time, std::vector<std::string>& log, const std::string& who) {
  const LogsEnd last{log, who};
  for (std::int64_t k = 0;; ++k) {
    try {
      time.sleep_until({k * 100});
    } catch (const std::exception&) {  // as in loops that survive a lost device; Stopped is not a std::exception
    }
  }
}

TEST_CASE(
    "A loop sleeps on between two runs, and is left with its destructors when its thread or the scheduler is destroyed") {
  for (const bool scheduler_first : {false, true}) {
    std::vector<std::string> log;
    auto rig = std::make_unique<VirtualRig>();
    auto a = std::make_unique<SteppedThread>(rig->scheduler, SteppedThreadOptions{.name = "a"},
                                             [&](BlockingClock& time) { endless(time, log, "a"); });
    auto b = std::make_unique<SteppedThread>(rig->scheduler, SteppedThreadOptions{.name = "b"},
                                             [&](BlockingClock& time) { endless(time, log, "b"); });
    CHECK(rig->scheduler.run({1000}).end == RunEnd::reached_end);
    CHECK(rig->scheduler.run({2000}).end == RunEnd::reached_end);
    CHECK(rig->scheduler.event_count() == 40);
    CHECK(log.empty());
    if (scheduler_first) rig.reset();
    b.reset();
    a.reset();
    CHECK(log == (scheduler_first ? std::vector<std::string>{"a", "b"} : std::vector<std::string>{"b", "a"}));
  }
}

TEST_CASE("A run goes on without a loop whose thread was destroyed") {
  VirtualRig rig;
  std::vector<std::string> log;
  std::vector<int> marks;
  rig.scheduler.spawn(mark(rig.scheduler, {500}, Lane::device, 1, marks));
  {
    const SteppedThread loop(rig.scheduler, {}, [&](BlockingClock& time) { endless(time, log, "loop"); });
    rig.scheduler.run({150});
  }
  CHECK(log == std::vector<std::string>{"loop"});
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK(marks == std::vector<int>{1});
}

TEST_CASE("A loop that was stopped gets Stopped at every sleep, but in a destructor on its way out it just does not sleep") {
  struct SleepsAtEnd {
    BlockingClock& time;
    std::vector<std::string>& log;
    ~SleepsAtEnd() {
      time.sleep_until(time.now() + Duration{1000});
      log.push_back("destructor");
    }
  };
  VirtualRig rig;
  std::vector<std::string> log;
  {
    const SteppedThread loop(rig.scheduler, {}, [&](BlockingClock& time) {
      const SleepsAtEnd at_end{time, log};
      for (int i = 0; i < 3; ++i) {
        try {
          time.sleep_until({1000});
        } catch (...) {
          log.push_back("caught at " + std::to_string(time.now().ns));
        }
      }
      time.sleep_until({2000});
    });
    rig.scheduler.run({500});
  }
  CHECK(log == std::vector<std::string>{"caught at 0", "caught at 0", "caught at 0", "destructor"});
}

TEST_CASE("A loop that was never stepped again after its first sleep, or never sleeps, ends without a run") {
  std::vector<std::string> log;
  {
    VirtualRig rig;
    const SteppedThread sleeping(rig.scheduler, {}, [&](BlockingClock& time) { endless(time, log, "sleeping"); });
    const SteppedThread short_one(rig.scheduler, {}, [&](BlockingClock&) { log.push_back("short"); });
  }
  CHECK(log == std::vector<std::string>{"short", "sleeping"});
}

// ---- Errors

TEST_CASE("An exception that leaves a loop ends the run and reaches its caller, before the first sleep and after it") {
  for (const std::int64_t at_ns : {-1, 700}) {
    VirtualRig rig;
    std::vector<std::string> log;
    const SteppedThread other(rig.scheduler, {}, [&](BlockingClock& time) { endless(time, log, "other"); });
    const SteppedThread loop(rig.scheduler, {.name = "arm"}, [&](BlockingClock& time) {
      if (at_ns >= 0) time.sleep_until({at_ns});
      throw std::domain_error("cable lost");
    });
    const RunStatus status = rig.scheduler.run({1000});
    CHECK(status.end == RunEnd::failed);
    CHECK(status.message == "cable lost");
    CHECK_THROWS_AS(std::rethrow_exception(status.failure), std::domain_error);
    CHECK(rig.scheduler.now() == RealTime{std::max<std::int64_t>(at_ns, 0)});
  }
}

TEST_CASE("A loop that waits for something else than its clock ends the run with its name, and ends once it is let go") {
  VirtualRig rig;
  std::mutex held;
  std::atomic<bool> left{false};
  const auto waits = [&](BlockingClock& time) {
    time.sleep_until({300});
    held.lock();
    held.unlock();
    try {
      time.sleep_until({400});
    } catch (const Stopped&) {
      left = true;
      throw;
    }
  };
  RunStatus status;
  {
    const SteppedThread loop(rig.scheduler, {.name = "simulation", .real_time_limit = Duration{50'000'000}}, waits);
    held.lock();
    status = rig.scheduler.run(kNever);
    held.unlock();
  }
  CHECK(status.end == RunEnd::failed);
  CHECK_THAT(status.message, Contains("the stepped thread 'simulation' did not come back to sleep_until() within 50 ms of "
                                      "real time, at 300 ns: it spins, or waits for something else than its clock"));
  CHECK(left);
}

TEST_CASE("Without a limit, or with the longest, a step may take as long as it likes") {
  for (const std::optional<Duration> limit : {std::optional<Duration>(), std::optional(Duration{INT64_MAX})}) {
    VirtualRig rig;
    const SteppedThread loop(rig.scheduler, {.real_time_limit = limit}, [](BlockingClock& time) {
      time.sleep_until({10});
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      time.sleep_until({20});
    });
    CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  }
}

TEST_CASE("A stepped thread cannot start another, run its own scheduler, or lend its clock to another thread") {
  const auto failure_of = [](const std::function<void(Scheduler&, BlockingClock&)>& body, bool at_once) {
    VirtualRig rig;
    const SteppedThread loop(rig.scheduler, {.name = "outer"}, [&](BlockingClock& time) {
      if (!at_once) time.sleep_until({10});
      body(rig.scheduler, time);
    });
    const RunStatus status = rig.scheduler.run(kNever);
    CHECK(status.end == RunEnd::failed);
    return status.message;
  };
  for (const bool at_once : {true, false}) {
    CHECK_THAT(failure_of([](Scheduler& s, BlockingClock&) { SteppedThread(s, {}, [](BlockingClock&) {}); }, at_once),
               Contains("a stepped thread cannot start another"));
    CHECK_THAT(failure_of([](Scheduler& s, BlockingClock&) { s.run(kNever); }, at_once), Contains("called run()"));
    CHECK_THAT(failure_of([](Scheduler& s, BlockingClock&) { s.run_one(); }, at_once), Contains("called run()"));
    CHECK_THAT(failure_of(
                   [](Scheduler&, BlockingClock& time) {
                     LaneThread other([&] { time.sleep_until({20}); });
                     other.join();
                   },
                   at_once),
               Contains("'outer': its clock was asked to sleep by another thread"));
  }
}

TEST_CASE("A loop that asks for the present forever is a livelock, found by the scheduler's limit") {
  VirtualRig rig({.limits = {.events_per_instant = 1000}});
  const SteppedThread loop(rig.scheduler, {.name = "poll"}, [](BlockingClock& time) {
    for (;;) time.sleep_until({0});
  });
  const RunStatus status = rig.scheduler.run(kNever);
  CHECK(status.end == RunEnd::limit);
  CHECK_THAT(status.message, Contains("'poll'"));
}

TEST_CASE("A thread that starts after the run has begun is refused") {
  VirtualRig rig;
  std::vector<int> log;
  rig.scheduler.spawn(mark(rig.scheduler, {10}, Lane::device, 1, log));
  rig.scheduler.run(kNever);
  CHECK_THROWS_WITH(SteppedThread(rig.scheduler, {}, [](BlockingClock&) {}), "lanes start before the run");
}

// ---- Real time

TEST_CASE("A scheduler on a wall clock steps a loop not before its time") {
  const auto clock = make_wall_clock();
  InlineExecutor executor;
  Scheduler scheduler(*clock, executor);
  int late = 0, count = 0;
  const SteppedThread loop(scheduler, {}, [&](BlockingClock& time) {
    for (int k = 1; k <= 20; ++k) {
      const RealTime due = RealTime{k * 500'000};
      time.sleep_until(due);
      late += time.now() >= due ? 1 : 0;
      ++count;
    }
  });
  CHECK(scheduler.run(kNever).end == RunEnd::idle);
  CHECK(count == 20);
  CHECK(late == 20);
}

TEST_CASE("The wall's clock for a loop sleeps until it is time, returns at once if that has passed, and stops at its end") {
  const WallEpoch epoch = WallEpoch::in({0});
  WallBlockingClock endless_time(epoch);
  endless_time.sleep_until({2'000'000});
  CHECK(endless_time.now() >= RealTime{2'000'000});
  endless_time.sleep_until({1'000'000}, Lane::device);

  WallBlockingClock time(epoch, {5'000'000});
  CHECK_THROWS_AS(time.sleep_until({5'000'000}), Stopped);
  CHECK(time.now() >= RealTime{5'000'000});
  CHECK_THROWS_AS(time.sleep_until({1'000'000}), Stopped);  // the end has passed
  CHECK_THROWS_AS(time.sleep_until(kNever), Stopped);
}

TEST_CASE("A loop on the wall's clock that sleeps for ever is stopped from another thread, and stays stopped") {
  WallBlockingClock time(WallEpoch::in({0}));
  bool stopped_twice = false;
  LaneThread loop([&] {
    try {
      time.sleep_until(kNever);
    } catch (const Stopped&) {
      try {
        time.sleep_until({0});
      } catch (const Stopped&) {
        stopped_twice = true;
      }
    }
  });
  time.request_stop();
  loop.join();
  CHECK(stopped_twice);
}

TEST_CASE("A wall thread's loop ends with its thread, or at its end, and join() rethrows what else has left it") {
  std::vector<std::string> log;
  const WallEpoch epoch = WallEpoch::in({0});
  {
    const WallThread loop(epoch, kNever, [&](BlockingClock& time) { endless(time, log, "endless"); });
  }
  CHECK(log == std::vector<std::string>{"endless"});
  WallThread until_end(epoch, {1'000'000}, [&](BlockingClock& time) { endless(time, log, "until its end"); });
  until_end.join();
  CHECK(log.back() == "until its end");
  WallThread failing(epoch, kNever, [](BlockingClock&) { throw std::domain_error("cable lost"); });
  CHECK_THROWS_WITH(failing.join(), "cable lost");
}

// ---- As a clock of std::chrono

template <class Clock>
void chrono_loop(std::vector<std::int64_t>& seen) {
  static_assert(Clock::is_steady && std::is_same_v<typename Clock::time_point::clock, Clock>);
  static_assert(
      std::is_same_v<typename Clock::time_point::duration, typename Clock::duration> &&
      std::is_same_v<std::chrono::duration<typename Clock::rep, typename Clock::period>, typename Clock::duration>);
  auto next = Clock::now();
  for (int k = 0; k < 3; ++k) {
    Clock::sleep_until(next += std::chrono::milliseconds(1));
    seen.push_back(Clock::now().time_since_epoch().count());
  }
}

TEST_CASE("A loop that takes its clock as a type runs in virtual and in real time, and nowhere else") {
  std::vector<std::int64_t> seen, seen_late;
  VirtualRig rig;
  const SteppedThread loop(rig.scheduler, {}, [&](BlockingClock&) { chrono_loop<LoopClock>(seen); });
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK(seen == std::vector<std::int64_t>{1'000'000, 2'000'000, 3'000'000});

  WallThread in_real_time(WallEpoch::in({0}), kNever, [&](BlockingClock&) { chrono_loop<LoopClock>(seen_late); });
  in_real_time.join();
  REQUIRE(seen_late.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK(seen_late[k] >= seen[k]);

  CHECK_THROWS_AS(LoopClock::now(), std::logic_error);
  CHECK_THROWS_AS(LoopClock::sleep_until({}), std::logic_error);
}

}  // namespace
}  // namespace evenstep::test
