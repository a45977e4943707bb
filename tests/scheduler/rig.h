#pragma once
/// What most tests of the scheduler need: a scheduler with its own clock, reproducible draws, and simple lanes.

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "catch.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/time/digest.h"

namespace evenstep::test {

struct VirtualRig {
  VirtualClock clock;
  InlineExecutor executor;
  Scheduler scheduler;
  explicit VirtualRig(SchedulerOptions options = {}) : scheduler(clock, executor, options) {}
};

/// Draw number n of a seed, uniform enough in [0, bound) for a test.
inline std::int64_t draw(std::uint64_t seed, std::uint64_t n, std::int64_t bound) {
  return static_cast<std::int64_t>(mix(spread(seed + 1), n) % static_cast<std::uint64_t>(bound));
}

struct CountingWork final : Work {
  int runs = 0;
  void run() override { ++runs; }
};

/// A single event that records its number.
inline Task mark(Scheduler& scheduler, RealTime at, Lane lane, int who, std::vector<int>& log) {
  co_await scheduler.until(at, lane, "mark");
  log.push_back(who);
}

}  // namespace evenstep::test

namespace Catch {
template <>
struct StringMaker<evenstep::RealTime> {
  static std::string convert(evenstep::RealTime t) { return std::to_string(t.ns) + " ns"; }
};
template <>
struct StringMaker<evenstep::Duration> {
  static std::string convert(evenstep::Duration d) { return std::to_string(d.ns) + " ns"; }
};
}  // namespace Catch
