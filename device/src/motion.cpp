#include "evenstep/device/motion.h"

#include <algorithm>
#include <cassert>

#include "evenstep/time/reproducible_math.h"

namespace evenstep {
namespace {

glm::dvec3 at_time(const Still& motion, RealTime) { return motion.position_m; }

/// The distance covered so far, in seconds at full speed: t - t_s / 2 after the smooth start. The numerator is a whole
/// number of half nanoseconds, so there is only one rounding, that of the division (2e9 is exact in a double).
///
/// During the start, with u = t / t_s, the velocity is v (3 u^2 - 2 u^3) and its integral v t_s (u^3 - u^4 / 2). At u = 1
/// this is t_s / 2, the same as after it (bit for bit, because halving is exact), with velocity v and acceleration 0 on both
/// sides.
double run_s(Duration start, RealTime at) {
  assert(start.ns >= 0);
  if (at.ns <= 0) return 0;
  if (at.ns >= start.ns) return static_cast<double>(2 * at.ns - start.ns) / 2e9;
  const double u = static_cast<double>(at.ns) / static_cast<double>(start.ns);
  return static_cast<double>(start.ns) / 1e9 * (u * u * u * (1 - u / 2));
}

glm::dvec3 at_time(const ConstantVelocity& motion, RealTime at) {
  return motion.origin_m + motion.velocity_m_per_s * run_s(motion.smooth_start, at);
}

/// The time at full speed, as run_s, is again a whole number of half nanoseconds on the straight pieces. The first one ends
/// at that of ConstantVelocity, so a run that ends before the first turn has the same positions, bit for bit.
glm::dvec3 at_time(const BackAndForth& motion, RealTime at) {
  assert(motion.straight.ns > 0 && motion.turn.ns > 0);
  const ConstantVelocity& start = motion.start;
  const std::int64_t since_ns = at.ns - start.smooth_start.ns;
  const std::int64_t piece_ns = motion.straight.ns + motion.turn.ns;
  if (since_ns <= motion.straight.ns) return at_time(start, at);
  const std::int64_t into_ns = since_ns % piece_ns;
  const bool back = since_ns / piece_ns % 2 == 1;
  const std::int64_t along_ns = std::min(into_ns, motion.straight.ns);
  const std::int64_t from_begin_ns = back ? motion.straight.ns - along_ns : along_ns;
  double at_full_speed_s = static_cast<double>(start.smooth_start.ns + 2 * from_begin_ns) / 2e9;
  if (into_ns > motion.straight.ns) {
    const double u = static_cast<double>(into_ns - motion.straight.ns) / static_cast<double>(motion.turn.ns);
    const double beyond_s = static_cast<double>(motion.turn.ns) / 1e9 * (u * (1 + u * u * (u - 2)));
    at_full_speed_s += back ? -beyond_s : beyond_s;
  }
  return start.origin_m + start.velocity_m_per_s * at_full_speed_s;
}

/// (1 - cos(2 pi f t)) / 2 = sin^2(pi f t), which does not cancel digits near 0. Whole turns are removed in integer
/// arithmetic, so a run of any length keeps all digits. The second half of a turn mirrors the first, so the angle stays
/// within [0, pi / 2].
glm::dvec3 at_time(const Sine& motion, RealTime at) {
  assert(motion.frequency.num > 0 && motion.frequency.den > 0);
  if (at.ns <= 0) return glm::dvec3(0);
  const __int128 turn = static_cast<__int128>(motion.frequency.den) * 1'000'000'000;
  const __int128 part = static_cast<__int128>(at.ns) * motion.frequency.num % turn;
  const __int128 mirrored = std::min(part, turn - part);
  constexpr double kPi = 3.14159265358979323846;
  const double s = reproducible::sin(kPi * (static_cast<double>(mirrored) / static_cast<double>(turn)));
  return motion.amplitude_m * (s * s);
}

glm::dvec3 at_time(const RampStop& motion, RealTime at) { return at_time(motion.ramp, std::min(at, motion.stop)); }

glm::dvec3 at_time(const StickSlip& motion, RealTime at) {
  assert(motion.stick.ns >= 0 && motion.slip.ns > 0);
  if (at.ns <= 0) return glm::dvec3(0);
  const std::int64_t period_ns = motion.stick.ns + motion.slip.ns;
  const std::int64_t into_ns = at.ns % period_ns;
  const __int128 slipped = static_cast<__int128>(std::max<std::int64_t>(0, into_ns - motion.stick.ns)) * period_ns;
  const auto whole_ns = static_cast<std::int64_t>(slipped / motion.slip.ns);
  const double rest_ns =
      static_cast<double>(static_cast<std::int64_t>(slipped % motion.slip.ns)) / static_cast<double>(motion.slip.ns);
  return motion.velocity_m_per_s * ((static_cast<double>(at.ns - into_ns + whole_ns) + rest_ns) / 1e9);
}

glm::dvec3 at_time(const RecordedMotion& motion, RealTime at) {
  const auto& rows = motion.rows;
  assert(!rows.empty());
  const auto after =
      std::upper_bound(rows.begin(), rows.end(), at, [](RealTime t, const auto& row) { return t < row.first; });
  if (after == rows.begin()) return rows.front().second;
  if (after == rows.end()) return rows.back().second;
  const auto& [from, from_m] = *(after - 1);
  const auto& [to, to_m] = *after;
  assert(from < to);
  const double weight = static_cast<double>((at - from).ns) / static_cast<double>((to - from).ns);
  return from_m + (to_m - from_m) * weight;
}

glm::dvec3 at_time(const MinimumJerk& motion, RealTime at) {
  glm::dvec3 from_m(0);
  std::int64_t into_ns = at.ns;
  for (const MinimumJerk::Move& move : motion.moves) {
    assert(move.duration.ns > 0 && move.rest.ns >= 0);
    if (into_ns <= 0) return from_m;
    if (into_ns < move.duration.ns) {
      const double u = static_cast<double>(into_ns) / static_cast<double>(move.duration.ns);
      return from_m + (move.to_m - from_m) * (u * u * u * (10 + u * (6 * u - 15)));
    }
    from_m = move.to_m;
    into_ns -= move.duration.ns + move.rest.ns;
  }
  return from_m;
}

}  // namespace

glm::dvec3 position_m(const Motion& motion, RealTime at) {
  return std::visit([at](const auto& kind) { return at_time(kind, at); }, motion);
}

}  // namespace evenstep
