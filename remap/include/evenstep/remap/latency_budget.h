#pragma once
/// The exact least lead c, latency L and ring capacities for which nothing underruns, from a list of steps and the slots a
/// map gave them (with lead 0). Computed on the integer map itself, because maps differ by 1 ns from the closed form.
///
/// Interaction: a read at R = slot - c at time S needs a sample with time >= R that exists at S (a tick at S counts:
/// ties put device before launch). Force: the step's force must exist when it is due, E <= F = slot - c + L.
///
/// F = slot - c + L is the map's own emission time, with slots that step back repaired as SlotMap::emission does.
///
///   any phase of the device:  the next tick lies at most h - 1 ns after R  =>  c = max(slot + (h - 1 ns) - S)
///   this phase:               the first tick at or after R is at or before S
///   both:                     L = max(E - slot) + c;   linear emission: each F(n) also needs E(n+1) <= F(n), see below
///
/// Periodic case: L* = s + Z (1 - 1/N) + h, Z all non-step time of a segment (docs/numerics.md).
/// Linear emission between F(n) and F(n+1) needs step n+1's force at any tick after F(n): E(n+1) <= F(n), hence
/// L = max(E(n+1) - slot(n)) + c; on an even map that is one slot more than hold. The first step has no interval before
/// it and needs only E <= F.

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/slot_map.h"

namespace evenstep {

/// A step as the sizing pass sees it: real begin S, end E, and slot(n) with lead 0. Only mapped steps, in order.
struct MappedStep {
  std::int64_t step = 0;
  RealTime begin;
  RealTime end;
  RealTime slot;
  std::int64_t segment = 0;
};

/// The sampling grid of one device: tick k at origin + floor(k / rate), for every k: a mapped step that begins, or reads,
/// before a device's first tick is outside the domain.
struct SamplingGrid {
  Rate rate{1000, 1};
  RealTime origin;
};

struct LatencyBudget {
  Duration lead;                        ///< c; may be negative (data always there before it is needed); 0 without device
  Duration latency;                     ///< L
  std::int64_t lead_culprit = -1;       ///< step that sets c
  std::int64_t latency_culprit = -1;    ///< step whose end sets L
  // + 2 each: the entry at or before the time asked for, and one that may arrive while a read runs.
  std::size_t interaction_capacity = 0; ///< samples: max over n of samples in (R(n), S(n)] at any phase, + 2
  std::size_t force_capacity = 0;       ///< entries: max over n of #{m <= n: F(m) >= E(n)}, + 2
};

/// Empty input: zero durations, capacities 2. Several devices: the worst of them.
LatencyBudget least_latency_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                      Emission emission);
LatencyBudget least_latency_this_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                       Emission emission);
/// Lead, latency and culprits of least_latency_any_phase; capacities stay 0.
LatencyBudget least_needs_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                    Emission emission);
namespace internal {
/// slot(n) as the force side sees it, in step order: where a map steps back, SlotMap::emission repairs F(n) to
/// F(n-1) + 1 ns. The repair commutes with adding the constant L - c, so it can be made on the slots.
class EmissionSlots {
 public:
  RealTime next(RealTime slot) {
    if (last_ && slot <= *last_) slot = *last_ + Duration{1};
    last_ = slot;
    return slot;
  }
  /// The slot before the next one.
  const std::optional<RealTime>& last() const { return last_; }

 private:
  std::optional<RealTime> last_;
};
}  // namespace internal

/// Lead, latency and culprits of least_latency_any_phase and of least_latency_this_phase, a few steps more at a time: for a
/// pass that keeps no steps.
class RunningNeeds {
 public:
  enum class Phase { any, this_one };
  RunningNeeds(std::span<const SamplingGrid> devices, Emission emission, Phase phase);
  /// The next steps, in order.
  void add(std::span<const MappedStep> steps);
  /// As if there had been none.
  void restart();
  /// Forgets what was needed, but not where the last slot was: the needs of a part of a run.
  void restart_needs();
  /// Capacities are 0.
  LatencyBudget budget() const;
  /// Samples that the lead of the budget needs.
  std::size_t interaction_capacity() const;

 private:
  /// The largest of some durations, and the first step that has it.
  struct Need {
    Duration least;
    std::int64_t culprit = -1;          // -1: nothing is needed
    void require(Duration duration, std::int64_t step) {
      if (culprit >= 0 && duration <= least) return;
      least = duration;
      culprit = step;
    }
  };

  std::vector<SamplingGrid> devices_;
  Emission emission_;
  Phase phase_;
  std::vector<Need> leads_;             // c, of each device
  Need delay_;                          // L - c: how long after its slot a force may be due at the earliest
  Need wait_;                           // from slot to begin of a step
  internal::EmissionSlots slots_;
};

/// max over n of #{m <= n: F(m) >= E(n)}, a few steps more at a time: forces that wait when force n is pushed, itself
/// included. The force ring needs 2 more.
class WaitingForces {
 public:
  /// `delay` = L - c.
  explicit WaitingForces(Duration delay) : delay_(delay) {}
  void add(std::span<const MappedStep> steps);
  std::size_t most() const { return most_; }

 private:
  Duration delay_;
  internal::EmissionSlots slots_;
  std::deque<RealTime> emissions_;      // of the forces that wait
  std::size_t most_ = 0;
};

/// Capacities that a given c and L need on these steps, at any phase of the devices. Underrun policies that continue a
/// line need the entries of their windows too (extrapolation.h): ceil(window * rate) samples, and as many forces as
/// were emitted in a window; a read needs either these or the ones above, not both, because the window ends at the
/// newest.
LatencyBudget capacities_for(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices, Duration lead,
                             Duration latency, Duration sample_window = {}, Duration force_window = {});

/// What a run with this c and L will see, step by step, device by device: interaction reads whose sample is not there.
std::vector<bool> interaction_underruns(std::span<const MappedStep> steps, SamplingGrid device, Duration lead);
/// Steps with E(n) > F(n). F is repaired, and a latency that adapts starts, from the first step given on.
std::vector<bool> late_forces(std::span<const MappedStep> steps, Duration lead, AdaptiveLatency latency);
/// How many of them.
std::int64_t count_interaction_underruns(std::span<const MappedStep> steps, SamplingGrid device, Duration lead);
std::int64_t count_late_forces(std::span<const MappedStep> steps, Duration lead, const AdaptiveLatency& latency);

}  // namespace evenstep
