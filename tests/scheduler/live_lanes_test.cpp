#include "evenstep/scheduler/live_lanes.h"

#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <stdexcept>
#include <thread>

#include "rig.h"
#include "wall_test_clock.h"

namespace evenstep::test {
namespace {

struct OrderedWork final : Work {
  int index = 0;
  std::vector<int>* order = nullptr;
  std::thread::id* ran_on = nullptr;
  void run() override {
    order->push_back(index);
    *ran_on = std::this_thread::get_id();
  }
};

TEST_CASE("A worker runs what it was given in order, on a thread of its own, with stamps that never go back") {
  const auto clock = make_wall_clock();
  std::vector<int> order;
  std::thread::id ran_on;
  std::deque<Completion> completions;
  std::deque<OrderedWork> works;
  WorkerExecutor worker(*clock);
  const RealTime before = clock->now();
  for (int i = 0; i < 1000; ++i) {
    OrderedWork& work = works.emplace_back();
    work.index = i;
    work.order = &order;
    work.ran_on = &ran_on;
    Completion& completion = completions.emplace_back();
    completion.work = &work;
    worker.start(completion);
  }
  for (Completion& completion : completions) {
    worker.wait(completion);
    REQUIRE(completion.done);
  }
  const RealTime after = clock->now();
  REQUIRE(order.size() == 1000);
  for (int i = 0; i < 1000; ++i) REQUIRE(order[static_cast<std::size_t>(i)] == i);
  CHECK(ran_on != std::this_thread::get_id());
  RealTime last = before;
  for (const Completion& completion : completions) {
    REQUIRE(completion.stamp >= last);
    last = completion.stamp;
  }
  CHECK(last <= after);
}

struct GatedWork final : Work {
  std::atomic<bool> open{false};
  void run() override { open.wait(false); }
};

TEST_CASE("Starting work on a worker does not wait for it") {
  const auto clock = make_wall_clock();
  WorkerExecutor worker(*clock);
  GatedWork work;
  Completion first, second;
  first.work = second.work = &work;
  worker.start(first);  // would never return if it ran the work
  worker.start(second);
  CHECK_FALSE(first.done);
  work.open = true;
  work.open.notify_all();
  worker.wait(second);
  CHECK(first.done);
}

TEST_CASE("A worker that is destroyed finishes what was started") {
  const auto clock = make_wall_clock();
  for (int round = 0; round < 100; ++round) {
    std::vector<int> order;
    std::thread::id ran_on;
    std::deque<Completion> completions(20);
    OrderedWork work;
    work.order = &order;
    work.ran_on = &ran_on;
    {
      WorkerExecutor worker(*clock);
      for (Completion& completion : completions) {
        completion.work = &work;
        worker.start(completion);
      }
    }
    REQUIRE(order.size() == 20);
  }
}

// ---- Inline and worker under a virtual clock

struct Accumulator final : Work {
  std::uint64_t input = 0;
  std::uint64_t state = 1;
  bool throws = false;
  void run() override {
    for (std::uint64_t i = 0; i < input % 50; ++i) state = mix(state, input);
    if (throws) throw std::runtime_error("step");
  }
};

Task solver_lane(Scheduler& scheduler, std::uint64_t seed, Accumulator& work) {
  for (std::uint64_t n = 0; n < 25; ++n) {
    work.input = mix(seed, n);
    work.throws = draw(seed, 3 * n, 16) == 0;
    const RealTime end = scheduler.now() + Duration{draw(seed, 3 * n + 1, 40) - 5};
    try {
      co_await scheduler.external(end, &work, "step");
    } catch (const std::runtime_error&) {
      scheduler.note(std::uint64_t{0xbad});
    }
    scheduler.note(work.state);
    co_await scheduler.turn(Lane::launch, "launch");
  }
}
Task tick_lane(Scheduler& scheduler) {
  for (int k = 0; k < 30; ++k) {
    co_await scheduler.until({k * 20}, Lane::device, "tick");
  }
}

std::uint64_t hash_of(Clock& clock, Executor& executor, std::uint64_t seed) {
  Accumulator works[3];
  Scheduler scheduler(clock, executor);
  scheduler.spawn(tick_lane(scheduler));
  for (std::uint64_t i = 0; i < 3; ++i) scheduler.spawn(solver_lane(scheduler, 3 * seed + i, works[i]));
  REQUIRE(scheduler.run(kNever).end == RunEnd::idle);
  return scheduler.trace_hash();
}

TEST_CASE(
    "Under a virtual clock a worker's thread gives the same hash as inline work, 1000 random schedules, seeds 0 to 999") {
  std::uint64_t different = 0;
  std::uint64_t last = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    VirtualClock inline_clock, worker_clock;
    InlineExecutor inlined;
    WorkerExecutor worker(worker_clock);
    const std::uint64_t hash = hash_of(inline_clock, inlined, seed);
    REQUIRE(hash == hash_of(worker_clock, worker, seed));
    if (hash != last) ++different;
    last = hash;
  }
  CHECK(different == 1000);  // the schedules really differ
}

// ---- LaneThread

TEST_CASE("A lane thread runs its body on another thread, and join() rethrows once what it threw") {
  std::thread::id ran_on;
  LaneThread quiet([&] { ran_on = std::this_thread::get_id(); });
  quiet.join();
  CHECK(ran_on != std::thread::id{});
  CHECK(ran_on != std::this_thread::get_id());
  CHECK_NOTHROW(quiet.join());

  LaneThread failing([] { throw std::runtime_error("lost"); });
  CHECK_THROWS_WITH(failing.join(), "lost");
  CHECK_NOTHROW(failing.join());
}

TEST_CASE("A lane thread's destructor waits for its body and swallows what it threw") {
  bool finished = false;
  {
    const LaneThread thread([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      finished = true;
      throw std::runtime_error("nobody asked");
    });
  }
  CHECK(finished);
}

Task lane_of_thread(Scheduler& scheduler, std::atomic<int>& ticks) {
  for (int k = 0; k < 20; ++k) {
    co_await scheduler.until({k * 100'000}, Lane::device, "tick");
    ++ticks;
  }
}

TEST_CASE("Two schedulers run side by side on two threads") {
  std::atomic<int> ticks{0};
  const auto body = [&ticks] {
    const auto clock = make_wall_clock();
    InlineExecutor executor;
    Scheduler scheduler(*clock, executor);
    scheduler.spawn(lane_of_thread(scheduler, ticks));
    if (scheduler.run(kNever).end != RunEnd::idle) throw std::runtime_error("not idle");
  };
  LaneThread device(body);
  LaneThread simulation(body);
  device.join();
  simulation.join();
  CHECK(ticks == 40);
}

}  // namespace
}  // namespace evenstep::test
