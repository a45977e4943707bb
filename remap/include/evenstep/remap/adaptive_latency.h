#pragma once
/// A latency that follows what the steps really need: it grows at once, when a force was not there in time, and shrinks
/// slowly, when what made it grow is long past. The adaptive jitter buffer of packet speech (Ramjee et al., INFOCOM 1994;
/// WebRTC's NetEq) with one difference: nothing is dropped or repeated, the line of forces is stretched.
///
///   F(n) = R(n) + L(n)                                 L(n) is known before step n ends: a late force is late
///   need(n) = E(n) - R(n)                              interpolated forces: E(n) - R(n-1), see latency_budget.h
///   T = clamp(max of need over the window + margin, least, most)
///   need(n) >  L(n):   L(n+1) = T                      if T is more; a growth
///   else:              L(n+1) = L(n) moved towards T, by at most slew * (R(n+1) - R(n))
///
/// Consequences: F increases strictly. L(n) never is below the largest need of the window (unless `most` is), so no
/// underrun comes twice within one. A creeping need is followed without any underrun, as long as it creeps by less than
/// the slew and the margin covers one step's. A growth by d is a hold of d in what is played, and the line continues d
/// later: for a hand at speed v the force is v * d (times k) off the old line. While L moves, what is played runs slower or
/// faster by the slew. A latency that cannot move (start = least = most) is the fixed one, to the nanosecond.
///
/// The lead c is no part of this: it says how early a step reads the hand, is decided by when steps begin and not by when
/// they end, and moving it would make the hand jump inside the simulation, where nothing can be stretched. Nor is the
/// device's period: a force that is there at F is there for every tick from F on, at any phase.
///
/// The window is real time, in read times. Needs are kept as the largest of each 64th of it, so that one is remembered for
/// at least the window and at most 1 + 1/64 of it, whatever the pace, in a fixed array.
///
/// Outside its domain (assertions): least > most, start outside them, a negative margin, a slew outside [0, 500000]
/// ppm, a window of 0. Above `most` it is a fixed latency: underruns come as they come. A read time that does not come
/// after the one before it (`paper` steps back) gives F(n-1) + 1 ns, and is counted.

#include <array>
#include <cstdint>
#include <optional>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/time/time.h"

namespace evenstep {

struct AdaptiveLatencyOptions {
  Duration start;                        ///< L of the first step
  Duration least, most;                  ///< L stays between them
  Duration window{10'000'000'000};       ///< how long a need is remembered
  Duration margin{1'000'000};            ///< kept above the largest need
  std::int64_t slew_ppm = 5'000;         ///< |dL/dR|, millionths
  Emission emission = Emission::hold;    ///< how the forces are played: what a step needs
};
inline constexpr std::int64_t kMostSlew_ppm = 500'000;

/// Largest value of a trailing window of real time, kept in blocks of a 64th: a monotonic queue.
class TrailingMaximum {
 public:
  explicit TrailingMaximum(Duration window);
  /// A time before the newest one counts as the newest.
  void add(RealTime time, Duration value);
  /// Of what was added less than a window before the last time added; at least one value.
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
  std::array<Kept, kBlocks + 1> kept_;   // values strictly decrease from the oldest to the newest
  std::size_t first_ = 0, count_ = 0;
};

class AdaptiveLatency {
 public:
  explicit AdaptiveLatency(const AdaptiveLatencyOptions& options);
  /// The fixed latency: start = least = most.
  AdaptiveLatency(Duration fixed = {}) : AdaptiveLatency({.start = fixed, .least = fixed, .most = fixed}) {}

  /// F(n) of the step read at `read` that ended at `ended`. Steps in order.
  RealTime emission(RealTime read, RealTime ended);
  /// F of a step without a slot: when it ended, after the one before.
  RealTime emission(RealTime ended);

  Duration latency() const { return latency_; }            ///< L of the next step, before it is moved
  std::int64_t growths() const { return growths_; }
  std::int64_t repairs() const { return repairs_; }        ///< forces moved to F(n-1) + 1 ns

 private:
  bool moves() const { return options_.least < options_.most; }
  void move(Duration elapsed);
  void learn(RealTime due_read, RealTime ended);
  RealTime in_order(RealTime emission);

  AdaptiveLatencyOptions options_;
  Duration latency_;
  Duration target_;
  TrailingMaximum needs_;
  std::int64_t carry_ = 0;                  // of the slew, millionths of 1 ns
  std::optional<RealTime> last_emission_;
  std::optional<RealTime> last_read_;       // F(n-1) - L(n-1), of the last mapped step
  std::int64_t growths_ = 0;
  std::int64_t repairs_ = 0;
};

}  // namespace evenstep
