#pragma once
/// Programmed motions of a hand: its position as a function of real time. Exact and reproducible (no libm). For t < 0 all of
/// them stay at x(0), and all except RecordedMotion start from rest.

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

#include "evenstep/time/time.h"

namespace evenstep {

struct Still {
  glm::dvec3 position_m{0};
};
/// x = v (t - t_s / 2) for t >= t_s; between 0 and t_s the velocity rises as the smoothstep v (3 u^2 - 2 u^3), u = t / t_s
/// (C1), so that x is C2. t_s >= 0. If v t is a whole number of nanometres (0.1 m/s at 1 kHz), x is that number to within
/// 1e-6 nm over +-2.1 m, so a report in whole nanometres loses nothing.
struct ConstantVelocity {
  glm::dvec3 velocity_m_per_s{0};
  Duration smooth_start{0};
  glm::dvec3 origin_m{0};
};
/// Like ConstantVelocity, but after `straight` it turns around smoothly, goes back as long, turns again and so on, so that a
/// run of any length stays within reach. In a turn, u = time / turn, the velocity goes as the smoothstep from v to -v,
/// v (1 - 2 (3 u^2 - 2 u^3)), so x is C2. In a turn the hand goes on by v turn (u - 2 u^3 + u^4), at most 5/16 v turn at u =
/// 1/2, and 0 at the end: every way back covers the points of the way there. straight > 0, turn > 0. The straight pieces
/// begin at smooth_start + j (straight + turn); on them x has no more roundings than on ConstantVelocity.
struct BackAndForth {
  ConstantVelocity start;
  Duration straight{1};
  Duration turn{1};
};
/// x = amplitude (1 - cos(2 pi f t)) / 2, which starts from rest. The frequency is rational and whole turns are removed in
/// integer arithmetic, so every period repeats bit for bit, however long the run.
struct Sine {
  glm::dvec3 amplitude_m{0};
  Rate frequency{1, 1};
};
/// Constant velocity with a smooth start, then a sudden stop at `stop`.
struct RampStop {
  ConstantVelocity ramp;
  RealTime stop;
};
/// A hand that sticks and slips below the line x = v t. In the period that begins at j P, P = stick + slip, it holds
/// v j P for `stick` and then moves evenly, P / slip times as fast as v, to v (j + 1) P:
///   x = v (j P + P max(0, t - j P - stick) / slip)
/// stick >= 0 (0 gives the line itself, without a smooth start), slip > 0. The time in brackets is computed in integers; its
/// fraction of a nanosecond adds one rounding to those of ConstantVelocity, so whole nanometres are kept as there.
struct StickSlip {
  glm::dvec3 velocity_m_per_s{0};
  Duration stick{0};
  Duration slip{1};
};
/// Linear between the rows, whose times must strictly increase (at least one row); before the first and after the last row
/// the hand stays there.
struct RecordedMotion {
  std::vector<std::pair<RealTime, glm::dvec3>> rows;
};
/// Moves from point to point, starting at the origin, and is at rest at each point. A move over the distance D follows
/// D (10 u^3 - 15 u^4 + 6 u^5), u = time / duration, which has the least mean square jerk (Flash and Hogan 1985); then the
/// hand rests for `rest`. The highest speed is 1.875 D / duration.
struct MinimumJerk {
  struct Move {
    glm::dvec3 to_m{0};
    Duration duration{1};
    Duration rest{0};
  };  ///< duration > 0, rest >= 0
  std::vector<Move> moves;
};

using Motion = std::variant<Still, ConstantVelocity, BackAndForth, Sine, RampStop, StickSlip, RecordedMotion, MinimumJerk>;

glm::dvec3 position_m(const Motion& motion, RealTime at);

/// A motion that begins at `begin` instead of 0: x(t) = shape(t - begin).
struct ProgrammedMotion {
  Motion shape;
  RealTime begin;
};
inline glm::dvec3 position_m(const ProgrammedMotion& motion, RealTime at) {
  return position_m(motion.shape, RealTime{0} + (at - motion.begin));
}

}  // namespace evenstep
