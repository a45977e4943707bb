#include "rig.h"

namespace evenstep::test {
namespace {

/// `count` events on the nanosecond `at`, by one lane that awaits now().
Task spin(Scheduler& scheduler, RealTime at, int count) {
  for (int i = 0; i < count; ++i) {
    co_await scheduler.until(at, Lane::device, "spin");
  }
}

TEST_CASE("The limit of events per instant itself is allowed, one more ends the run and is not run, at any instant") {
  for (const std::int64_t at : {0, 777}) {
    for (int limit = 1; limit <= 20; ++limit) {
      for (const int over : {0, 1, 5}) {
        VirtualRig rig({.limits = {.events_per_instant = limit}});
        rig.scheduler.spawn(spin(rig.scheduler, {at}, limit + over));
        const RunStatus status = rig.scheduler.run(kNever);
        CAPTURE(at, limit, over);
        CHECK(status.end == (over == 0 ? RunEnd::idle : RunEnd::limit));
        CHECK(status.message == (over == 0 ? ""
                                           : "limit events_per_instant = " + std::to_string(limit) +
                                                 " exceeded by event 'spin' at " + std::to_string(at) + " ns"));
        CHECK(rig.scheduler.event_count() == limit);
        CHECK(rig.scheduler.run(kNever).end == status.end);
      }
    }
  }
}

Task ticks(Scheduler& scheduler, int count, int each) {
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < each; ++i) {
      co_await scheduler.until({k * 10}, Lane::device, "tick");
    }
  }
}

TEST_CASE("The count per instant starts anew at the next instant") {
  VirtualRig rig({.limits = {.events_per_instant = 3}});
  rig.scheduler.spawn(ticks(rig.scheduler, 100, 3));
  CHECK(rig.scheduler.run(kNever).end == RunEnd::idle);
  CHECK(rig.scheduler.event_count() == 300);
}

TEST_CASE("The limit of all events itself is allowed, one more ends the run and is not run, also over several runs") {
  for (int limit = 1; limit <= 20; ++limit) {
    for (const int over : {0, 1}) {
      VirtualRig rig({.limits = {.total_events = limit}});
      rig.scheduler.spawn(ticks(rig.scheduler, limit + over, 1));
      rig.scheduler.run({limit * 5});
      const RunStatus status = rig.scheduler.run(kNever);
      CAPTURE(limit, over);
      CHECK(status.end == (over == 0 ? RunEnd::idle : RunEnd::limit));
      CHECK(status.message == (over == 0 ? ""
                                         : "limit total_events = " + std::to_string(limit) +
                                               " exceeded by event 'tick' at " + std::to_string(limit * 10) + " ns"));
      CHECK(rig.scheduler.event_count() == limit);
    }
  }
}

Task external_after(Scheduler& scheduler, RealTime start, Work& work) {
  co_await scheduler.until(start, Lane::launch, "start");
  co_await scheduler.external(start + Duration{100}, &work, "work");
}

TEST_CASE("The limit of pending events itself is allowed, one more lane ends the run before its first event") {
  for (int limit = 1; limit <= 20; ++limit) {
    for (const int over : {0, 1}) {
      VirtualRig rig({.limits = {.pending_events = limit}});
      std::vector<int> log;
      for (int i = 0; i < limit + over; ++i) rig.scheduler.spawn(mark(rig.scheduler, {10}, Lane::device, i, log));
      const RunStatus status = rig.scheduler.run(kNever);
      CAPTURE(limit, over);
      CHECK(status.end == (over == 0 ? RunEnd::idle : RunEnd::limit));
      CHECK(status.message ==
            (over == 0 ? "" : "limit pending_events = " + std::to_string(limit) + " exceeded by event 'mark' at 0 ns"));
      CHECK(static_cast<int>(log.size()) == (over == 0 ? limit : 0));
    }
  }
}

TEST_CASE("Work over the limit of pending events is not started") {
  VirtualRig rig({.limits = {.pending_events = 0}});
  CountingWork work;
  rig.scheduler.spawn(external_after(rig.scheduler, {10}, work));
  CHECK(rig.scheduler.run(kNever).end == RunEnd::limit);
  CHECK(work.runs == 0);
  CHECK(rig.scheduler.event_count() == 0);
}

TEST_CASE("A lane that awaits now() for ever ends the run by the default limit, it does not hang") {
  VirtualRig rig({.keep_events = false});
  rig.scheduler.spawn(spin(rig.scheduler, {5}, 1'000'000'000));
  CHECK(rig.scheduler.run(kNever).end == RunEnd::limit);
  CHECK(rig.scheduler.event_count() == SchedulerLimits{}.events_per_instant);
}

}  // namespace
}  // namespace evenstep::test
