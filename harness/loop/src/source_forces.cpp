#include "source_forces.h"

#include <algorithm>
#include <optional>
#include <variant>
#include <vector>

#include "evenstep/remap/timed_ring.h"

namespace evenstep::internal {
namespace {

/// A force, and how fast it is expected to change: what the force before it says about the next ones.
struct Sent {
  RealTime stamp, arrives;
  glm::dvec3 force_N{0}, per_s{0};
  bool lost = false;
  std::int64_t number = 0;  // of its step
};

/// What plays the forces.
struct Resampled {
  explicit Resampled(const ResamplerSpec& spec) : samples(spec) {}
  void arrive(RealTime, const Sent& sent) { samples.arrive(sent.stamp, sent.force_N, sent.number); }
  Reading<glm::dvec3> at(RealTime at) const { return samples.at(at); }
  std::int64_t overtaken() const { return samples.overtaken(); }
  Resampler<glm::dvec3> samples;
};
struct InChunks {
  explicit InChunks(const ChunkSpec& spec) : chunks(spec), every_s(seconds(spec.every)) {}
  void arrive(RealTime now, const Sent& sent) { chunks.arrive(now, {sent.stamp, sent.force_N, sent.per_s * every_s}); }
  Reading<glm::dvec3> at(RealTime at) const { return chunks.at(at); }
  std::int64_t overtaken() const { return chunks.overtaken(); }
  ChunkPlayer<glm::dvec3> chunks;
  double every_s;
};

/// What an engine interpolates has the loop's own time for a stamp, that at the end of its step: this long after t(n).
std::optional<Duration> after_own_time(const ResamplerSpec& spec) {
  return spec.kind == Resampling::interpolated ? std::optional(spec.period) : std::nullopt;
}
std::optional<Duration> after_own_time(const ChunkSpec&) { return std::nullopt; }

/// The ring between the lanes has one entry per step in the order of the steps; the device lane takes them out and keeps
/// those that are still on their way.
template <class Player>
class SourceForcesOf final : public RenderedSchedule {
 public:
  template <class Spec>
  SourceForcesOf(const LinkSpec& link, const Spec& spec)
      : ring_(link.forces, link.spare), after_own_time_(after_own_time(spec)), player_(spec) {}

  void push(const StepEmission& emission, const ContactRecord& record) override {
    const RealTime stamp = stamp_of(emission);
    Sent sent{stamp,         emission.arrives, record.force_N,
              glm::dvec3(0), emission.lost,    static_cast<std::int64_t>(ring_.head())};
    if (before_ && stamp > before_->stamp) sent.per_s = (sent.force_N - before_->force_N) / seconds(stamp - before_->stamp);
    before_ = sent;
    ring_.push(emission.at, sent);
  }
  std::uint64_t head() const override { return ring_.head(); }
  /// A lost force counts as one that never came.
  std::optional<RealTime> emission(std::uint64_t index, std::uint64_t head) const override {
    TimedRing<Sent>::Entry entry;
    if (!ring_.get(index, head, entry) || entry.value.lost) return std::nullopt;
    return std::max(entry.time, entry.value.arrives);
  }
  Reading<glm::dvec3> at(RealTime at, std::uint64_t head, const DeviceSample&, const glm::dvec3*) override {
    take(head);
    for (; !on_the_way_.empty() && on_the_way_.front().arrives <= at; on_the_way_.erase(on_the_way_.begin()))
      player_.arrive(on_the_way_.front().arrives, on_the_way_.front());
    return player_.at(at);
  }
  std::optional<SourceCounts> source_counts() const override { return SourceCounts{lost_, player_.overtaken()}; }

 private:
  RealTime stamp_of(const StepEmission& emission) const {
    if (after_own_time_ && emission.simulated) return RealTime{emission.simulated->ns} + *after_own_time_;
    return emission.slot.kind == SlotKind::newest ? emission.slot.read : emission.at;
  }
  /// Takes what was pushed since the last tick. What the ring has overwritten by then is lost, too.
  void take(std::uint64_t head) {
    const auto later = [](const Sent& a, const Sent& b) { return a.arrives < b.arrives; };
    for (; next_ < head; ++next_) {
      TimedRing<Sent>::Entry entry;
      const bool there = ring_.get(next_, head, entry) && !entry.value.lost;
      lost_ += !there;
      if (!there) continue;
      on_the_way_.insert(std::upper_bound(on_the_way_.begin(), on_the_way_.end(), entry.value, later), entry.value);
    }
  }

  TimedRing<Sent> ring_;
  std::optional<Duration> after_own_time_;
  std::optional<Sent> before_;  // simulation lane
  // Of the device lane:
  Player player_;
  std::vector<Sent> on_the_way_;  // by arrival
  std::uint64_t next_ = 0;
  std::int64_t lost_ = 0;
};

}  // namespace

std::unique_ptr<RenderedSchedule> make_source_forces(const LinkSpec& link) {
  if (const auto* chunks = std::get_if<ChunkSpec>(&link.source->play))
    return std::make_unique<SourceForcesOf<InChunks>>(link, *chunks);
  return std::make_unique<SourceForcesOf<Resampled>>(link, std::get<ResamplerSpec>(link.source->play));
}

}  // namespace evenstep::internal
