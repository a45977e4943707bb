#include "evenstep/clock/wall_clock.h"

#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "catch.h"

using namespace evenstep;

TEST_CASE("a wall clock is not virtual, and its time passes by itself") {
  WallClock clock(WallEpoch::in({0}));
  CHECK_FALSE(clock.is_virtual());
  const RealTime start = clock.now();
  while (clock.now() == start) {
  }
  CHECK(clock.now() > start);
}

TEST_CASE("two wall clocks of one epoch compare") {
  const WallEpoch epoch = WallEpoch::in({0});
  WallClock one(epoch), other(epoch, Duration{0});
  int out_of_order = 0;
  for (int i = 0; i < 100'000; ++i) {
    const RealTime first = one.now(), second = other.now(), third = one.now();
    out_of_order += second < first || third < second;
  }
  CHECK(out_of_order == 0);
  const RealTime deadline = one.now() + Duration{300'000};
  REQUIRE(one.wait_until(deadline) == Wake::deadline);
  CHECK(other.now() >= deadline);
}

TEST_CASE("a notification to one clock of an epoch does not end the wait of the other") {
  const WallEpoch epoch = WallEpoch::in({0});
  WallClock one(epoch), other(epoch);
  one.notify();
  CHECK(other.wait_until(other.now() + Duration{200'000}) == Wake::deadline);
  CHECK(one.wait_until(kNever) == Wake::notified);
}

TEST_CASE("an epoch in the future gives the lanes time to be ready for t = 0") {
  const Duration ahead{20'000'000};
  WallClock clock(WallEpoch::in(ahead));
  CHECK(clock.now() >= RealTime{0} - ahead);
  CHECK(clock.wait_until(RealTime{0}) == Wake::deadline);
  CHECK(clock.now() >= RealTime{0});
}

TEST_CASE("deadlines so far away that they overflow the system's clock wait for a notification") {
  WallClock clock(WallEpoch::in({0}));
  for (const std::int64_t before_never : {0LL, 1LL, 1'000'000'000LL}) {
    std::thread notifier([&] { clock.notify(); });
    CHECK(clock.wait_until(RealTime{kNever.ns - before_never}) == Wake::notified);
    notifier.join();
  }
}

namespace {

/// Whether the kernel put the calling thread to sleep while `function` ran. (A thread that spins never gives up the
/// processor by itself.)
template <class Function>
bool sleeps_in(Function function) {
  const auto voluntary_switches = [] {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nvcsw;
  };
  const long before = voluntary_switches();
  function();
  return voluntary_switches() > before;
}

}  // namespace

TEST_CASE("a wait for a distant deadline or for kNever sleeps, one within the spin tail does not") {
  const WallEpoch epoch = WallEpoch::in({0});
  WallClock waiting(epoch), notifying(epoch), spinning(epoch, Duration{1'000'000'000});
  bool deadline_sleeps = false, never_sleeps = false;
  // A thread that is kept from running may find its deadline reached and need not sleep. So there is more than one try.
  for (int attempt = 0; attempt < 20 && !(deadline_sleeps && never_sleeps); ++attempt) {
    deadline_sleeps |= sleeps_in([&] { waiting.wait_until(waiting.now() + Duration{10'000'000}); });
    std::thread notifier([&] {
      notifying.wait_until(notifying.now() + Duration{10'000'000});
      waiting.notify();
    });
    never_sleeps |= sleeps_in([&] { waiting.wait_until(kNever); });
    notifier.join();
  }
  CHECK(deadline_sleeps);
  CHECK(never_sleeps);
  CHECK_FALSE(sleeps_in([&] { spinning.wait_until(spinning.now() + Duration{2'000'000}); }));
}

TEST_CASE("notify leaves errno as it was, as a signal handler must") {
  WallClock clock(WallEpoch::in({0}));
  errno = EDOM;
  clock.notify();
  clock.notify();
  CHECK(errno == EDOM);
}

namespace {

/// Runs the function in a separate thread, so that the scheduling of the test's thread does not change.
template <class Function>
void in_own_thread(Function function) {
  std::thread thread(function);
  thread.join();
}

}  // namespace

TEST_CASE("a real-time grant says what the kernel really gave to the thread") {
  in_own_thread([] {
    const RealTimeRights rights(1);
    const RealTimeGrant& grant = rights.grant();
    CHECK(grant.fifo == (sched_getscheduler(0) == SCHED_FIFO));
    CHECK(grant.priority == 1);
    CHECK((grant.refusal.find("SCHED_FIFO priority 1 refused: ") == 0) == !grant.fifo);
    CHECK(grant.refusal.empty() == grant.fifo);
    // The slack is 1 ns for an ordinary thread. Kernels that give none to a real-time thread report 0.
    CHECK(prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0) <= 1);
    CHECK(grant.timer_slack_ns == prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0));
  });
}

TEST_CASE("a thread that gives its real-time rights back is as it was before, and so is what it starts then") {
  in_own_thread([] {
    const int policy = sched_getscheduler(0), slack = prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0);
    { const RealTimeRights rights(1); }
    CHECK(sched_getscheduler(0) == policy);
    CHECK(prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0) == slack);
    int policy_later = -1;
    std::thread([&] { policy_later = sched_getscheduler(0); }).join();
    CHECK(policy_later == policy);
  });
}

// Sanitizers intercept mlockall() and lock nothing.
#if !defined(EVENSTEP_SANITIZE_ADDRESS) && !defined(EVENSTEP_SANITIZE_THREAD)
TEST_CASE("memory is locked until the lock is gone, or the system's reason is said") {
  const auto locked_kB = [] {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
      if (word == "VmLck:") break;
    }
    std::int64_t kB = -1;
    status >> kB;
    return kB;
  };
  const std::int64_t before_kB = locked_kB();
  {
    const MemoryLock lock;
    CHECK((locked_kB() > before_kB) == lock.refusal().empty());
    CHECK((lock.refusal().find("mlockall refused: ") == 0) == !lock.refusal().empty());
  }
  CHECK(locked_kB() == before_kB);
}
#endif

TEST_CASE("a priority that no kernel knows is refused in words, and the timer slack is 1 ns all the same") {
  in_own_thread([] {
    const RealTimeRights rights(1'000);
    const RealTimeGrant& grant = rights.grant();
    CHECK_FALSE(grant.fifo);
    CHECK(grant.refusal.find("SCHED_FIFO priority 1000 refused: Invalid argument") == 0);
    CHECK(sched_getscheduler(0) == SCHED_OTHER);
    CHECK(prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0) == 1);
    // Linux 6.12 and later grant every thread a short slice. Earlier versions report none.
    CHECK((grant.slice_ns == 0 || grant.slice_ns == 100'000));
  });
}

TEST_CASE("cores are kept awake as long as the device is open, with the latency asked for, or it is said why not") {
  std::string device = (std::filesystem::temp_directory_path() / "evenstep_latency_XXXXXX").string();
  ::close(::mkstemp(device.data()));
  const auto open_files = [&] {
    std::ptrdiff_t count = 0;
    for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code ignored;
      count += std::filesystem::read_symlink(file, ignored) == device;
    }
    return count;
  };
  {
    const WakeLatency latency(7, device);
    CHECK(latency.refusal().empty());
    CHECK(open_files() == 1);
    std::ifstream in(device, std::ios::binary);
    std::int32_t asked_us = -1;
    in.read(reinterpret_cast<char*>(&asked_us), sizeof asked_us);
    CHECK(in.gcount() == sizeof asked_us);
    CHECK(asked_us == 7);
  }
  CHECK(open_files() == 0);
  std::filesystem::remove(device);
  CHECK_THAT(WakeLatency(0, device).refusal(), Catch::Contains("No such file") && Catch::Contains("a container"));
  CHECK_THAT(WakeLatency(0, "/").refusal(), Catch::Contains("Is a directory"));
  CHECK_THAT(WakeLatency(0, "/dev/full").refusal(), Catch::Contains("No space left"));  // can be opened, not written
}

TEST_CASE("the clocks for reports run forwards, and CPU time only where there is work") {
  const double monotonic = monotonic_seconds(), cpu = process_cpu_seconds();
  WallClock clock(WallEpoch::in({0}));
  clock.wait_until(clock.now() + Duration{2'000'000});
  CHECK(monotonic_seconds() >= monotonic + 0.002 - 1e-6);  // 1e-6 s: a double holds a year of uptime to 4 ns
  const double before_work = process_cpu_seconds();
  CHECK(before_work >= cpu);
  volatile int work = 0;
  for (int i = 0; i < 20'000'000; ++i) work = work + 1;  // 2e7 dependent stores take at least some ms
  CHECK(process_cpu_seconds() > before_work);
}
