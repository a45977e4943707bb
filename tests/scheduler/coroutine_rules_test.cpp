/// The forms of co_await that evenstep allows (evenstep/scheduler/task.h), run under the scheduler. In other forms g++ 12
/// destroys temporaries twice: `c ? co_await a : co_await b`, `c && co_await a`, a capturing lambda or an aggregate with a
/// string passed inside an awaited call. These tests are most useful under AddressSanitizer.

#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "rig.h"

namespace evenstep::test {
namespace {

static_assert(std::is_trivially_copyable_v<EventName> && std::is_trivially_copyable_v<RealTime>,
              "an awaitable's arguments are trivially copyable");
static_assert(std::is_trivially_destructible_v<Scheduler::Until> && std::is_trivially_destructible_v<Scheduler::External>);

/// Owns memory, so that a frame that is destroyed twice, never, or too early shows.
using Owned = std::shared_ptr<std::string>;

struct Holder final : Work {
  Owned owned;
  int runs = 0;
  void run() override { ++runs; }
};

Task statement(Scheduler& scheduler, Owned owned) {
  co_await scheduler.until({10}, Lane::device, "statement");
  *owned += "s";
}

Task initialiser(Scheduler& scheduler, Owned owned) {
  const Arrival arrival = co_await scheduler.until({20}, Lane::device, "initialiser");
  const auto second = co_await scheduler.until({30}, Lane::device, "auto");
  if (arrival.scheduled < second.scheduled) *owned += "i";
}

Task branches(Scheduler& scheduler, Owned owned, bool condition) {
  if (condition) {
    co_await scheduler.until({40}, Lane::device, "then");
  } else {
    co_await scheduler.until({41}, Lane::device, "else");
  }
  switch (owned->size() % 2) {
    case 0: {
      co_await scheduler.turn(Lane::launch, "even");
      break;
    }
    default: {
      co_await scheduler.turn(Lane::completion, "odd");
      break;
    }
  }
  *owned += condition ? "t" : "e";
}

Task loops(Scheduler& scheduler, Owned owned) {
  for (const int at : {50, 51, 52}) {
    const Owned local = owned;
    co_await scheduler.until({at}, Lane::device, "range for");
    *local += "l";
  }
  while (owned.use_count() > 0) {
    const Arrival arrival = co_await scheduler.until(scheduler.now() + Duration{1}, Lane::device, "while");
    if (arrival.scheduled >= RealTime{55}) break;
  }
}

Task across_try(Scheduler& scheduler, Owned owned) {
  try {
    const Owned local = owned;
    co_await scheduler.until({60}, Lane::device, "try");
    throw std::runtime_error(*local);
  } catch (const std::runtime_error& error) {
    *owned += error.what()[0] == 'x' ? "c" : "?";
  }
  co_await scheduler.until({61}, Lane::device, "after the handler");
}

Task work_by_pointer(Scheduler& scheduler, Holder& work) {
  const Arrival arrival = co_await scheduler.external(scheduler.now() + Duration{70}, &work, "work");
  co_await scheduler.external(arrival.scheduled + Duration{1}, nullptr, "programmed");
  *work.owned += "w";
}

Task named_awaitable(Scheduler& scheduler, Owned owned) {
  auto tick = scheduler.until({80}, Lane::device, "named");
  co_await tick;
  tick.at = {90};
  co_await tick;
  *owned += "n";
}

Task conditional_argument(Scheduler& scheduler, Owned owned, bool condition) {
  const RealTime at = condition ? RealTime{85} : RealTime{86};  // the condition is evaluated before the await
  co_await scheduler.until(at, Lane::device, "conditional");
  *owned += "q";
}

void spawn_all(Scheduler& scheduler, const Owned& owned, Holder& work) {
  scheduler.spawn(statement(scheduler, owned));
  scheduler.spawn(initialiser(scheduler, owned));
  for (const bool condition : {true, false}) {
    scheduler.spawn(branches(scheduler, owned, condition));
    scheduler.spawn(conditional_argument(scheduler, owned, condition));
  }
  scheduler.spawn(loops(scheduler, owned));
  scheduler.spawn(across_try(scheduler, owned));
  scheduler.spawn(work_by_pointer(scheduler, work));
  scheduler.spawn(named_awaitable(scheduler, owned));
}

TEST_CASE("Every allowed form of co_await runs to its end and frees what its frame owned exactly once") {
  const Owned owned = std::make_shared<std::string>("x");
  Holder work;
  work.owned = owned;
  {
    VirtualRig rig;
    spawn_all(rig.scheduler, owned, work);
    CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
    CHECK(*owned == "xsitelllcwqqn");
    CHECK(work.runs == 1);
  }
  CHECK(owned.use_count() == 2);  // this one and the one in `work`
}

TEST_CASE("A scheduler destroyed after any number of events frees the frames of every form") {
  for (int count = 0; count < 40; ++count) {
    const Owned owned = std::make_shared<std::string>("x");
    Holder work;
    work.owned = owned;
    {
      VirtualRig rig;
      spawn_all(rig.scheduler, owned, work);
      for (int i = 0; i < count; ++i) rig.scheduler.run_one();
    }
    REQUIRE(owned.use_count() == 2);
  }
}

TEST_CASE("A task that is never spawned frees its arguments") {
  const Owned owned = std::make_shared<std::string>("x");
  VirtualRig rig;
  { const Task task = statement(rig.scheduler, owned); }
  CHECK(owned.use_count() == 1);
}

}  // namespace
}  // namespace evenstep::test
