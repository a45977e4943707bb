#include "evenstep/clock/wall_clock.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cstdint>

namespace evenstep {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

static_assert(std::atomic<std::uint32_t>::is_always_lock_free && sizeof(std::atomic<std::uint32_t>) == 4,
              "the kernel and a signal handler use the word as it lies in memory");

std::int64_t read_ns(clockid_t id) noexcept {
  timespec t{};
  clock_gettime(id, &t);
  return t.tv_sec * kNanosecondsPerSecond + t.tv_nsec;
}

/// Sleeps while `word` is 0, at the latest until `monotonic_ns` (null: no limit). May return early without a reason.
/// FUTEX_WAIT_BITSET is used because its time-out is absolute and, by default, on CLOCK_MONOTONIC.
void sleep_while_zero(std::atomic<std::uint32_t>& word, const std::int64_t* monotonic_ns) noexcept {
  timespec limit{};
  if (monotonic_ns) {
    limit.tv_sec = *monotonic_ns / kNanosecondsPerSecond;
    limit.tv_nsec = *monotonic_ns % kNanosecondsPerSecond;
  }
  syscall(SYS_futex, &word, FUTEX_WAIT_BITSET | FUTEX_PRIVATE_FLAG, 0U, monotonic_ns ? &limit : nullptr, nullptr,
          FUTEX_BITSET_MATCH_ANY);
}

void pause_cpu() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace

WallEpoch WallEpoch::in(Duration from_now) { return {read_ns(CLOCK_MONOTONIC) + from_now.ns}; }

WallClock::WallClock(WallEpoch epoch, Duration spin_tail) : epoch_(epoch), spin_tail_(spin_tail) {}

RealTime WallClock::now() const noexcept { return {read_ns(CLOCK_MONOTONIC) - epoch_.monotonic_ns}; }

RealTime WallClock::at(std::int64_t monotonic_ns) const noexcept {
  std::int64_t ns = 0;
  if (!__builtin_sub_overflow(monotonic_ns, epoch_.monotonic_ns, &ns)) return {ns};
  return {monotonic_ns < 0 ? INT64_MIN : INT64_MAX};
}

Wake WallClock::wait_until(RealTime deadline) noexcept {
  // A deadline (such as kNever) for which deadline + epoch would overflow is centuries away: no limit.
  const bool endless = deadline.ns >= INT64_MAX - epoch_.monotonic_ns;
  for (;;) {
    // The load keeps the spin tail from writing to the cache line that notify() needs.
    if (notified_.load(std::memory_order_relaxed) != 0 && notified_.exchange(0, std::memory_order_acquire) != 0) {
      return Wake::notified;
    }
    const RealTime t = now();
    if (t >= deadline) return Wake::deadline;
    if (endless) {
      sleep_while_zero(notified_, nullptr);
    } else if (t + spin_tail_ < deadline) {
      const std::int64_t spin_begin_ns = epoch_.monotonic_ns + (deadline - spin_tail_).ns;
      sleep_while_zero(notified_, &spin_begin_ns);
    } else {
      pause_cpu();
    }
  }
}

void WallClock::notify() noexcept {
  // If the word is already 1, whoever wrote it wakes the owner, or the owner has not slept since.
  // Safe in a signal handler: a lock-free exchange and a system call that does not fail, so errno is left alone.
  if (notified_.exchange(1, std::memory_order_release) == 0) {
    syscall(SYS_futex, &notified_, FUTEX_WAKE | FUTEX_PRIVATE_FLAG, 1, nullptr, nullptr, 0);
  }
}

double process_cpu_seconds() { return static_cast<double>(read_ns(CLOCK_PROCESS_CPUTIME_ID)) * 1e-9; }

std::int64_t unix_seconds() { return read_ns(CLOCK_REALTIME) / kNanosecondsPerSecond; }

double monotonic_seconds() { return static_cast<double>(read_ns(CLOCK_MONOTONIC)) * 1e-9; }

}  // namespace evenstep
