#pragma once
/// The way from the record that a step leaves to the force that a tick plays: a force schedule together with a renderer for
/// its records. For a device that plays the scheduled force itself it contains only forces.

#include <memory>
#include <optional>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/renderer.h"
#include "evenstep/loop/exchange.h"
#include "evenstep/remap/force_schedule.h"

namespace evenstep::internal {

class RenderedSchedule {
 public:
  virtual ~RenderedSchedule() = default;
  /// Simulation lane.
  virtual void push(const StepEmission& emission, const ContactRecord& record) = 0;
  virtual std::optional<RenderedContactsSummary> contacts() const { return std::nullopt; }
  virtual std::uint64_t head() const = 0;
  /// Device lane: when force `index` of the first `head` is due; empty if it has left the ring.
  virtual std::optional<RealTime> emission(std::uint64_t index, std::uint64_t head) const = 0;
  /// Device lane, once per tick: the force at `at` for the hand's position as sampled in this tick; `other_m` is the newest
  /// position of the other hand, nullptr if there is none yet.
  virtual Reading<glm::dvec3> at(RealTime at, std::uint64_t head, const DeviceSample& sample, const glm::dvec3* other_m) = 0;
  virtual std::optional<SourceCounts> source_counts() const { return std::nullopt; }
  /// The part of that force that the device may render by itself.
  virtual std::optional<DeviceSpring> spring() const { return std::nullopt; }
};

std::unique_ptr<RenderedSchedule> make_rendered_schedule(const LinkSpec& link);

}  // namespace evenstep::internal
