#pragma once
/// Real step times for the tests of this room: the programmed periodic timing of the paper, and random ones.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "evenstep/remap/latency_budget.h"
#include "evenstep/remap/paper_map.h"
#include "evenstep/remap/phase_locked_map.h"
#include "evenstep/remap/slot_map.h"
#include "evenstep/time/digest.h"

namespace evenstep::testing {

struct Segment {
  RealTime begin;
  std::vector<StepTimes> steps;
};
using Schedule = std::vector<Segment>;

/// Random draws, made from a counter, so that they are the same with every standard library.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : key_(seed) {}
  std::uint64_t next() { return mix(key_, ++count_); }
  std::int64_t between(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(next() % static_cast<std::uint64_t>(high - low + 1));
  }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Mean 1, coefficient of variation `variation`.
  double lognormal(double variation) { return lognormal_of(sigma(variation)); }
  /// The standard deviation of the logarithm, computed once for many draws.
  static double sigma(double variation) { return std::sqrt(std::log1p(variation * variation)); }
  double lognormal_of(double sigma) {
    const double normal = std::sqrt(-2 * std::log(1 - unit())) * std::cos(2 * std::numbers::pi * unit());
    return std::exp(sigma * normal - 0.5 * sigma * sigma);
  }

 private:
  std::uint64_t key_;
  std::uint64_t count_ = 0;
};

/// The paper's reference case and variants of it: segment k begins at floor(k / rate), pauses for V, and its N steps fill
/// the rest of it, except for an idle time at its end.
struct Periodic {
  Rate segments{30, 1};
  Duration visualization{11'100'000};
  std::int32_t steps = 15;
  Duration idle{};
  bool steps_first = false;

  Segment segment(std::int64_t k) const {
    const RealTime begin = tick_time(segments, k);
    const RealTime first = begin + (steps_first ? Duration{} : visualization);
    const std::int64_t busy_ns = (tick_time(segments, k + 1) - begin - visualization - idle).ns;
    Segment segment{begin, {}};
    for (std::int32_t i = 0; i < steps; ++i) {
      segment.steps.push_back({first + Duration{floor_mul_div(busy_ns, i, steps)},
                               first + Duration{floor_mul_div(busy_ns, i + 1, steps)}, k, i});
    }
    return segment;
  }
  Schedule schedule(std::int64_t count) const {
    Schedule schedule;
    for (std::int64_t k = 0; k < count; ++k) schedule.push_back(segment(k));
    return schedule;
  }
};

/// Free running: V and step durations log-normal with the same coefficient of variation.
inline Schedule jittered(Draw& draw, double variation, std::int64_t count, double drift_ns_per_segment = 0) {
  Schedule schedule;
  RealTime now{};
  for (std::int64_t k = 0; k < count; ++k) {
    Segment segment{now, {}};
    const double longer = drift_ns_per_segment * static_cast<double>(k);
    now = now + Duration{std::llround(11'100'000 * draw.lognormal(variation) + longer)};
    for (std::int32_t i = 0; i < 15; ++i) {
      const RealTime end = now + Duration{std::llround(22'233'333.0 / 15 * draw.lognormal(variation))};
      segment.steps.push_back({now, end, k, i});
      now = end;
    }
    schedule.push_back(segment);
  }
  return schedule;
}

/// Anything that can happen: N in 1..40 (or none), V in 0..50 ms, constant, uniform, log-normal, bursty (Gilbert) or
/// heavy-tailed (Pareto) steps, gaps between steps, idle time, dropped visualizations.
inline Schedule random_schedule(Draw& draw, std::int64_t count) {
  const std::int64_t kind = draw.between(0, 4);
  const std::int64_t usual_steps = draw.between(1, 40);
  const bool steps_vary = draw.between(0, 2) == 0;
  const bool gaps = draw.between(0, 3) == 0;
  const std::int64_t visualization_ns = draw.between(0, 50'000'000);
  const std::int64_t step_ns = draw.between(1'000, 3'000'000);
  const double variation = draw.unit();
  Schedule schedule;
  RealTime now{draw.between(-1'000'000'000, 1'000'000'000)};
  bool slow = false;
  for (std::int64_t k = 0; k < count; ++k) {
    Segment segment{now, {}};
    if (draw.between(0, 9) != 0) now = now + Duration{visualization_ns};
    const std::int64_t steps = steps_vary ? draw.between(k == 0 ? 1 : 0, 40) : usual_steps;
    for (std::int32_t i = 0; i < steps; ++i) {
      if (gaps) now = now + Duration{draw.between(0, 500'000)};
      double factor = 1;
      if (kind == 1) factor = 2 * draw.unit();
      if (kind == 2) factor = draw.lognormal(variation);
      if (kind == 3) factor = (slow = draw.between(0, 7) == 0 ? !slow : slow) ? 1.6 : 0.8;
      if (kind == 4) factor = std::min(0.4 / std::pow(1 - draw.unit(), 1 / 1.5), 100.0);
      const RealTime end = now + Duration{1 + std::llround(factor * static_cast<double>(step_ns))};
      segment.steps.push_back({now, end, k, i});
      now = end;
    }
    if (draw.between(0, 4) == 0) now = now + Duration{draw.between(0, 10'000'000)};
    schedule.push_back(segment);
  }
  return schedule;
}

inline std::vector<StepTimes> flat(const Schedule& schedule) {
  std::vector<StepTimes> steps;
  for (const Segment& segment : schedule) steps.insert(steps.end(), segment.steps.begin(), segment.steps.end());
  return steps;
}

struct Placed {
  StepTimes real;
  Slot slot;
  RealTime emission;
};

/// Passes the whole schedule through a map, as the haptic loop does.
inline std::vector<Placed> place(SlotMap& map, const Schedule& schedule) {
  std::vector<Placed> placed;
  for (const Segment& segment : schedule) {
    map.boundary(static_cast<std::int64_t>(placed.size()), segment.begin);
    for (const StepTimes& step : segment.steps) {
      const auto n = static_cast<std::int64_t>(placed.size());
      const Slot slot = map.read(n, step.begin);
      placed.push_back({step, slot, map.emission(n, step.end)});
    }
  }
  return placed;
}
inline std::vector<Placed> place(SlotMap&& map, const Schedule& schedule) { return place(map, schedule); }

/// The steps as the sizing pass sees them; the map must have lead 0.
inline std::vector<MappedStep> mapped_steps(const std::vector<Placed>& placed) {
  std::vector<MappedStep> steps;
  for (std::size_t n = 0; n < placed.size(); ++n) {
    if (placed[n].slot.kind != SlotKind::mapped) continue;
    steps.push_back({static_cast<std::int64_t>(n), placed[n].real.begin, placed[n].real.end, placed[n].slot.read});
  }
  return steps;
}

/// Largest |R(n+1) - 2 R(n) + R(n-1)| over mapped steps from n = `from` on, in slots.
inline double velocity_jump(const std::vector<Placed>& placed, std::size_t from, double slot_ns) {
  std::int64_t most = 0;
  for (std::size_t n = from + 1; n + 1 < placed.size(); ++n) {
    if (placed[n - 1].slot.kind != SlotKind::mapped) continue;
    const Duration after = placed[n + 1].slot.read - placed[n].slot.read;
    const Duration before = placed[n].slot.read - placed[n - 1].slot.read;
    most = std::max(most, std::abs((after - before).ns));
  }
  return static_cast<double>(most) / slot_ns;
}

/// Judges whether the velocity of phase_locked changes by at most A wherever phase_locked_map.h promises that.
class VelocityRule {
 public:
  explicit VelocityRule(double jump) : jump_(jump) {}
  enum class Verdict { excepted, kept, broken };
  /// The next mapped slot. `segments`: how many with steps have begun.
  Verdict next(RealTime slot, double pace_ns, int segments) {
    const double before_ns = velocity_ns_, pace_before_ns = std::exchange(pace_ns_, pace_ns);
    velocity_ns_ = std::exchange(any_, true) ? static_cast<double>((slot - last_).ns) : 0;
    last_ = slot;
    forgotten_ |= pace_ns < 0.26 * pace_before_ns;
    const bool start = segments <= 5 && velocity_ns_ < 0.18 * pace_ns,
               waits = forgotten_ && velocity_ns_ < 0.1 * pace_ns + 2;
    // The slots join R within a step, and have its velocity in the next one.
    spared_ = start || waits || pace_ns < 0.9 * pace_before_ns ? 3 : spared_ - 1;
    const bool outside = before_ns < 0.1 * pace_ns || before_ns > 6 * pace_ns;
    if (before_ns == 0 || spared_ > 0 || outside || velocity_ns_ > 5e8) return Verdict::excepted;
    return std::abs(velocity_ns_ - before_ns) <= jump_ * pace_ns + 2 ? Verdict::kept : Verdict::broken;
  }

 private:
  double jump_, velocity_ns_ = 0, pace_ns_ = 0;
  RealTime last_;
  bool any_ = false, forgotten_ = false;
  int spared_ = 0;
};

/// Whether `body` stops on an assertion; it runs in a child process.
template <class Body>
bool asserts(Body body) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    std::fclose(stderr);
    signal(SIGABRT, SIG_DFL);
    body();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

/// ceil of max(E - n rise/run) - min(S - n rise/run), exactly, in units of 1/run.
inline std::int64_t bracket(const std::vector<StepTimes>& steps, std::int64_t rise, std::int64_t run) {
  __int128 most = 0, least = 0;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const __int128 slots = static_cast<__int128>(n) * rise;
    const __int128 end = static_cast<__int128>(steps[n].end.ns) * run - slots;
    const __int128 begin = static_cast<__int128>(steps[n].begin.ns) * run - slots;
    most = n == 0 ? end : std::max(most, end);
    least = n == 0 ? begin : std::min(least, begin);
  }
  return static_cast<std::int64_t>((most - least + run - 1) / run);
}

}  // namespace evenstep::testing
