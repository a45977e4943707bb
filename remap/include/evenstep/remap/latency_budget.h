#pragma once
/// The exact least lead c, latency L and ring capacities for which nothing underruns, from a list of steps and the slots a
/// map gave them (with lead 0). Computed from the map's own integer slots, because they can differ by 1 ns from the closed
/// form.
///
/// Interaction: a read at R = slot - c at time S needs a sample with time >= R that exists at S (a tick at S counts:
/// ties put device before launch). Force: the step's force must exist when it is due, E <= F = slot - c + L.
///
/// F = slot - c + L is the map's own emission time; slots that step back are repaired as in SlotMap::emission.
///
///   any phase of the device:  the next tick lies at most h - 1 ns after R  =>  c = max(slot + (h - 1 ns) - S)
///   this phase:               the first tick at or after R is at or before S
///   both:                     L = max(E - slot) + c;   with linear emission F(n) needs E(n+1) <= F(n), see below
///
/// Periodic case: L* = s + Z (1 - 1/N) + h, with run time s of a step, N steps in a segment, Z all the time of a segment in
/// which no step runs, and device period h (docs/choose/numerics.md).
/// Linear emission between F(n) and F(n+1) needs step n+1's force at any tick after F(n): E(n+1) <= F(n), hence
/// L = max(E(n+1) - slot(n)) + c; on an even map that is one slot more than with hold. No interval leads to the first
/// step's force, so it needs only E <= F.

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "evenstep/remap/remap_steps.h"

namespace evenstep {

/// A step as the sizing pass sees it: real begin S, end E (of a source: when its force is at the device), and slot(n) with
/// lead 0. Lists of them hold mapped steps only, in order.
struct MappedStep {
  std::int64_t step = 0;
  RealTime begin;
  RealTime end;
  RealTime slot;
  std::int64_t segment = 0;
  bool lost = false;  ///< its force never comes, so it needs no latency
};

/// The sampling grid of one device: tick k at origin + floor(k / rate), for every k. A mapped step that begins, or reads,
/// before the first tick of a device is outside the domain. With an age, the sample of a tick is there only so long after
/// it: the formulas above then hold with S - age in place of S for the read.
struct SamplingGrid {
  Rate rate{1000, 1};
  RealTime origin;
  Duration age = {};  ///< the largest; >= 0
};

struct LatencyBudget {
  Duration lead;                      ///< c; negative if samples are always there early; 0 without a device
  Duration latency;                   ///< L
  std::int64_t lead_culprit = -1;     ///< step that sets c
  std::int64_t latency_culprit = -1;  ///< step whose end sets L
  // Both capacities are 2 more than the count: the entry at or before the time asked for, and one that may arrive while a
  // read is under way.
  std::size_t interaction_capacity = 0;  ///< samples: max over n of samples in (R(n), S(n)] at any phase, + 2
  std::size_t force_capacity = 0;        ///< entries: max over n of #{m <= n: F(m) >= E(n)}, + 2
};

/// Without steps the durations are 0 and the capacities 2. With several devices the most demanding one decides.
LatencyBudget least_latency_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                      Emission emission);
LatencyBudget least_latency_this_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                       Emission emission);
/// Lead, latency and culprits as least_latency_any_phase gives them; the capacities stay 0.
LatencyBudget least_needs_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                    Emission emission);
namespace internal {
/// newest_sample of one device, for many steps.
class NewestThisPhase {
 public:
  explicit NewestThisPhase(SamplingGrid device);
  RealTime operator()(RealTime begin) const;

 private:
  SamplingGrid device_;
  Duration period_;
  bool whole_ = false;  // the period is a whole number of ns
  double per_ns_ = 0;
};

/// slot(n) as the force side sees it, in step order. Where a map steps back, SlotMap::emission repairs F(n) to
/// F(n-1) + 1 ns. The repair commutes with adding the constant L - c, so here it is applied to the slots.
class EmissionSlots {
 public:
  RealTime next(RealTime slot) {
    if (last_ && slot <= *last_) slot = *last_ + Duration{1};
    last_ = slot;
    return slot;
  }

 private:
  std::optional<RealTime> last_;
};
}  // namespace internal

/// Lead, latency and culprits as least_latency_any_phase or least_latency_this_phase gives them, from steps that are given
/// a few at a time: for a pass that does not keep the steps.
class RunningNeeds {
 public:
  enum class Phase { any, this_one };
  RunningNeeds(std::span<const SamplingGrid> devices, Emission emission, Phase phase);
  /// The next steps, in order.
  void add(std::span<const MappedStep> steps);
  /// Starts again as if there had been no steps.
  void restart();
  /// Forgets what was needed, but not where the last slot was: for the needs of the next part of a run.
  void restart_needs();
  /// The budget of the steps so far; its capacities are 0.
  LatencyBudget budget() const;
  /// The interaction capacity that the lead of the budget needs.
  std::size_t interaction_capacity() const;

 private:
  /// The largest of some durations, and the first step that has it.
  struct Need {
    Duration least;
    std::int64_t culprit = -1;  // -1: nothing is needed
    void require(Duration duration, std::int64_t step) {
      if (culprit >= 0 && duration <= least) return;
      least = duration;
      culprit = step;
    }
  };

  std::vector<SamplingGrid> devices_;
  Emission emission_;
  Phase phase_;
  std::vector<Need> leads_;  // c that each device needs
  Need delay_;               // L - c: how long after its slot a force may be due at the earliest
  Need wait_;                // longest time from the slot to the begin of a step
  internal::EmissionSlots slots_;
  internal::LineStarts lines_;  // between slots
};

/// max over n of #{m <= n: F(m) >= E(n)}, from steps given a few at a time: the most forces that are waiting when a force
/// is pushed, itself included. The force ring needs 2 more.
class WaitingForces {
 public:
  /// `delay` = L - c.
  explicit WaitingForces(Duration delay) : delay_(delay) {}
  void add(std::span<const MappedStep> steps);
  std::size_t most() const { return most_; }

 private:
  Duration delay_;
  internal::EmissionSlots slots_;
  std::deque<RealTime> emissions_;  // of the forces that wait
  std::size_t most_ = 0;
};

/// max over n of #{m <= n: F(m) > F(n) - window}, from steps given a few at a time: the most forces in a window that ends at
/// a force.
class ForcesWithin {
 public:
  explicit ForcesWithin(Duration window) : window_(window) {}
  void add(std::span<const MappedStep> steps);
  std::size_t most() const { return most_; }

 private:
  Duration window_;
  internal::EmissionSlots slots_;
  std::deque<RealTime> within_;
  std::size_t most_ = 0;
};

/// The capacities that a given c and L need for steps that are given a few at a time, at any phase of the devices. Underrun
/// policies that continue a line need the entries of their windows too (extrapolation.h): ceil(window * rate) samples, and
/// as many forces as were emitted in a window. A read needs either these entries or the ones above, not both, because the
/// window ends at the newest entry.
class RunningCapacities {
 public:
  RunningCapacities(std::span<const SamplingGrid> devices, Duration lead, Duration latency, Duration sample_window = {},
                    Duration force_window = {});
  void add(std::span<const MappedStep> steps);
  /// With this lead and latency; no culprits.
  LatencyBudget budget() const;

 private:
  std::vector<SamplingGrid> devices_;
  Duration lead_, latency_;
  Duration longest_;  // of the window and the times from a read to the begin of its step; it contains the most ticks
  WaitingForces waiting_;
  ForcesWithin within_;
};
/// The same, from all steps at once.
LatencyBudget capacities_for(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices, Duration lead,
                             Duration latency, Duration sample_window = {}, Duration force_window = {});

/// The emissions of a run with this lead and latency, from steps given one by one: StepEmission::late says whether a force
/// will be late. The repair of F and the adaptation of the latency both start at the first step given.
class RunningEmissions {
 public:
  RunningEmissions(Duration lead, const AdaptiveLatency& latency) : lead_(lead), latency_(latency) {}
  StepEmission next(const MappedStep& step) {
    const Slot slot{step.slot - lead_, SlotKind::mapped};
    const RealTime at = latency_.emission(slot.read, step.end);
    return {at, lines_.next(at, step.lost), slot, step.end, step.lost};
  }
  const AdaptiveLatency& latency() const { return latency_; }

 private:
  Duration lead_;
  AdaptiveLatency latency_;
  internal::LineStarts lines_;
};

/// The time of the newest sample at `at`: that of the last tick at or before it, less its age.
RealTime newest_sample(const SamplingGrid& device, RealTime at);
/// What one device will miss in a run, from steps given one by one.
class RunningUnderruns {
 public:
  struct Step {
    Duration missing_by;  ///< how much older than its read the newest sample is; 0 if the sample is there
    Duration late_by;     ///< how long after its deadline its force will come; 0 if it is in time
  };
  /// `ahead`: a force is needed this much before its deadline, because what plays it looks ahead.
  RunningUnderruns(SamplingGrid device, Duration lead, const AdaptiveLatency& latency, Emission emission,
                   Duration ahead = {});
  Step next(const MappedStep& step);

 private:
  internal::NewestThisPhase newest_;
  RunningEmissions emissions_;
  Emission emission_;
  Duration ahead_;
};
/// The number of steps with a missing sample, or a late force.
std::int64_t count_interaction_underruns(std::span<const MappedStep> steps, SamplingGrid device, Duration lead);
std::int64_t count_late_forces(std::span<const MappedStep> steps, Duration lead, const AdaptiveLatency& latency,
                               Emission emission);

}  // namespace evenstep
