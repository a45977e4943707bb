#pragma once
/// What a live run says about itself while it runs: figures of what was seen since the last snapshot, and since the
/// beginning.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/live_devices.h"
#include "evenstep/loop/loop_watch.h"

namespace evenstep {

/// What does not change while it runs.
struct WatchedRun {
  struct Device {
    std::string name;
    Rate rate;
    RealTime first_tick;
    double limit_N = 0;  ///< the largest force that the guard lets through
    bool sends = true;   ///< false: a real device without --forces, which is only read
  };
  std::string scenario, strategy;
  Duration length;
  std::vector<Device> devices;
};
/// `scenario` with the guards of real devices (with_live_guards).
WatchedRun watched_run(const Scenario& scenario, const LiveDeviceOptions& options);

/// Late reads count, for each step and device, a sample that was not there yet; late forces count a force that was due
/// before it was there. Missed ticks never ran, because an earlier tick was late, or because the run came to its end.
struct LiveCounts {
  std::int64_t ticks = 0, steps = 0, missed = 0, late_reads = 0, late_forces = 0;
  std::int64_t underruns() const { return late_reads + late_forces; }
};
/// Figures over some part of a run. A margin is the time to spare until a sample or a force is too late; below 0, it was too
/// late.
struct LiveSpan {
  LiveCounts counts;
  Duration lateness_max;
  std::optional<Duration> least_margin;  ///< of both buffers; empty: no step had a slot (`direct`)
  std::int64_t clamped = 0;              ///< ticks whose force was shortened to the limit
};

struct LiveSnapshot {
  RealTime now;  ///< by the run's clock
  Duration left;
  Duration span;  ///< what `last` is about: the time since the snapshot before
  LiveSpan last, whole;
  Duration lateness_p50, lateness_p99;  ///< of `last`, by nearest rank; 0 if no tick ran
  struct Device {
    /// The worst state of its guard in `last`: the newest cut, else ramping, else armed. Empty: no tick yet.
    std::optional<GuardState> guard;
    void add(GuardState seen);
    double force_N = 0;  ///< length of the newest force after the guard
  };
  std::vector<Device> devices;
  bool ended = false;         ///< the loop has ended: this is the last
  std::uint64_t dropped = 0;  ///< ticks and steps of the whole run that ran, but that no reader took in time
};

/// Counts are those of the loop itself, so what was dropped is counted, too; quantiles and margins are of what was seen.
class LiveFigures {
 public:
  explicit LiveFigures(const WatchedRun& run);
  void add(const SeenTick& tick);
  void add(const SeenStep& step);
  /// `now` by the run's clock.
  LiveSnapshot take(RealTime now, std::uint64_t dropped);

 private:
  struct Device {
    std::int64_t ran = 0, due = 0;  // ticks, up to the newest one
    LiveSnapshot::Device last;
  };
  LiveCounts counts(RealTime now) const;

  const WatchedRun& run_;
  std::vector<Device> devices_;
  LiveCounts counts_, counts_before_;  // of steps; ticks are those of devices_
  LiveSpan last_, whole_;
  std::vector<std::int64_t> lateness_ns_;
  RealTime taken_at_;
};

}  // namespace evenstep
