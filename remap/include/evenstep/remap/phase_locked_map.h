#pragma once
/// The default map: it learns the pace of the segments and the usual place of each step in its segment, sees at every step
/// how late it begins, and follows with a velocity that changes from step to step by at most `jump` of the pace, 7 % unless
/// the user chooses otherwise: more makes the hand jump, less costs latency. Its slots are strictly monotone.
///
///   at boundary (n, B), of a segment of length T with N steps, step i of which began at S_i:
///       w = H / (H + T);   sums of T, N and 1 <- w sum + (T, N, 1);   P = sum T / sum N;   N^ = sum N / sum 1
///       u_i += max(1/8, 1 / sum 1) (S_i - B_prev - i T / N - u_i)    usual distance of step i from its segment's even line
///       z = the mean time from the last step's end to the boundary, in the same weights: idle time, which makes up for
///           lateness
///   at the begin S of step i of a segment that began at B:
///       late = S - (B + i P + u_i), made smaller by z (0 if |late| <= z)
///       e = B + i P + late - (R + P)                         how far a step of P would leave the slot R behind
///       k = min(3 / N^, 0.25);   A = jump P
///       V = clamp(P + k e, 0.1 P, 6 P); for an e above A / k^2, what A can still brake takes the place of k e:
///           sqrt(2 A (e - A / (2 k^2)))
///       v += clamp(0.3 (V - v), -A, A);   R += v
///
/// P is the pace (time per step), R the slot, v the distance between slots, and H = 1 / bandwidth the horizon of the pace.
/// Weights by time make the pace right for any N: T grows with N by an offset, so T / N of one segment says nothing about
/// it. Because lateness shows at the first step after a pause, and not only at the next boundary, the slots have caught up
/// before the next pause: docs/choose/numerics.md derives the constants. Slots are integer nanoseconds plus a remainder
/// below 1 ns, so the map does not lose precision in a long run. Everything is first acquired from the first complete
/// segment. If that took more than four times as long per step as the second (kernels compile), it is forgotten after the
/// second: from then on the slots are those of a map that saw nothing before the second, except that slots that are ahead
/// of these wait for them at 0.1 P, because they never step back.
///
/// The velocity jump |R(n+1) - 2 R(n) + R(n-1)| is at most A, except that
///   - v is held within 0.1 P and 6 P, and is scaled along with P where P falls by more than a tenth at one boundary (it
///     was learned from a start that was not the pace);
///   - as long as P is known from one segment alone, v falls at once where the steps come four times as fast and the slots
///     lead by more than P, to 0.1 of the time between these steps; and where the first segment is forgotten, v changes to
///     that of the slots that it joins;
///   - a lag of more than H (a hang, which cannot be hidden) is jumped over: the slot steps forward to where it ought to be.
///     A segment longer than H and than four times the mean counts as twice the mean.
/// No u_i is learned from a segment of more than three times the mean, which is a stall.
///
/// Without a cycle every step may be a segment of its own, or segments may begin anywhere: u_i is then 0 or its mean, and
/// the slots follow the begins of the steps.
///
/// Outside its domain: jump <= 0 or > 1 (an assertion); a segment without steps changes nothing (its length becomes part of
/// the next one's lateness); a pace or velocity below 1 ns per step (steps that take no time) is held at 1 ns, a pace above
/// 1000 s per step at 1000 s; the usual places of steps after the 256th of a segment lie on the line through those of the
/// first and the 256th.

#include <array>
#include <cassert>

#include "evenstep/remap/slot_map.h"

namespace evenstep {

inline constexpr double kUsualJump = 0.07;

class PhaseLockedMap final : public SlotMap {
 public:
  PhaseLockedMap(Duration lead, const AdaptiveLatency& latency, double bandwidth_Hz = 2.0, double jump = kUsualJump)
      : SlotMap(lead, latency), horizon_ns_(1e9 / bandwidth_Hz), jump_(jump) {
    assert(jump > 0 && jump <= 1);
  }
  void boundary(std::int64_t n, RealTime begin) override;
  double period_ns() const { return pace_ns_; }  ///< P, ns per step; 0 while acquiring

 protected:
  void began(std::int64_t n, RealTime begin) override;
  void ended(std::int64_t, RealTime end) override { last_end_ = end; }
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  static constexpr std::size_t kPlaces = 256;

  /// Sums over segments.
  struct Segments {
    double count = 0, length_ns = 0, steps = 0, idle_ns = 0;
  };
  void learn(RealTime end, std::int64_t steps);
  void forget_start();
  void learn_places(double length_ns, std::int64_t steps);
  double usual_ns(std::int64_t i) const;
  double target_ns(std::int64_t i, RealTime begin) const;
  bool runs_ahead_of_start(std::int64_t i, double error_ns) const;
  double begun_pace_ns(std::int64_t i) const;
  double slowest_ns() const;
  void follow(double error_ns);
  void advance();
  void step_over(double target_ns, double error_ns);
  void wait(double advanced_ns);

  double horizon_ns_;  // H
  double jump_;        // A / P
  bool started_ = false;
  std::int64_t first_step_ = 0;  // of the current segment
  RealTime boundary_;            // B of the current segment
  RealTime last_end_;
  Segments past_;                            // fading with time
  double pace_ns_ = 0;                       // P
  std::array<double, kPlaces> usual_ns_{};   // u_i
  std::array<double, kPlaces> begins_ns_{};  // S_i - B of the current segment
  std::size_t known_ = 0;                    // how many u_i are known
  RealTime origin_;                          // integer part of the last slot
  double remainder_ns_ = 0;                  // slot - origin_, in [0, 1)
  double velocity_ns_ = 0;                   // v
  double ahead_ns_ = 0;                      // of R the slots are by so much, because a start was forgotten
};

}  // namespace evenstep
