// The same tests on both clocks. What a Clock promises (clock.h) must hold whether time passes or jumps. A lost notification
// shows as a test that does not end. No upper bound on wall-clock time is asserted anywhere.

#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>
#include <vector>

#include "catch.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/time/digest.h"

using namespace evenstep;

namespace {

constexpr Duration kHour{3'600'000'000'000};

struct Virtual {
  static VirtualClock make() { return {}; }
};
/// Nearly every wait sleeps in the kernel, down to its last 60 us.
struct WallAsShipped {
  static WallClock make() { return WallClock(WallEpoch::in({0})); }
};
/// No wait ever sleeps. The spinning alone must see deadlines and notifications.
struct WallAllSpin {
  static WallClock make() { return WallClock(WallEpoch::in({0}), kHour * 100); }
};
/// No wait ever spins.
struct WallNoSpin {
  static WallClock make() { return WallClock(WallEpoch::in({0}), Duration{0}); }
};

/// Waits until notified. Deadlines of a virtual clock come at once, so this asks again and again, as a scheduler does.
void wait_for_notification(Clock& clock) {
  const auto deadline = [&] { return clock.is_virtual() ? clock.now() + Duration{1} : clock.now() + kHour; };
  while (clock.wait_until(deadline()) != Wake::notified) std::this_thread::yield();
}

}  // namespace

#define EVENSTEP_ALL_CLOCKS Virtual, WallAsShipped, WallAllSpin, WallNoSpin

TEMPLATE_TEST_CASE("now() never runs backwards, whatever is waited for", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  RealTime last = clock.now();
  int backwards = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    // From 2 us in the past to 2 us in the future.
    clock.wait_until(clock.now() + Duration{static_cast<std::int64_t>(spread(i) % 4000) - 2000});
    for (int read = 0; read < 10; ++read) {
      const RealTime now = clock.now();
      backwards += now < last;
      last = now;
    }
  }
  CHECK(backwards == 0);
}

TEMPLATE_TEST_CASE("now() never runs backwards from one thread to the next", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  std::atomic<std::int64_t> latest_ns{INT64_MIN};
  std::atomic<int> backwards{0};
  std::atomic<bool> done{false};
  const auto reader = [&] {
    while (!done.load(std::memory_order_relaxed)) {
      const std::int64_t seen = latest_ns.load(std::memory_order_acquire);
      const std::int64_t now = clock.now().ns;
      if (now < seen) ++backwards;
      latest_ns.store(now, std::memory_order_release);  // perhaps not the latest of all reads, but good enough
    }
  };
  std::thread first(reader), second(reader);
  for (int i = 0; i < 2'000; ++i) clock.wait_until(clock.now() + Duration{5'000});
  done = true;
  first.join();
  second.join();
  CHECK(backwards == 0);
}

TEMPLATE_TEST_CASE("a deadline in the past returns at once", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  REQUIRE(clock.wait_until(clock.now() + Duration{1'000}) == Wake::deadline);
  for (const std::int64_t ns_ago : {0LL, 1LL, 59'999LL, 60'000LL, 60'001LL, 1'000'000'000LL, 3'600'000'000'000'000LL}) {
    CHECK(clock.wait_until(clock.now() - Duration{ns_ago}) == Wake::deadline);
  }
  CHECK(clock.wait_until(RealTime{INT64_MIN}) == Wake::deadline);
}

TEMPLATE_TEST_CASE("deadline reached means now() >= deadline", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  int early = 0, woken = 0;
  // Deadlines up to 200 us ahead: within the time that a wait spins, at its edge, and beyond it.
  for (std::int64_t ahead = 0; ahead <= 200'000; ahead += 500) {
    const RealTime deadline = clock.now() + Duration{ahead};
    woken += clock.wait_until(deadline) == Wake::notified;
    early += clock.now() < deadline;
  }
  CHECK(early == 0);
  CHECK(woken == 0);
}

TEMPLATE_TEST_CASE("a notification before the wait ends it, once", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  for (int i = 0; i < 1'000; ++i) {
    const RealTime before = clock.now();
    clock.notify();
    REQUIRE(clock.wait_until(kNever) == Wake::notified);
    clock.notify();
    REQUIRE(clock.wait_until(clock.now() + kHour) == Wake::notified);
    CHECK(clock.now() < before + kHour);
    REQUIRE(clock.wait_until(clock.now() + Duration{100}) == Wake::deadline);
  }
}

TEMPLATE_TEST_CASE("several notifications before the wait are one", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  for (int i = 0; i < 3; ++i) clock.notify();
  REQUIRE(clock.wait_until(clock.now() + kHour) == Wake::notified);
  REQUIRE(clock.wait_until(clock.now() + Duration{1'000}) == Wake::deadline);
}

TEMPLATE_TEST_CASE("a pending notification goes before a reached deadline, and is not lost by it", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  clock.notify();
  REQUIRE(clock.wait_until(clock.now() - Duration{1}) == Wake::notified);
  REQUIRE(clock.wait_until(clock.now() - Duration{1}) == Wake::deadline);
}

TEMPLATE_TEST_CASE("10 000 hand-overs between two threads lose no notification", "", Virtual, WallAsShipped, WallNoSpin) {
  // Each side waits on its own clock and notifies the other's. Every notification is waited for exactly once, so a lost one
  // would leave both sides waiting.
  auto ping = TestType::make(), pong = TestType::make();
  std::int64_t turns = 0;  // not atomic, because the notification publishes it
  constexpr std::int64_t kTurns = 10'000;
  std::thread other([&] {
    for (std::int64_t i = 0; i < kTurns; ++i) {
      wait_for_notification(ping);
      ++turns;
      pong.notify();
    }
  });
  std::int64_t wrong = 0;
  for (std::int64_t i = 0; i < kTurns; ++i) {
    ping.notify();
    wait_for_notification(pong);
    wrong += turns != i + 1;
  }
  other.join();
  CHECK(wrong == 0);
  CHECK(turns == kTurns);
}

TEMPLATE_TEST_CASE("what every one of several notifiers wrote is visible after the wait", "", EVENSTEP_ALL_CLOCKS) {
  // Three threads write their boxes and then notify. The owner must see all three, however the notifications coincide.
  auto clock = TestType::make();
  constexpr int kNotifiers = 3, kRounds = 20'000;
  std::vector<std::atomic<int>> boxes(kNotifiers);
  std::vector<std::thread> notifiers;
  for (int id = 0; id < kNotifiers; ++id) {
    notifiers.emplace_back([&, id] {
      for (int round = 1; round <= kRounds; ++round) {
        boxes[id].store(round, std::memory_order_relaxed);
        clock.notify();
      }
    });
  }
  const auto all_done = [&] {
    for (const auto& box : boxes) {
      if (box.load(std::memory_order_relaxed) < kRounds) return false;
    }
    return true;
  };
  while (!all_done()) wait_for_notification(clock);  // a box that is filled later notifies again
  for (auto& notifier : notifiers) notifier.join();
  SUCCEED("every last notification arrived");
}

namespace {

#ifdef EVENSTEP_SANITIZE_THREAD
constexpr bool kSignalsAreHeldBack = true;
#else
constexpr bool kSignalsAreHeldBack = false;
#endif

Clock* clock_of_the_handler = nullptr;
std::atomic<int> signals_handled{0};

void notify_from_handler(int) {
  ++signals_handled;
  if (clock_of_the_handler) clock_of_the_handler->notify();
}

/// Installs the handler for SIGUSR1 while it lives.
struct SignalHandler {
  explicit SignalHandler(Clock* clock) {
    clock_of_the_handler = clock;
    struct sigaction action {};
    action.sa_handler = notify_from_handler;
    sigaction(SIGUSR1, &action, &previous);
  }
  ~SignalHandler() { sigaction(SIGUSR1, &previous, nullptr); }
  struct sigaction previous {};
};

}  // namespace

TEMPLATE_TEST_CASE("a signal handler can end the wait of the thread it interrupts", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  const SignalHandler handler(&clock);
  const pthread_t owner = pthread_self();
  for (int i = 0; i < 100; ++i) {
    std::atomic<bool> woken{false};
    std::thread sender([&] {
      pthread_kill(owner, SIGUSR1);
      // ThreadSanitizer keeps a signal back until the thread enters another function that it intercepts. So a signal that
      // comes between the last such function and the futex call is noticed only when another signal ends the sleep.
      while (kSignalsAreHeldBack && !woken.load()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        pthread_kill(owner, SIGUSR1);
      }
    });
    wait_for_notification(clock);
    woken = true;
    sender.join();
  }
  SUCCEED("every notification arrived");
}

TEMPLATE_TEST_CASE("a signal without a notification does not end a wait", "", EVENSTEP_ALL_CLOCKS) {
  auto clock = TestType::make();
  const SignalHandler handler(nullptr);
  const pthread_t owner = pthread_self();
  const int before = signals_handled;
  std::atomic<bool> done{false};
  std::thread sender([&] {
    do pthread_kill(owner, SIGUSR1);
    while (!done.load());
  });
  int woken = 0, early = 0;
  for (int i = 0; i < 100; ++i) {
    const RealTime deadline = clock.now() + Duration{200'000};
    woken += clock.wait_until(deadline) == Wake::notified;
    early += clock.now() < deadline;
  }
  done = true;
  sender.join();
  CHECK(woken == 0);
  CHECK(early == 0);
  CHECK(signals_handled > before);
}
