#include <csignal>
#include <set>
#include <stdexcept>

#include "rig.h"

namespace evenstep::test {
namespace {

// ---- Time

Task watch_time(Scheduler& scheduler, VirtualClock& clock, int& checked) {
  for (int k = 0; k < 100; ++k) {
    const RealTime due{k * k * 37};
    const Arrival arrival = co_await scheduler.until(due, Lane::device, "tick");
    CHECK(scheduler.now() == due);
    CHECK(scheduler.live_now() == due);
    CHECK(clock.now() == due);
    CHECK(arrival.scheduled == due);
    CHECK(arrival.actual == due);
    CHECK(arrival.lateness() == Duration{0});
    ++checked;
  }
}

TEST_CASE("Under a virtual clock now(), the live clock and both times of the arrival are the event's key time") {
  VirtualRig rig;
  int checked = 0;
  rig.scheduler.spawn(watch_time(rig.scheduler, rig.clock, checked));
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK(checked == 100);
}

// ---- External work

Task one_external(Scheduler& scheduler, RealTime start, RealTime programmed_end, Work* work, Arrival& arrival) {
  co_await scheduler.until(start, Lane::launch, "start");
  const Arrival done = co_await scheduler.external(programmed_end, work, "work");
  arrival = done;
}

TEST_CASE(
    "Work under a virtual clock ends at the later of its programmed end and now(), in the completion lane, with and without "
    "work") {
  CountingWork work;
  for (const bool with_work : {true, false}) {
    for (const std::int64_t end_ns : {-5, 0, 99, 100, 101, 1'000'000}) {
      VirtualRig rig;
      Arrival arrival;
      work.runs = 0;
      rig.scheduler.spawn(one_external(rig.scheduler, {100}, {end_ns}, with_work ? &work : nullptr, arrival));
      rig.scheduler.run(kNever);
      CAPTURE(end_ns, with_work);
      CHECK(arrival.scheduled == RealTime{std::max<std::int64_t>(end_ns, 100)});
      CHECK(arrival.actual == arrival.scheduled);
      CHECK(work.runs == (with_work ? 1 : 0));
      REQUIRE(rig.scheduler.events().size() == 2);
      CHECK(rig.scheduler.events()[1].lane == Lane::completion);
    }
  }
}

/// Finishes work only when somebody waits for it, as a GPU might.
struct LazyExecutor final : Executor {
  std::set<Completion*> seen;
  int waits = 0;
  void start(Completion& completion) override { seen.insert(&completion); }
  void wait(Completion& completion) override {
    ++waits;
    completion.work->run();
    completion.done = true;
  }
};

Task read_results(Scheduler& scheduler, CountingWork& work, int count, std::vector<int>& results) {
  for (int n = 1; n <= count; ++n) {
    co_await scheduler.external({n * 1000}, &work, "work");
    results.push_back(work.runs);
  }
}

TEST_CASE("Virtual time reaches a programmed end only when the real result is there") {
  VirtualClock clock;
  LazyExecutor executor;
  Scheduler scheduler(clock, executor);
  CountingWork work;
  std::vector<int> results;
  scheduler.spawn(read_results(scheduler, work, 3, results));
  CHECK(work.runs == 0);
  REQUIRE(scheduler.run_one());
  CHECK(results == std::vector<int>{1});
  scheduler.run(kNever);
  CHECK(results == std::vector<int>{1, 2, 3});
}

Task work_and_rest(Scheduler& scheduler, CountingWork& work, int count) {
  for (int n = 1; n <= count; ++n) {
    co_await scheduler.external({n * 1000}, &work, "work");
    co_await scheduler.until({n * 1000 + 500}, Lane::launch, "rest");  // no work of any lane is left when the next begins
  }
}

TEST_CASE("Completions are pooled: as many as work was ever outstanding at once") {
  for (const int lanes : {1, 2, 7}) {
    VirtualClock clock;
    LazyExecutor executor;
    std::vector<CountingWork> works(static_cast<std::size_t>(lanes));
    Scheduler scheduler(clock, executor);
    for (CountingWork& work : works) scheduler.spawn(work_and_rest(scheduler, work, 200));
    scheduler.run(kNever);
    CHECK(executor.waits == 200 * lanes);
    CHECK(executor.seen.size() == works.size());
  }
}

TEST_CASE("run() returns only when the work it started is done, and the next run() hears of it at its programmed end") {
  VirtualClock clock;
  LazyExecutor executor;
  Scheduler scheduler(clock, executor);
  CountingWork work;
  std::vector<int> results;
  scheduler.spawn(read_results(scheduler, work, 1, results));
  CHECK(scheduler.run({500}).end == RunEnd::reached_end);
  CHECK(work.runs == 1);
  CHECK(results.empty());
  CHECK(scheduler.run(kNever).end == RunEnd::idle);
  CHECK(executor.waits == 1);
  CHECK(results == std::vector<int>{1});
}

struct Guard {
  int& alive;
  explicit Guard(int& a) : alive(a) { ++alive; }
  ~Guard() { --alive; }
};
Task guarded(Scheduler& scheduler, CountingWork& work, int& alive) {
  const Guard guard(alive);
  co_await scheduler.external({1000}, &work, "work");
  co_await scheduler.until(kNever, Lane::device, "never");
}

TEST_CASE("The destructor waits for outstanding work, then destroys the frames of unfinished lanes") {
  CountingWork work;
  int alive = 0;
  LazyExecutor executor;
  {
    VirtualClock clock;
    Scheduler scheduler(clock, executor);
    scheduler.spawn(guarded(scheduler, work, alive));
    CHECK(alive == 1);
    CHECK(work.runs == 0);
  }
  CHECK(work.runs == 1);
  CHECK(alive == 0);
}

// ---- Failure

struct SolverLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct FailingWork final : Work {
  void run() override { throw SolverLost("the device is gone"); }
};

Task caught(Scheduler& scheduler, Work& work, std::string& message) {
  try {
    co_await scheduler.external({10}, &work, "work");
  } catch (const SolverLost& lost) {
    message = lost.what();
  }
  co_await scheduler.until({20}, Lane::device, "after");
}

TEST_CASE("A lane can catch what its work threw and go on, with the same completion used again") {
  VirtualRig rig;
  FailingWork work;
  std::string message;
  rig.scheduler.spawn(caught(rig.scheduler, work, message));
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK(message == "the device is gone");
  CHECK(rig.scheduler.event_count() == 2);
}

TEST_CASE("What leaves a lane ends the run as failed, finally, with message and exception, earlier events are kept") {
  VirtualRig rig;
  FailingWork work;
  Arrival arrival;
  std::vector<int> log;
  rig.scheduler.spawn(mark(rig.scheduler, {50}, Lane::device, 1, log));
  rig.scheduler.spawn(one_external(rig.scheduler, {100}, {200}, &work, arrival));
  rig.scheduler.spawn(mark(rig.scheduler, {200}, Lane::device, 2, log));
  const RunStatus status = rig.scheduler.run(kNever);
  CHECK(status.end == RunEnd::failed);
  CHECK(status.message == "the device is gone");
  REQUIRE(status.failure);
  CHECK_THROWS_AS(std::rethrow_exception(status.failure), SolverLost);
  CHECK(log == std::vector<int>{1});
  CHECK(rig.scheduler.event_count() == 3);  // mark, start, and the completion that failed
  CHECK(rig.scheduler.run(kNever).end == RunEnd::failed);
  CHECK_FALSE(rig.scheduler.run_one());
  CHECK(rig.scheduler.status().message == "the device is gone");
  CHECK(rig.scheduler.event_count() == 3);
}

Task throws_at(Scheduler& scheduler, int at) {
  if (at > 0) {
    co_await scheduler.until({at}, Lane::device, "tick");
  }
  throw 42;
}

TEST_CASE("A lane that throws before its first await fails the run, also with what is no std::exception") {
  for (const int at : {0, 1}) {
    VirtualRig rig;
    rig.scheduler.spawn(throws_at(rig.scheduler, at));
    const RunStatus status = rig.scheduler.run(kNever);
    CHECK(status.end == RunEnd::failed);
    CHECK(status.message == "unknown exception");
    CHECK_THROWS_AS(std::rethrow_exception(status.failure), int);
    CHECK(rig.scheduler.event_count() == at);
  }
}

// ---- The end of a run

TEST_CASE("Nothing to do is idle, never a hang") {
  VirtualRig rig;
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK_FALSE(rig.scheduler.run_one());
  CHECK(rig.scheduler.status().end == RunEnd::idle);
  CHECK_FALSE(rig.scheduler.next());
}

Task wait_forever(Scheduler& scheduler) { co_await scheduler.until(kNever, Lane::device, "never"); }

TEST_CASE("An event that never comes lies after every end") {
  VirtualRig rig;
  rig.scheduler.spawn(wait_forever(rig.scheduler));
  CHECK(rig.scheduler.run(kNever).end == RunEnd::reached_end);
  CHECK_FALSE(rig.scheduler.run_one());
}

void spawn_mixed_lanes(VirtualRig& rig, std::vector<int>& log, std::vector<int>& results, CountingWork& work) {
  for (int i = 0; i < 9; ++i) rig.scheduler.spawn(mark(rig.scheduler, {i * 450}, static_cast<Lane>(i % 3), i, log));
  rig.scheduler.spawn(read_results(rig.scheduler, work, 4, results));
}

TEST_CASE(
    "run(end) runs what lies before end, and a later end goes on, split at any nanosecond it is the run in one piece") {
  std::vector<int> log, results;
  CountingWork work;
  VirtualRig whole;
  spawn_mixed_lanes(whole, log, results, work);
  CHECK(whole.scheduler.run(kNever).end == RunEnd::idle);
  for (std::int64_t split = 0; split <= 4001; ++split) {
    VirtualRig parts;
    std::vector<int> other_log, other_results;
    CountingWork other_work;
    spawn_mixed_lanes(parts, other_log, other_results, other_work);
    const RunEnd first = parts.scheduler.run({split}).end;
    REQUIRE(first == (split <= 4000 ? RunEnd::reached_end : RunEnd::idle));
    for (const Event& event : parts.scheduler.events()) REQUIRE(event.time < RealTime{split});
    REQUIRE((!parts.scheduler.next() || parts.scheduler.next()->time >= RealTime{split}));
    REQUIRE(parts.scheduler.run(kNever).end == RunEnd::idle);
    REQUIRE(parts.scheduler.trace_hash() == whole.scheduler.trace_hash());
  }
}

TEST_CASE("run_one() runs exactly the event that next() names") {
  VirtualRig rig;
  std::vector<int> log, results;
  CountingWork work;
  spawn_mixed_lanes(rig, log, results, work);
  for (std::int64_t count = 1; const auto key = rig.scheduler.next(); ++count) {
    REQUIRE(rig.scheduler.run_one());
    REQUIRE(rig.scheduler.event_count() == count);
    CHECK(rig.scheduler.events().back().time == key->time);
    CHECK(rig.scheduler.events().back().lane == key->lane);
  }
  CHECK(rig.scheduler.event_count() == 13);
  CHECK_FALSE(rig.scheduler.run_one());
}

// ---- Stopping

Task stops_at(Scheduler& scheduler, int stop_after, int& ran) {
  for (int k = 0;; ++k) {
    co_await scheduler.until({k * 10}, Lane::device, "tick");
    if (k == stop_after) scheduler.request_stop();
    ++ran;
  }
}

/// Asks at each of its events what comes next.
Task looks_ahead(Scheduler& scheduler, std::uint64_t seed, std::vector<std::optional<Scheduler::Key>>& announced) {
  for (std::uint64_t k = 0; k < 50; ++k) {
    co_await scheduler.until(scheduler.now() + Duration{draw(seed, k, 20)}, Lane::device, "tick");
    announced.push_back(scheduler.next());
  }
}

TEST_CASE("Inside an event next() is the first of the other lanes' events") {
  for (std::uint64_t lanes = 1; lanes <= 12; ++lanes) {
    VirtualRig rig;
    std::vector<std::optional<Scheduler::Key>> announced;
    std::vector<int> log;
    rig.scheduler.spawn(looks_ahead(rig.scheduler, 99, announced));
    for (std::uint64_t lane = 1; lane < lanes; ++lane) {
      for (std::uint64_t k = 0; k < 40; ++k)
        rig.scheduler.spawn(mark(rig.scheduler, {draw(lane, k, 500)}, Lane::launch, 0, log));
    }
    CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
    // Each event of the other lanes, in order, must be the last one that was announced before it.
    std::vector<RealTime> others;
    for (const Event& event : rig.scheduler.events()) {
      if (event.lane == Lane::launch) others.push_back(event.time);
    }
    std::size_t asked = 0, other = 0;
    for (const Event& event : rig.scheduler.events()) {
      if (event.lane == Lane::launch) {
        ++other;
        continue;
      }
      const std::optional<Scheduler::Key>& key = announced[asked++];
      REQUIRE(key.has_value() == (other < others.size()));
      if (key) CHECK(key->time == others[other]);
    }
    CHECK(asked == announced.size());
  }
}

TEST_CASE("A stop asked for in an event ends the run after that event, finally, and keeps what was finished") {
  for (int after = 0; after < 20; ++after) {
    VirtualRig rig;
    int ran = 0;
    rig.scheduler.spawn(stops_at(rig.scheduler, after, ran));
    CHECK(rig.scheduler.run(kNever).end == RunEnd::stopped);
    CHECK(ran == after + 1);
    CHECK(rig.scheduler.event_count() == after + 1);
    CHECK(rig.scheduler.run(kNever).end == RunEnd::stopped);
    CHECK(ran == after + 1);
  }
}

Scheduler* interrupted = nullptr;
void on_signal(int) { interrupted->request_stop(); }
Task raises(Scheduler& scheduler) {
  for (int k = 0;; ++k) {
    co_await scheduler.until({k * 10}, Lane::device, "tick");
    if (k == 3) std::raise(SIGUSR1);
  }
}

TEST_CASE("A signal handler may stop the run") {
  VirtualRig rig;
  interrupted = &rig.scheduler;
  auto* const previous = std::signal(SIGUSR1, on_signal);
  rig.scheduler.spawn(raises(rig.scheduler));
  CHECK(rig.scheduler.run(kNever).end == RunEnd::stopped);
  std::signal(SIGUSR1, previous);
  CHECK(rig.scheduler.event_count() == 4);
}

}  // namespace
}  // namespace evenstep::test
