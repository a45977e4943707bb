#pragma once
/// The remap as another program (a CHAI3D, SOFA or H3D loop) uses it, between one device thread and one simulation thread:
///
///   evenstep::Remapper<std::array<double, 3>> remap({.lead = duration(261us), .latency = duration(15ms + 66us)});
///   // device thread, every tick:           remap.sample(now, position);  force = remap.force(now).value;
///   // simulation thread, every segment:    remap.segment(now);
///   // simulation thread, every step:       x = remap.begin_step(now).hand.value;  ...step...  remap.end_step(now, force);
///
/// It is a map with its steps (RemapSteps), a ring of samples (SampleBuffer) and a ring of forces (ForceSchedule): the same
/// parts that the haptic loop of evenstep's runs is built from, so what a run says about a timing holds here too. A program
/// with two devices has two Remappers with the same options and tells both of the same segments and steps: their slots are
/// then the same.
///
/// Wait-free and without allocation after construction. The times on each thread must not decrease, and both threads must
/// count from the same start (time/chrono.h). Lead, latency and capacities come from `evenstep size` or from
/// latency_budget.h. Needs the standard library only. docs/parts/embedding.md has a whole program, and what each answer
/// means.

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <variant>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/maps/clocked_map.h"
#include "evenstep/remap/phase_locked_map.h"
#include "evenstep/remap/remap_steps.h"
#include "evenstep/remap/sample_buffer.h"

namespace evenstep {

struct RemapperOptions {
  Duration lead;
  Duration latency;
  /// Used instead of `latency` if given. force_capacity must be enough for its `most`; its `emission` is overwritten with
  /// the one below.
  std::optional<AdaptiveLatencyOptions> adapt = {};
  Emission emission = Emission::linear;
  double bandwidth_Hz = 2.0;
  /// For a loop that knows its own simulation time and hands it to begin_step: its map is a ClockedMap, and bandwidth_Hz is
  /// not used.
  std::optional<Clocked> clocked = {};
  double jump = kUsualJump;  ///< largest change of the velocity from step to step, above 0 to 1 of the pace
  /// Underrun policies; the capacities must be enough for their windows too.
  Extrapolation past_newest_sample = kHoldNewest;
  Extrapolation past_newest_force = kHoldNewest;
  std::size_t interaction_capacity = 64;
  std::size_t force_capacity = 64;
};

/// How many reads of a ring ended in which way. held + extrapolated are the reads with ReadStatus::underrun.
struct ReadCounts {
  std::uint64_t inside = 0;
  std::uint64_t held = 0;          ///< past the newest entry by more than the policy's line goes on, or there is no line
  std::uint64_t extrapolated = 0;  ///< past the newest entry, where the policy's line still goes on
  std::uint64_t overruns = 0;      ///< older than the ring holds: its capacity is too small
  std::uint64_t empty = 0;         ///< nothing there yet
};

struct RemapCounts {
  std::uint64_t steps = 0;        ///< that have begun
  std::uint64_t acquiring = 0;    ///< of them: without a slot yet. They read the newest sample and are in no count of `hand`
  std::uint64_t late_forces = 0;  ///< that came after their deadline (StepEmission::deadline)
  Duration latest_force;          ///< how long after it the latest of them came
  ReadCounts hand;                ///< reads of samples by steps that had a slot
  ReadCounts force;               ///< reads of forces by ticks
};

namespace internal {

/// A number that one thread writes and any thread may read.
class Shared {
 public:
  void add(std::uint64_t more) { set(get() + more); }
  void set(std::uint64_t value) { value_.store(value, std::memory_order_relaxed); }
  std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// Counts the reads of a ring with this underrun policy; one thread reads the ring.
class ReadCounter {
 public:
  explicit ReadCounter(Extrapolation policy) : policy_(policy) {}
  template <class Value>
  void add(RealTime at, const Reading<Value>& reading) {
    if (reading.status == ReadStatus::underrun) {
      (!policy_.none() && at - reading.newest <= policy_.furthest ? extrapolated_ : held_).add(1);
    } else {
      by_status_[static_cast<std::size_t>(reading.status)].add(1);
    }
  }
  ReadCounts counts() const {
    const auto with = [&](ReadStatus status) { return by_status_[static_cast<std::size_t>(status)].get(); };
    return {with(ReadStatus::inside), held_.get(), extrapolated_.get(), with(ReadStatus::overrun), with(ReadStatus::empty)};
  }

 private:
  Extrapolation policy_;
  std::array<Shared, 4> by_status_;
  Shared held_, extrapolated_;
};

}  // namespace internal

/// What a step begins with.
template <class Position>
struct StepInput {
  Slot slot;               ///< R(n), and whether the map has a slot for this step yet
  Reading<Position> hand;  ///< the hand at R(n); without a slot the newest sample
};

template <class Position, class Force = Position>
class Remapper {
 public:
  explicit Remapper(const RemapperOptions& options)
      : hand_(options.interaction_capacity, options.past_newest_sample),
        forces_(options.force_capacity, options.emission, options.past_newest_force),
        map_(map_of(options)),
        hand_reads_(options.past_newest_sample),
        force_reads_(options.past_newest_force) {}
  Remapper(const Remapper&) = delete;
  Remapper& operator=(const Remapper&) = delete;

  // Device thread.
  void sample(RealTime now, const Position& position) { hand_.push(now, position); }
  Reading<Force> force(RealTime now) {
    const Reading<Force> reading = forces_.at(now);
    force_reads_.add(now, reading);
    return reading;
  }

  // Simulation thread. begin_step and end_step alternate.
  void segment(RealTime begin) { steps_.segment(begin); }
  /// `simulated`: t(n), for `clocked`; a step without it follows the one before by a step size.
  StepInput<Position> begin_step(RealTime now, std::optional<SimTime> simulated = {}) {
    const Slot slot = steps_.begin(now, {}, simulated);
    const Reading<Position> hand = hand_.hand(slot, hand_.head());
    begun_.add(1);
    if (slot.kind == SlotKind::mapped) {
      hand_reads_.add(slot.read, hand);
    } else {
      acquiring_.add(1);
    }
    return {slot, hand};
  }
  /// When the force will be emitted, and when it should have come: StepEmission::late.
  StepEmission end_step(RealTime now, const Force& force) {
    const StepEmission emission = steps_.end(now);
    forces_.push(emission.at, force);
    if (const Duration late = emission.late(forces_.emission()); late.ns > 0) {
      late_forces_.add(1);
      latest_force_ns_.set(std::max(latest_force_ns_.get(), static_cast<std::uint64_t>(late.ns)));
    }
    return emission;
  }

  /// Any thread. Each number was true a moment ago; the threads may have gone on between the reading of two numbers.
  RemapCounts counts() const {
    return {.steps = begun_.get(),
            .acquiring = acquiring_.get(),
            .late_forces = late_forces_.get(),
            .latest_force = {static_cast<std::int64_t>(latest_force_ns_.get())},
            .hand = hand_reads_.counts(),
            .force = force_reads_.counts()};
  }

 private:
  static AdaptiveLatency latency_of(const RemapperOptions& options) {
    if (!options.adapt) return options.latency;
    AdaptiveLatencyOptions adapt = *options.adapt;
    adapt.emission = options.emission;
    return AdaptiveLatency(adapt);
  }

  using Map = std::variant<PhaseLockedMap, ClockedMap>;  // in place: nothing is allocated for it
  static Map map_of(const RemapperOptions& options) {
    if (options.clocked) return Map(std::in_place_type<ClockedMap>, *options.clocked, options.lead, latency_of(options));
    return Map(std::in_place_type<PhaseLockedMap>, options.lead, latency_of(options), options.bandwidth_Hz, options.jump);
  }

  SampleBuffer<Position> hand_;
  ForceSchedule<Force> forces_;
  Map map_;
  RemapSteps steps_{std::visit([](auto& map) -> SlotMap& { return map; }, map_)};
  internal::Shared begun_, acquiring_, late_forces_, latest_force_ns_;  // written by the simulation thread
  internal::ReadCounter hand_reads_;                                    // by the simulation thread
  internal::ReadCounter force_reads_;                                   // by the device thread
};

}  // namespace evenstep
