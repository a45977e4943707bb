// How late a thread that wants to run 1000 times a second wakes, depending on how it waits and on what the system grants it.
// All ways of waiting take turns in blocks of a quarter of a second, so that whatever else the machine does hits all of them
// alike. Measured once with nothing beside it, and once with a thread on every core that never sleeps.
//
//   bench_device_tick [ROUNDS]     ROUNDS (40) blocks of 250 ticks each
#include <fmt/format.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "evenstep/clock/wall_clock.h"

using namespace evenstep;

namespace {

constexpr std::int64_t kPeriod_ns = 1'000'000;
constexpr int kTicksPerBlock = 250;
constexpr int kPriority = 45;  // as for the device thread of a live run

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

/// Waits until CLOCK_MONOTONIC reads this.
using Wait = std::function<void(std::int64_t deadline_ns)>;

Wait by_wall_clock(Duration spin_tail) {
  return [clock = std::make_shared<WallClock>(WallEpoch{0}, spin_tail)](std::int64_t deadline_ns) {
    clock->wait_until(RealTime{deadline_ns});
  };
}

void by_condition_variable(std::int64_t deadline_ns) {
  static std::mutex mutex;
  static std::condition_variable nobody_notifies;
  std::unique_lock lock(mutex);
  const std::chrono::steady_clock::time_point deadline{std::chrono::nanoseconds(deadline_ns)};
  while (nobody_notifies.wait_until(lock, deadline) == std::cv_status::no_timeout) {
  }
}

void by_sleep_for(std::int64_t deadline_ns) {
  std::this_thread::sleep_for(std::chrono::nanoseconds(deadline_ns - monotonic_ns()));
}

void by_clock_nanosleep(std::int64_t deadline_ns) {
  const timespec deadline{deadline_ns / 1'000'000'000, deadline_ns % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
}

/// One way to wait, and what was measured with it.
struct Way {
  std::string name;
  Wait wait;
  bool own_rights = false;  ///< timer slack 1 ns, and without SCHED_FIFO the shortest slice
  bool fifo = false;        ///< SCHED_FIFO
  bool awake = false;       ///< no core sleeps deeply
  std::vector<std::int64_t> lateness_ns = {};
  std::int64_t missed = 0;
  double cpu_s = 0, all_s = 0;
  std::string fifo_refusal = {}, awake_refusal = {};  ///< empty if granted or not asked for
};

double thread_cpu_s() {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

/// Runs a block of ticks on a separate thread, so that no way inherits the rights of another.
void run_block(Way& way) {
  std::thread([&] {
    std::optional<WakeLatency> latency;
    if (way.awake) way.awake_refusal = latency.emplace().refusal();
    std::optional<RealTimeRights> rights;
    if (way.own_rights) rights.emplace(way.fifo ? kPriority : 0);  // 0 is refused, so only what needs no permission remains
    if (way.fifo && !rights->grant().fifo) way.fifo_refusal = rights->grant().refusal;
    const std::int64_t begin_ns = monotonic_ns();
    const double cpu_before_s = thread_cpu_s();
    for (std::int64_t k = 1; k <= kTicksPerBlock; ++k) {
      const std::int64_t deadline_ns = begin_ns + k * kPeriod_ns;
      way.wait(deadline_ns);
      const std::int64_t late_ns = monotonic_ns() - deadline_ns;
      way.lateness_ns.push_back(late_ns);
      way.missed += late_ns / kPeriod_ns;  // as in the device lane, ticks whose time has passed are left out
      k += late_ns / kPeriod_ns;
    }
    way.cpu_s += thread_cpu_s() - cpu_before_s;
    way.all_s += 1e-9 * static_cast<double>(monotonic_ns() - begin_ns);
  }).join();
}

std::vector<Way> all_ways() {
  const Duration tail{60'000}, none{0};
  std::vector<Way> ways;
  for (const bool fifo : {false, true}) {
    ways.push_back({"evenstep", by_wall_clock(tail), true, fifo});
    if (fifo) ways.push_back({"evenstep, cores kept awake", by_wall_clock(tail), true, fifo, true});
    ways.push_back({"evenstep without its 60 us of spinning", by_wall_clock(none), true, fifo});
    if (fifo) ways.push_back({"the same, cores kept awake", by_wall_clock(none), true, fifo, true});
    if (!fifo) ways.push_back({"evenstep, the system's slice and slack", by_wall_clock(tail), false, false});
    ways.push_back({"condition_variable::wait_until", by_condition_variable, fifo, fifo});
    ways.push_back({"this_thread::sleep_for", by_sleep_for, fifo, fifo});
    ways.push_back({"clock_nanosleep, absolute", by_clock_nanosleep, fifo, fifo});
  }
  return ways;
}

void print(std::vector<Way>& ways) {
  fmt::print("{:44}{:>10}{:>10}{:>10}{:>10}{:>8}{:>7}\n", "lateness in us", "p50", "p99", "p99.9", "max", "missed", "core");
  for (Way& way : ways) {
    std::sort(way.lateness_ns.begin(), way.lateness_ns.end());
    const auto quantile_us = [&](double share) {
      const auto rank = static_cast<std::size_t>(share * static_cast<double>(way.lateness_ns.size() - 1));
      return 1e-3 * static_cast<double>(way.lateness_ns[rank]);
    };
    std::string policy = !way.fifo ? "" : way.fifo_refusal.empty() ? ", FIFO" : ", no FIFO";
    if (!way.awake_refusal.empty()) policy += ", refused";
    fmt::print("{:44}{:>10.2f}{:>10.1f}{:>10.0f}{:>10.0f}{:>8}{:>6.1f} %\n", way.name + policy, quantile_us(0.5),
               quantile_us(0.99), quantile_us(0.999), quantile_us(1), way.missed, 100 * way.cpu_s / way.all_s);
  }
}

/// Prints what was asked for and refused, and so is missing in all numbers. Each reason is printed once.
void print_refusals(const std::vector<Way>& ways) {
  std::set<std::string> said;
  for (const Way& way : ways) {
    if (!way.fifo_refusal.empty() && said.insert(way.fifo_refusal).second)
      fmt::print("without SCHED_FIFO where it says so: {}\n", way.fifo_refusal);
    if (!way.awake_refusal.empty() && said.insert(way.awake_refusal).second)
      fmt::print("cores were not kept awake where it says \"refused\", so that row repeats the one above it: {}\n",
                 way.awake_refusal);
  }
}

void measure(int rounds, unsigned load_threads) {
  std::atomic<bool> stop{false};
  std::vector<std::thread> load;
  for (unsigned i = 0; i < load_threads; ++i) {
    load.emplace_back([&] {
      while (!stop.load(std::memory_order_relaxed)) {
      }
    });
  }
  std::vector<Way> ways = all_ways();
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < ways.size(); ++i) run_block(ways[(i + static_cast<std::size_t>(round)) % ways.size()]);
  }
  stop = true;
  for (std::thread& thread : load) thread.join();
  print(ways);
  print_refusals(ways);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 40;
  if (rounds < 1) return 2;
  const unsigned cores = std::max(std::thread::hardware_concurrency(), 1U);
  fmt::print("{} ticks of 1 ms each way; nothing of our own beside it\n", rounds * kTicksPerBlock);
  measure(rounds, 0);
  fmt::print("\nthe same with {} threads on {} cores that never sleep\n", cores, cores);
  measure(rounds, cores);
}
