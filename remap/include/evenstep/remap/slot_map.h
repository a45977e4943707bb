#pragma once
/// The map between real time and simulation time (paper, Figure 3 c and Figure 4 d): every step n has a slot time; it
/// reads the hand at R(n) = slot(n) - c and its force is emitted at F(n) = R(n) + L. One map serves both directions.
///
/// Causality: a map is told `boundary(n, begin)` and nothing else. The length and the step count of a segment are known
/// when it ends. Until the first complete segment has been seen the map is "acquiring": it has no slots, steps read the
/// newest sample and emit when they are done, and are not judged.
///
/// L is fixed, or adapts to when steps end (adaptive_latency.h); c is fixed.
///
/// Symbols: c lead, L latency, T segment length, N steps of a segment, tau = T / N slot.

#include <cstdint>
#include <optional>
#include <span>

#include "evenstep/remap/adaptive_latency.h"
#include "evenstep/time/time.h"

namespace evenstep {

enum class SlotKind : std::uint8_t {
  mapped,     ///< R(n) from the map
  newest,     ///< the newest sample at the step's begin (strategy `direct`)
  acquiring,  ///< as newest, because the map has not seen a complete segment
};
struct Slot {
  RealTime read;   ///< R(n); the step's begin where kind is not `mapped`
  SlotKind kind = SlotKind::newest;
};

namespace internal {
/// floor, exact, without a call of the library's (2 ns): what is cut off is whole, and 1 too much of a negative number only.
inline std::int64_t floor_ns(double ns) {
  const auto whole = static_cast<std::int64_t>(ns);
  return whole - (static_cast<double>(whole) > ns ? 1 : 0);
}
}  // namespace internal

class SlotMap {
 public:
  SlotMap(Duration lead, const AdaptiveLatency& latency) : lead_(lead), latency_(latency) {}
  virtual ~SlotMap() = default;

  /// Segment boundary: the next step to run is n, and its segment began at `begin`. n and begin never decrease.
  virtual void boundary(std::int64_t n, RealTime begin) = 0;

  /// R(n) for the step about to run, which really began at `began`. Steps count from 0; read(n) and emission(n) are called
  /// once each and in this order for every n, anything else is an assertion.
  Slot read(std::int64_t n, RealTime began);
  /// F(n) of the step just read: R(n) + L, or `ended` where the slot is not mapped. Where that would not come after
  /// F(n-1) (only `paper` steps back) it becomes F(n-1) + 1 ns, and emission_repairs() counts it.
  RealTime emission(std::int64_t n, RealTime ended);
  /// slot(n), slot(n + 1), ... with lead 0, without taking a step: what a pass over a whole recording asks of each segment.
  /// False while there are none.
  virtual bool slots(std::int64_t n, std::span<RealTime> out);
  std::int64_t emission_repairs() const { return latency_.repairs(); }

  Duration lead() const { return lead_; }
  const AdaptiveLatency& latency() const { return latency_; }

 protected:
  /// slot(n), floored to ns; nullopt while acquiring.
  virtual std::optional<RealTime> slot(std::int64_t n) = 0;
  virtual SlotKind unmapped_kind() const { return SlotKind::acquiring; }

 private:
  Duration lead_;
  AdaptiveLatency latency_;
  std::int64_t next_step_ = 0;
  bool step_open_ = false;   // between read(n) and emission(n)
  Slot current_;
};

/// `direct`: no map; the fault that the paper describes (Figure 2).
class DirectMap final : public SlotMap {
 public:
  DirectMap() : SlotMap({}, Duration{}) {}
  void boundary(std::int64_t, RealTime) override {}

 protected:
  std::optional<RealTime> slot(std::int64_t) override { return std::nullopt; }
  SlotKind unmapped_kind() const override { return SlotKind::newest; }
};

/// `ideal`: slots known in advance, slot(n) = origin + n / step_rate: the reference that no causal map can be told.
class EvenMap final : public SlotMap {
 public:
  EvenMap(RealTime origin, Rate step_rate, Duration lead, Duration latency)
      : SlotMap(lead, latency), origin_(origin), step_rate_(step_rate) {}
  void boundary(std::int64_t, RealTime) override {}

 protected:
  std::optional<RealTime> slot(std::int64_t n) override { return tick_time(step_rate_, n, origin_); }

 private:
  RealTime origin_;
  Rate step_rate_;
};

}  // namespace evenstep
