
#include "catch.h"
#include "src/live/status.h"

using namespace evenstep;
using namespace evenstep::app;

namespace {

constexpr std::int64_t kMs = 1'000'000;

WatchedRun one_device() { return {"x", "phase_locked", Duration{20'000 * kMs}, {{"left", {1000, 1}, {}, 3, true}}}; }

LiveSnapshot busy_second() {
  LiveSnapshot now;
  now.now = RealTime{12'000 * kMs};
  now.left = Duration{8'000 * kMs};
  now.span = Duration{1'000 * kMs};
  now.last = {{998, 450, 2, 1, 2}, Duration{380'000}, Duration{1'620'000}, 4};
  now.whole = {{11'990, 5'400, 10, 2, 3}, Duration{7'380'000}, Duration{-400'000}, 31};
  now.lateness_p50 = Duration{1'540};
  now.lateness_p99 = Duration{31'000};
  now.devices = {{GuardState::armed, 1.2}};
  return now;
}

}  // namespace

TEST_CASE("the status line has its units, the last second, and the run so far") {
  CHECK(status_line(one_device(), busy_second()) ==
        "ARMED | 998 ticks/s, 450 steps/s | lateness p50 0.00154, p99 0.031, max 0.38 ms (run 7.38) | "
        "2 ticks missed (run 10) | 3 underruns (run 5) | least margin 1.62 ms (run -0.4) | "
        "force 1.2 of 3 N, 4 clamped (run 31) | 8 s left, Ctrl-C ends it");
}

TEST_CASE("the status line fits the terminal: parts become shorter, then the least important ones go") {
  const WatchedRun run = one_device();
  const LiveSnapshot now = busy_second();
  CHECK(status_line(run, now, 119) ==
        "ARMED | 998 ticks/s | late p99 0.031, max 0.38 ms | 2 missed | 3 underruns | margin 1.62 ms | 1.2 N | "
        "8 s left, Ctrl-C");
  CHECK(status_line(run, now, 80) == "ARMED | late p99 0.031, max 0.38 ms | 2 missed | 3 underruns | 8 s left, Ctrl-C");
  CHECK(status_line(run, now, 40) == "ARMED | 8 s left, Ctrl-C");
  CHECK(status_line(run, now, 10) == "ARMED");
  CHECK(status_line(run, now, 3) == "ARM");
  for (std::size_t columns = 1; columns < 300; ++columns) REQUIRE(status_line(run, now, columns).size() <= columns);
}

TEST_CASE("several devices, each with its state and its force, and a name is never a command for the terminal") {
  WatchedRun run = one_device();
  run.devices.push_back({"ri\033[2Jght\u202E", {1000, 1}, {}, 0.5, true});
  LiveSnapshot now = busy_second();
  now.devices = {{GuardState::cut_speed, 0}, {GuardState::ramping, 0.0312}};
  now.dropped = 17;
  CHECK(status_line(run, now) ==
        "left CUT (hand too fast), ri?[2Jght? RAMPING | 499 ticks/s and device, 450 steps/s | "
        "lateness p50 0.00154, p99 0.031, max 0.38 ms (run 7.38) | 2 ticks missed (run 10) | 3 underruns (run 5) | "
        "least margin 1.62 ms (run -0.4) | force 0 of 3 N, 0.0312 of 0.5 N, 4 clamped (run 31) | 17 records not shown | "
        "8 s left, Ctrl-C ends it");
}

TEST_CASE("a line before the first tick, of a strategy without a map, and at the end") {
  WatchedRun run = one_device();
  LiveSnapshot now;
  now.left = Duration{19'999'999'999};
  now.devices.resize(1);
  CHECK(status_line(run, now) ==
        "WAITING | 0 ticks/s, 0 steps/s | lateness p50 0, p99 0, max 0 ms (run 0) | 0 ticks missed (run 0) | "
        "0 underruns (run 0) | force 0 of 3 N, 0 clamped (run 0) | 20 s left, Ctrl-C ends it");
  now.devices[0].guard = GuardState::waiting;
  CHECK(status_line(run, now, 10) == "WAITING");
  CHECK_FALSE(any_cut(run, now));
  run.devices[0].sends = false;
  now = busy_second();
  now.ended = true;
  now.last.least_margin.reset();
  now.whole.lateness_max = Duration{1'234'567'890};
  CHECK(status_line(run, now) ==
        "READ ONLY | 998 ticks/s, 450 steps/s | lateness p50 0.00154, p99 0.031, max 0.38 ms (run 1235) | "
        "2 ticks missed (run 10) | 3 underruns (run 5) | least margin none (run -0.4) | "
        "force 1.2 of 3 N, 4 clamped (run 31) | ended after 12 s");
}

TEST_CASE("a terminal's line is rewritten, red while a force is cut off, elsewhere there are plain lines") {
  const WatchedRun run = one_device();
  LiveSnapshot now = busy_second();
  CHECK(drawn({true, true, 40}, run, now) == "\r\033[KARMED | 8 s left, Ctrl-C");
  now.devices[0].guard = GuardState::cut_stale_hand;
  CHECK(drawn({true, true, 50}, run, now) == "\r\033[K\033[31mCUT (hand not reported) | 8 s left, Ctrl-C\033[0m");
  CHECK(drawn({true, false, 50}, run, now) == "\r\033[KCUT (hand not reported) | 8 s left, Ctrl-C");
  now.ended = true;
  CHECK(drawn({true, false, 50}, run, now) == "\r\033[KCUT (hand not reported) | ended\n");
  const std::string plain = drawn({false, false, 80}, run, now);
  CHECK(plain == status_line(run, now) + "\n");
  CHECK(plain.find('\033') == std::string::npos);
}
