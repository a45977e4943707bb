#include "rendered_schedule.h"

#include <algorithm>
#include <limits>
#include <variant>

#include "evenstep/device/device_spring.h"
#include "source_forces.h"

namespace evenstep::internal {
namespace {

class ForcesAsScheduled final : public RenderedSchedule {
 public:
  explicit ForcesAsScheduled(const LinkSpec& link) : forces_(link.forces, link.emission, link.force, link.spare) {}
  void push(const StepEmission& emission, const ContactRecord& record) override {
    forces_.push(emission.at, record.force_N);
  }
  std::uint64_t head() const override { return forces_.head(); }
  std::optional<RealTime> emission(std::uint64_t index, std::uint64_t head) const override {
    return forces_.emission(index, head);
  }
  Reading<glm::dvec3> at(RealTime at, std::uint64_t head, const DeviceSample&, const glm::dvec3*) override {
    return forces_.at(at, head);
  }

 private:
  ForceSchedule<glm::dvec3> forces_;
};

/// Past its time the newest record stays in use, because its law still answers the hand.
class ContactsByLaw final : public RenderedSchedule {
 public:
  ContactsByLaw(const LinkSpec& link, const RenderLocal& local)
      : contacts_(link.forces, link.emission, kHoldNewest, link.spare), local_(local), renderer_(local.alpha) {}
  void push(const StepEmission& emission, const ContactRecord& record) override {
    const Softened soft =
        local_.capped_together ? softened_together(record, local_.most_N_per_m) : softened(record, local_.most_N_per_m);
    summary_.stiffest_N_per_m = std::max(summary_.stiffest_N_per_m, soft.stiffest_N_per_m);
    summary_.softened += soft.stiffest_N_per_m > local_.most_N_per_m;
    contacts_.push(emission.at, affine_contact(with_part(soft.record, local_.part), local_.knows_gap));
  }
  std::uint64_t head() const override { return contacts_.head(); }
  std::optional<RealTime> emission(std::uint64_t index, std::uint64_t head) const override {
    return contacts_.emission(index, head);
  }
  std::optional<RenderedContactsSummary> contacts() const override { return summary_; }
  Reading<glm::dvec3> at(RealTime at, std::uint64_t head, const DeviceSample& sample, const glm::dvec3* other_m) override {
    const Reading<AffineContact> contact = contacts_.at(at, head);
    if (contact.status == ReadStatus::empty) return {glm::dvec3(0), contact.status, contact.newest};
    const Duration age = at - contact.newest;
    if (local_.by_device) spring_ = faded_spring(contact.value, age);
    const glm::dvec3* const coupled_m = local_.coupled ? other_m : nullptr;
    return {renderer_.force_N(contact.value, age, sample.position_m, coupled_m), contact.status, contact.newest};
  }
  std::optional<DeviceSpring> spring() const override { return spring_; }

 private:
  /// What springs along the axes cannot express is left to the loop.
  DeviceSpring faded_spring(const AffineContact& contact, Duration age) const {
    DeviceSpring spring = device_spring(contact, local_.alpha, std::numeric_limits<double>::infinity());
    spring.below_N_per_m *= fade(age);
    spring.above_N_per_m *= fade(age);
    return spring;
  }

  ForceSchedule<AffineContact> contacts_;
  RenderLocal local_;
  LocalRenderer renderer_;
  RenderedContactsSummary summary_;
  std::optional<DeviceSpring> spring_;
};

class ContactsByMode final : public RenderedSchedule {
 public:
  ContactsByMode(const LinkSpec& link, const RenderSmith& smith)
      : contacts_(link.forces, link.emission, kHoldNewest, link.spare),
        renderer_(smith.mode, smith.memory, period_ceil(link.ticks.rate)) {}
  void push(const StepEmission& emission, const ContactRecord& record) override {
    contacts_.push(emission.at, affine_contact(record, true));
  }
  std::uint64_t head() const override { return contacts_.head(); }
  std::optional<RealTime> emission(std::uint64_t index, std::uint64_t head) const override {
    return contacts_.emission(index, head);
  }
  Reading<glm::dvec3> at(RealTime at, std::uint64_t head, const DeviceSample& sample, const glm::dvec3*) override {
    const Reading<AffineContact> contact = contacts_.at(at, head);
    // Called even if there is no record yet, because the renderer remembers the hand and must see every tick.
    const glm::dvec3 force_N = renderer_.force_N(contact.value, at - contact.newest, sample.time(), sample.position_m);
    return {contact.status == ReadStatus::empty ? glm::dvec3(0) : force_N, contact.status, contact.newest};
  }

 private:
  ForceSchedule<AffineContact> contacts_;
  SmithRenderer renderer_;
};

}  // namespace

std::unique_ptr<RenderedSchedule> make_rendered_schedule(const LinkSpec& link) {
  if (const auto* local = std::get_if<RenderLocal>(&link.render)) return std::make_unique<ContactsByLaw>(link, *local);
  if (const auto* smith = std::get_if<RenderSmith>(&link.render)) return std::make_unique<ContactsByMode>(link, *smith);
  if (link.source) return make_source_forces(link);
  return std::make_unique<ForcesAsScheduled>(link);
}

}  // namespace evenstep::internal
