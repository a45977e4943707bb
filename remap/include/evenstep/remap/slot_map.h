#pragma once
/// The map between real time and simulation time (paper, Figure 3 c and Figure 4 d): every step n has a slot time; it
/// reads the hand at R(n) = slot(n) - c and its force is emitted at F(n) = R(n) + L. One map serves both directions.
///
/// Causality: a map is told `boundary(n, begin)`, and the begin and the end of each step, and nothing else. The length and
/// the step count of a segment are known only when it ends. Until it has seen a complete segment the map is "acquiring": it
/// has no slots yet, so steps read the newest sample, emit their force when they are done, and are not judged.
///
/// L is fixed, or adapts to the times at which steps end (adaptive_latency.h); c is fixed.
///
/// Symbols: c lead, L latency, T segment length, N steps of a segment, tau = T / N slot.

#include <cstdint>
#include <optional>

#include "evenstep/remap/adaptive_latency.h"
#include "evenstep/time/time.h"

namespace evenstep {

enum class SlotKind : std::uint8_t {
  mapped,     ///< R(n) from the map
  newest,     ///< the newest sample at the step's begin (strategy `direct`)
  acquiring,  ///< like `newest`, because the map has not seen a complete segment yet
};
struct Slot {
  RealTime read;  ///< R(n); the step's begin where kind is not `mapped`
  SlotKind kind = SlotKind::newest;
};

namespace internal {
/// Exact floor without a library call (which costs 2 ns): a cast cuts off towards zero, so only a negative number that is
/// not whole needs 1 less.
inline std::int64_t floor_ns(double ns) {
  const auto whole = static_cast<std::int64_t>(ns);
  return whole - (static_cast<double>(whole) > ns ? 1 : 0);
}
}  // namespace internal

class SlotMap {
 public:
  SlotMap(Duration lead, const AdaptiveLatency& latency) : lead_(lead), latency_(latency) {}
  virtual ~SlotMap() = default;

  /// A segment begins: the next step to run is n, and its segment began at `begin`. n and `begin` never decrease.
  virtual void boundary(std::int64_t n, RealTime begin) = 0;
  /// Before read(n): the step's own simulation time t(n), of a loop that knows it. Most maps have no use for it.
  virtual void simulated(SimTime /*t*/) {}

  /// R(n) for the step about to run, which really began at `began`. Steps count from 0. For every n, read(n) and then
  /// emission(n) must be called once each; any other order fails an assertion. `postponed`: by how much a gate has pushed
  /// back the steps so far; a map that learned from times with these waits in them would wait ever longer.
  Slot read(std::int64_t n, RealTime began, Duration postponed = {});
  /// F(n) of the step just read: R(n) + L, or `ended` if its slot is not mapped. A time that would not come after F(n-1)
  /// (only the slots of `paper` can step back) becomes F(n-1) + 1 ns, and emission_repairs() counts it.
  RealTime emission(std::int64_t n, RealTime ended, Duration postponed = {});
  std::int64_t emission_repairs() const { return latency_.repairs(); }

  Duration lead() const { return lead_; }
  const AdaptiveLatency& latency() const { return latency_; }

 protected:
  /// Step n begins (called before slot(n)) or has ended (called after it), at the time that it would have without a gate.
  virtual void began(std::int64_t, RealTime) {}
  virtual void ended(std::int64_t, RealTime) {}
  /// slot(n), floored to ns; nullopt while acquiring.
  virtual std::optional<RealTime> slot(std::int64_t n) = 0;
  virtual SlotKind unmapped_kind() const { return SlotKind::acquiring; }

 private:
  Duration lead_;
  AdaptiveLatency latency_;
  std::int64_t next_step_ = 0;
  bool step_open_ = false;  // between read(n) and emission(n)
  Slot current_;
};

/// Strategy `direct`: no map at all, which is the fault that the paper describes (Figure 2).
class DirectMap final : public SlotMap {
 public:
  DirectMap() : SlotMap({}, Duration{}) {}
  void boundary(std::int64_t, RealTime) override {}

 protected:
  std::optional<RealTime> slot(std::int64_t) override { return std::nullopt; }
  SlotKind unmapped_kind() const override { return SlotKind::newest; }
};

/// Strategy `ideal`: slots known in advance, slot(n) = origin + n / step_rate. A reference only: no causal map can know
/// them.
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
