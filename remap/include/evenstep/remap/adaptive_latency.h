#pragma once
/// A latency that adapts to what the steps need: it grows at once when a force was late, and shrinks slowly when the need
/// that made it grow is long past. This is the adaptive jitter buffer of packet speech (Ramjee et al., INFOCOM 1994;
/// WebRTC's NetEq) with one difference: nothing is dropped or repeated; instead the line of forces is stretched in time.
///
///   F(n) = R(n) + L(n)                                 L(n) is fixed before step n ends: it cannot save a late force
///   need(n) = E(n) - R(n)                              interpolated forces: E(n) - R(n-1), see latency_budget.h
///   T = clamp(max of need over the window + margin, least, most)
///   need(n) >  L(n):   L(n+1) = T                      if T is more; this is a growth
///   else:              L(n+1) = L(n) moved towards T, by at most slew * (R(n+1) - R(n))
///
/// Consequences: F increases strictly. After an underrun L is never below the largest need in the window (unless `most`
/// is), so the same need cannot cause a second underrun within a window. A need that grows slowly is followed without any
/// underrun, as long as it grows by less than the slew and the margin covers its growth in one step. A growth by d holds
/// the force for d, and the line then continues d later: for a hand at speed v the force is off the old line by v * d
/// (times the stiffness k). While L moves, the forces are played slower or faster by the slew. A latency that cannot move
/// (start = least = most) equals the fixed one, to the nanosecond.
///
/// The lead c is not adapted. It says how early a step reads the hand, which depends on when steps begin and not on when
/// they end; moving it would make the hand jump inside the simulation, where nothing can be stretched. The period of the
/// device plays no part either: a force that is there at F is there for every tick from F on, at any phase.
///
/// The window is real time, counted in read times. It is divided into 64 blocks, and only the largest need of each block
/// is kept, in a fixed array. So a need is remembered for at least one window and at most 1 + 1/64 windows, at any pace.
///
/// Outside its domain (assertions): least > most, start outside them, a negative margin, a slew outside [0, 500000]
/// ppm, a window of 0. Where the need is above `most` the latency stays at `most`, and forces are late. A read time that
/// does not come after the one before it (`paper` can step back) gives F(n-1) + 1 ns, and is counted.

#include <array>
#include <cstdint>
#include <optional>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/time/time.h"

namespace evenstep {

struct AdaptiveLatencyOptions {
  Duration start;                      ///< L of the first step
  Duration least, most;                ///< L stays between them
  Duration window{10'000'000'000};     ///< how long a need is remembered
  Duration margin{1'000'000};          ///< how far L is kept above the largest need
  std::int64_t slew_ppm = 5'000;       ///< |dL/dR|, millionths
  Emission emission = Emission::hold;  ///< how the forces are played, which determines what a step needs
};
inline constexpr std::int64_t kMostSlew_ppm = 500'000;

/// The largest value in a trailing window of real time (a monotonic queue over blocks of a 64th of the window).
class TrailingMaximum {
 public:
  explicit TrailingMaximum(Duration window);
  /// A time before the newest one counts as the newest.
  void add(RealTime time, Duration value);
  /// The largest of the values added less than a window before the newest time. There must be at least one value.
  Duration largest() const { return kept_[first_].value; }

 private:
  static constexpr std::int64_t kBlocks = 64;
  struct Kept {
    std::int64_t block = 0;
    Duration value;
  };
  Duration block_length_;
  std::optional<RealTime> origin_;
  std::int64_t newest_block_ = 0;
  std::array<Kept, kBlocks + 1> kept_;  // values strictly decrease from the oldest to the newest
  std::size_t first_ = 0, count_ = 0;
};

class AdaptiveLatency {
 public:
  explicit AdaptiveLatency(const AdaptiveLatencyOptions& options);
  /// The fixed latency: start = least = most.
  AdaptiveLatency(Duration fixed = {}) : AdaptiveLatency({.start = fixed, .least = fixed, .most = fixed}) {}

  /// F(n) of the step that read the hand at `read` and ended at `ended`. Steps in order.
  RealTime emission(RealTime read, RealTime ended);
  /// F of a step without a slot: the time it ended, or 1 ns after the emission before if that is later.
  RealTime emission(RealTime ended);

  Duration latency() const { return latency_; }  ///< L of the next step, before the slew moves it
  std::int64_t growths() const { return growths_; }
  std::int64_t repairs() const { return repairs_; }  ///< forces moved to F(n-1) + 1 ns

 private:
  bool moves() const { return options_.least < options_.most; }
  void move(Duration elapsed);
  void learn(RealTime due_read, RealTime ended);
  RealTime in_order(RealTime emission);

  AdaptiveLatencyOptions options_;
  Duration latency_;
  Duration target_;
  TrailingMaximum needs_;
  std::int64_t carry_ = 0;  // the part of the slew below 1 ns, in millionths of 1 ns
  std::optional<RealTime> last_emission_;
  std::optional<RealTime> last_read_;  // F(n-1) - L(n-1), of the last mapped step
  std::int64_t growths_ = 0;
  std::int64_t repairs_ = 0;
};

}  // namespace evenstep
