#pragma once
/// The few calls that another program (a CHAI3D, SOFA or H3D loop) needs to use the remap, with one haptic thread and one
/// simulation thread:
///
///   evenstep::Remapper<std::array<double, 3>> remap({.lead = ..., .latency = ...});
///   // haptic thread, every tick:           remap.sample(now, position);  force = remap.force(now);
///   // simulation thread, every segment:    remap.segment(now);
///   // simulation thread, every step:       position = remap.interaction(now);  ...step...  remap.response(now, force);
///
/// Wait-free and without allocation after construction. Lead, latency and capacities come from `evenstep size` or from
/// latency_budget.h. Needs the standard library only.

#include <cstdint>
#include <optional>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/phase_locked_map.h"
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
  /// Underrun policies; the capacities must be enough for their windows too.
  Extrapolation past_newest_sample = kHoldNewest;
  Extrapolation past_newest_force = kHoldNewest;
  std::size_t interaction_capacity = 64;
  std::size_t force_capacity = 64;
};

template <class Value>
class Remapper {
 public:
  explicit Remapper(const RemapperOptions& options)
      : interaction_(options.interaction_capacity, options.past_newest_sample),
        forces_(options.force_capacity, options.emission, options.past_newest_force),
        map_(options.lead, latency_of(options), options.bandwidth_Hz) {}

  // Haptic thread.
  void sample(RealTime now, const Value& position) { interaction_.push(now, position); }
  Reading<Value> force(RealTime now) const { return forces_.at(now); }

  // Simulation thread.
  void segment(RealTime begin) { map_.boundary(step_, begin); }
  Reading<Value> interaction(RealTime now) {
    const Slot slot = map_.read(step_, now);
    const std::uint64_t head = interaction_.head();
    return slot.kind == SlotKind::mapped ? interaction_.at(slot.read, head) : interaction_.newest(head);
  }
  void response(RealTime now, const Value& force) { forces_.push(map_.emission(step_++, now), force); }

 private:
  static AdaptiveLatency latency_of(const RemapperOptions& options) {
    if (!options.adapt) return options.latency;
    AdaptiveLatencyOptions adapt = *options.adapt;
    adapt.emission = options.emission;
    return AdaptiveLatency(adapt);
  }

  SampleBuffer<Value> interaction_;
  ForceSchedule<Value> forces_;
  PhaseLockedMap map_;
  std::int64_t step_ = 0;
};

}  // namespace evenstep
