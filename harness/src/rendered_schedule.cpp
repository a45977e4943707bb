#include "rendered_schedule.h"

#include <utility>
#include <variant>

namespace evenstep::internal {
namespace {

class ForcesAsScheduled final : public RenderedSchedule {
 public:
  explicit ForcesAsScheduled(const LinkSpec& link) : forces_(link.forces, link.emission, link.force) {}
  void push(RealTime emission, const ContactRecord& record) override { forces_.push(emission, record.force_N); }
  std::uint64_t head() const override { return forces_.head(); }
  Reading<glm::dvec3> at(RealTime at, std::uint64_t head, const DeviceSample&) override { return forces_.at(at, head); }

 private:
  ForceSchedule<glm::dvec3> forces_;
};

glm::dvec3 rendered(const LocalRenderer& renderer, const AffineContact& contact, Duration age, const DeviceSample& sample) {
  return renderer.force_N(contact, age, sample.position_m);
}
glm::dvec3 rendered(SmithRenderer& renderer, const AffineContact& contact, Duration age, const DeviceSample& sample) {
  return renderer.force_N(contact, age, sample.read_at, sample.position_m);
}

/// Records past the newest one are held: their law goes on answering the hand.
template <class Renderer>
class RenderedContacts final : public RenderedSchedule {
 public:
  RenderedContacts(const LinkSpec& link, bool knows_gap, Renderer renderer)
      : contacts_(link.forces, link.emission), knows_gap_(knows_gap), renderer_(std::move(renderer)) {}
  void push(RealTime emission, const ContactRecord& record) override {
    contacts_.push(emission, affine_contact(record, knows_gap_));
  }
  std::uint64_t head() const override { return contacts_.head(); }
  Reading<glm::dvec3> at(RealTime at, std::uint64_t head, const DeviceSample& sample) override {
    const Reading<AffineContact> contact = contacts_.at(at, head);
    // Also where there is no record yet: what remembers the hand must see every tick.
    const glm::dvec3 force_N = rendered(renderer_, contact.value, at - contact.newest, sample);
    return {contact.status == ReadStatus::empty ? glm::dvec3(0) : force_N, contact.status, contact.newest};
  }

 private:
  ForceSchedule<AffineContact> contacts_;
  bool knows_gap_;
  Renderer renderer_;
};

}  // namespace

std::unique_ptr<RenderedSchedule> make_rendered_schedule(const LinkSpec& link) {
  if (const auto* local = std::get_if<RenderLocal>(&link.render))
    return std::make_unique<RenderedContacts<LocalRenderer>>(link, local->knows_gap, LocalRenderer(local->alpha));
  if (const auto* smith = std::get_if<RenderSmith>(&link.render)) {
    return std::make_unique<RenderedContacts<SmithRenderer>>(
        link, true, SmithRenderer(smith->mode, smith->memory, period_ceil(link.ticks.rate)));
  }
  return std::make_unique<ForcesAsScheduled>(link);
}

}  // namespace evenstep::internal
