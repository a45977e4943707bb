#include <algorithm>
#include <chrono>
#include <thread>

#include "evenstep/scheduler/live_lanes.h"
#include "rig.h"
#include "wall_test_clock.h"

namespace evenstep::test {
namespace {

struct SleepingWork final : Work {
  std::chrono::microseconds length{0};
  int runs = 0;
  void run() override {
    std::this_thread::sleep_for(length);
    ++runs;
  }
};

// ---- One body on both clocks

struct Arrivals {
  std::vector<Arrival> of_timers;
  std::vector<Arrival> of_work;
  std::vector<RealTime> programmed_ends;
};

Task timers(Scheduler& scheduler, int count, Arrivals& arrivals) {
  for (int k = 0; k < count; ++k) {
    const Arrival arrival = co_await scheduler.until({k * 200'000}, Lane::device, "tick");
    CHECK(scheduler.now() == arrival.scheduled);
    arrivals.of_timers.push_back(arrival);
  }
}
Task works(Scheduler& scheduler, int count, Work* work, Arrivals& arrivals) {
  for (int n = 0; n < count; ++n) {
    co_await scheduler.turn(Lane::launch, "launch");
    const RealTime end = scheduler.now() + Duration{n % 3 * 150'000};
    const Arrival arrival = co_await scheduler.external(end, work, "step");
    CHECK(scheduler.now() == arrival.scheduled);
    arrivals.of_work.push_back(arrival);
    arrivals.programmed_ends.push_back(end);
  }
}

void check_lanes(Clock& clock, Executor& executor) {
  Arrivals arrivals;
  SleepingWork work;
  work.length = std::chrono::microseconds(50);
  Scheduler scheduler(clock, executor);
  scheduler.spawn(timers(scheduler, 50, arrivals));
  scheduler.spawn(works(scheduler, 30, &work, arrivals));
  scheduler.spawn(works(scheduler, 30, nullptr, arrivals));
  REQUIRE(scheduler.run(kNever).end == RunEnd::idle);

  CHECK(work.runs == 30);
  REQUIRE(arrivals.of_timers.size() == 50);
  for (std::int64_t k = 0; k < 50; ++k)
    CHECK(arrivals.of_timers[static_cast<std::size_t>(k)].scheduled == RealTime{k * 200'000});
  for (const Arrival& arrival : arrivals.of_timers) CHECK(arrival.lateness() >= Duration{0});
  REQUIRE(arrivals.of_work.size() == 60);
  for (std::size_t n = 0; n < 60; ++n) {
    CHECK(arrivals.of_work[n].scheduled >= arrivals.programmed_ends[n]);
    CHECK(arrivals.of_work[n].lateness() >= Duration{0});
  }
  const auto& events = scheduler.events();
  CHECK(events.size() == 50 + 60 + 60);
  CHECK(std::is_sorted(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.time < b.time; }));
  CHECK(chain(events) == scheduler.trace_hash());
}

TEST_CASE(
    "Timers keep their grid, nothing runs early, work ends at or after its programmed end, virtual and wall, inline and "
    "worker") {
  for (const bool is_virtual : {true, false}) {
    for (const bool inlined : {true, false}) {
      std::unique_ptr<Clock> clock = is_virtual ? std::make_unique<VirtualClock>() : make_wall_clock();
      std::unique_ptr<Executor> executor =
          inlined ? std::unique_ptr<Executor>(std::make_unique<InlineExecutor>()) : std::make_unique<WorkerExecutor>(*clock);
      CAPTURE(is_virtual, inlined);
      check_lanes(*clock, *executor);
    }
  }
}

// ---- Waking up

Task long_timer(Scheduler& scheduler) { co_await scheduler.until({10'000'000'000}, Lane::device, "ten seconds"); }
Task work_then_stop(Scheduler& scheduler, Work& work) {
  co_await scheduler.external({0}, &work, "work");
  scheduler.request_stop();
}

TEST_CASE("A completion wakes a scheduler that waits for a timer in ten seconds") {
  const auto clock = make_wall_clock();
  WorkerExecutor executor(*clock);
  Scheduler scheduler(*clock, executor);
  SleepingWork work;
  work.length = std::chrono::milliseconds(5);
  scheduler.spawn(long_timer(scheduler));
  scheduler.spawn(work_then_stop(scheduler, work));
  CHECK(scheduler.run(kNever).end == RunEnd::stopped);
  REQUIRE(scheduler.events().size() == 1);  // only the work: nobody waited for the timer
  CHECK(scheduler.events()[0].time >= RealTime{5'000'000});
  CHECK(scheduler.events()[0].time < RealTime{10'000'000'000});
}

TEST_CASE("Another thread's stop wakes a scheduler that waits for a timer in ten seconds") {
  const auto clock = make_wall_clock();
  InlineExecutor executor;
  Scheduler scheduler(*clock, executor);
  scheduler.spawn(long_timer(scheduler));
  LaneThread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    scheduler.request_stop();
  });
  CHECK(scheduler.run(kNever).end == RunEnd::stopped);
  CHECK(scheduler.events().empty());
}

TEST_CASE("run() returns only when the work it started is done, the next run() hears of it") {
  const auto clock = make_wall_clock();
  WorkerExecutor executor(*clock);
  Scheduler scheduler(*clock, executor);
  SleepingWork work;
  work.length = std::chrono::milliseconds(5);
  Arrivals arrivals;
  scheduler.spawn(works(scheduler, 1, &work, arrivals));
  CHECK(scheduler.run({1'000'000}).end == RunEnd::reached_end);
  CHECK(work.runs == 1);
  CHECK(arrivals.of_work.empty());
  CHECK(scheduler.run(kNever).end == RunEnd::idle);
  CHECK(arrivals.of_work.size() == 1);
}

TEST_CASE("A scheduler destroyed with work in flight waits for it, 200 times at once after the launch") {
  for (int i = 0; i < 200; ++i) {
    SleepingWork work;
    const auto clock = make_wall_clock();
    WorkerExecutor executor(*clock);
    {
      Arrivals arrivals;
      Scheduler scheduler(*clock, executor);
      scheduler.spawn(works(scheduler, 1, &work, arrivals));
      REQUIRE(scheduler.run_one());
    }
    REQUIRE(work.runs == 1);
  }
}

struct LosingWork final : Work {
  void run() override { throw std::runtime_error("out of memory"); }
};

TEST_CASE("What work throws on the worker's thread fails the run on a wall clock, inline and worker") {
  for (const bool inlined : {true, false}) {
    const auto clock = make_wall_clock();
    std::unique_ptr<Executor> executor =
        inlined ? std::unique_ptr<Executor>(std::make_unique<InlineExecutor>()) : std::make_unique<WorkerExecutor>(*clock);
    Scheduler scheduler(*clock, *executor);
    LosingWork work;
    scheduler.spawn(work_then_stop(scheduler, work));
    const RunStatus status = scheduler.run(kNever);
    CHECK(status.end == RunEnd::failed);
    CHECK(status.message == "out of memory");
    CHECK_THROWS_AS(std::rethrow_exception(status.failure), std::runtime_error);
  }
}

// ---- Stamps, with a clock that the test sets and an executor whose work the test completes

struct ManualExecutor final : Executor {
  std::vector<Completion*> started;
  void start(Completion& completion) override { started.push_back(&completion); }
  void wait(Completion& completion) override { finish(completion, {0}); }  // only at the end of the run
  void finish(Completion& completion, RealTime stamp) {
    completion.stamp = stamp;
    completion.home->completed(completion);
    completion.done = true;
  }
};
struct ManualRig {
  ManualWallClock clock;
  ManualExecutor executor;
  Scheduler scheduler{clock, executor};
};

Task programmed_work(Scheduler& scheduler, RealTime programmed_end, Work& work, Arrival& arrival) {
  const Arrival done = co_await scheduler.external(programmed_end, &work, "work");
  arrival = done;
}
Task finishes_work_at(Scheduler& scheduler, ManualRig& rig, RealTime at, Lane lane, RealTime stamp) {
  co_await scheduler.until(at, lane, "finisher");
  rig.executor.finish(*rig.executor.started.at(0), stamp);
}

TEST_CASE(
    "A completion's time is the later of stamp and programmed end, one that would sort before the event run last is 1 ns "
    "after it") {
  struct Row {
    std::int64_t programmed_end, stamp, expected;
    Lane lane_of_last;  // the lane of the event at 1000 ns during which the scheduler hears of the work
  };
  const Row rows[] = {
      {0, 1500, 1500, Lane::device},      // a stamp after the programmed end
      {2000, 1500, 2000, Lane::device},   // not before the programmed end
      {2000, 900, 2000, Lane::device},    // an old stamp does not show before the programmed end
      {0, 900, 1001, Lane::device},       // heard of too late
      {0, 1000, 1001, Lane::device},      // completions of that instant would have come before the device event
      {0, 1000, 1001, Lane::launch},      //
      {0, 999, 1001, Lane::completion},   //
      {0, 1000, 1001, Lane::completion},  // launched before the event run last: it would sort before that
      {0, 1001, 1001, Lane::device},      //
      {1000, 10, 1001, Lane::device},     // the programmed end itself is heard of too late
  };
  for (const Row& row : rows) {
    ManualRig rig;
    CountingWork work;
    Arrival arrival;
    rig.scheduler.spawn(programmed_work(rig.scheduler, {row.programmed_end}, work, arrival));
    rig.scheduler.spawn(finishes_work_at(rig.scheduler, rig, {1000}, row.lane_of_last, {row.stamp}));
    CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
    CAPTURE(row.programmed_end, row.stamp, lane_name(row.lane_of_last));
    CHECK(arrival.scheduled == RealTime{row.expected});
    CHECK(arrival.actual >= arrival.scheduled);
  }
}

TEST_CASE("A completion launched after the event run last keeps a stamp that equals its time") {
  ManualRig rig;
  CountingWork work;
  Arrival arrival;
  rig.scheduler.spawn(finishes_work_at(rig.scheduler, rig, {1000}, Lane::completion, {1000}));
  rig.scheduler.spawn(programmed_work(rig.scheduler, {0}, work, arrival));
  rig.scheduler.run(kNever);
  CHECK(arrival.scheduled == RealTime{1000});
}

Task late_timer(Scheduler& scheduler, RealTime at, std::vector<Arrival>& arrivals) {
  const Arrival late = co_await scheduler.until(at, Lane::device, "late");
  arrivals.push_back(late);
}

TEST_CASE("Lateness is the live clock at the resume less the key time, and now() stays the key time") {
  ManualRig rig;
  std::vector<Arrival> arrivals;
  rig.clock.lateness = {70};
  for (const std::int64_t at : {1000, 1030, 5000}) rig.scheduler.spawn(late_timer(rig.scheduler, {at}, arrivals));
  rig.scheduler.run(kNever);
  REQUIRE(arrivals.size() == 3);
  CHECK(arrivals[0].lateness() == Duration{70});
  CHECK(arrivals[1].lateness() == Duration{40});  // due while the first was late
  CHECK(arrivals[2].lateness() == Duration{70});
  CHECK(rig.scheduler.now() == RealTime{5000});
}

TEST_CASE("Work stamped before t = 0 is heard of at t = 0") {
  ManualRig rig;
  rig.clock.time = {-5000};
  CountingWork work;
  Arrival arrival;
  rig.scheduler.spawn(programmed_work(rig.scheduler, {-9000}, work, arrival));
  rig.executor.finish(*rig.executor.started.at(0), {-4000});
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK(arrival.scheduled == RealTime{0});
}

// ---- Replay

Task recorded_steps(Scheduler& scheduler, int count, Work& work, std::vector<RealTime>& ends) {
  for (int n = 0; n < count; ++n) {
    co_await scheduler.turn(Lane::launch, "launch");
    const Arrival arrival = co_await scheduler.external({0}, &work, "step");
    ends.push_back(arrival.scheduled);
    scheduler.note(static_cast<std::uint64_t>(n));
  }
}
Task replayed_steps(Scheduler& scheduler, const std::vector<RealTime>& ends) {
  for (std::size_t n = 0; n < ends.size(); ++n) {
    co_await scheduler.turn(Lane::launch, "launch");
    co_await scheduler.external(ends[n], nullptr, "step");
    scheduler.note(static_cast<std::uint64_t>(n));
  }
}

TEST_CASE("A wall run's completion times are all its virtual twin needs to give the same hash") {
  for (int round = 0; round < 10; ++round) {
    const auto clock = make_wall_clock();
    WorkerExecutor worker(*clock);
    Arrivals arrivals;
    std::vector<RealTime> ends[2];
    SleepingWork works_of_lanes[2];
    Scheduler live(*clock, worker);
    live.spawn(timers(live, 40, arrivals));
    for (int i = 0; i < 2; ++i) live.spawn(recorded_steps(live, 40, works_of_lanes[i], ends[i]));
    REQUIRE(live.run(kNever).end == RunEnd::idle);

    VirtualRig twin;
    twin.scheduler.spawn(timers(twin.scheduler, 40, arrivals));
    for (const auto& recorded : ends) twin.scheduler.spawn(replayed_steps(twin.scheduler, recorded));
    REQUIRE(twin.scheduler.run(kNever).end == RunEnd::idle);
    REQUIRE(twin.scheduler.trace_hash() == live.trace_hash());
  }
}

}  // namespace
}  // namespace evenstep::test
