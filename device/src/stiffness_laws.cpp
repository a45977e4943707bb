#include "evenstep/device/stiffness_laws.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace evenstep {
namespace {

constexpr double kRoundUp = 0.07;
constexpr double kAboveEnvelope = 1.6;
constexpr double kLargestAlpha = 4;

/// -b_eq / K of a spring whose force is held for `period_s`.
double lost_s(double alpha, const LoopDelays& loop, double period_s) {
  return (1 - alpha) * loop.scheduled_s + alpha * period_s / 2 + loop.device_s;
}

double over(double damping_N_s_per_m, double lost_s) {
  return lost_s > 0 ? damping_N_s_per_m / lost_s : std::numeric_limits<double>::infinity();
}

/// How much earlier, on average, a spring answers that the device renders itself.
double sooner_s(const LoopDelays& loop) { return (loop.period_s - loop.own_period_s) / 2; }

double shortest_period_s(const LoopDelays& loop) { return loop.own_N_per_m > 0 ? loop.own_period_s : loop.period_s; }

}  // namespace

double rendered_damping(double stiffness_N_per_m, double alpha, const LoopDelays& loop) {
  const double own_N_per_m = std::min(alpha * stiffness_N_per_m, loop.own_N_per_m);
  return own_N_per_m * sooner_s(loop) - stiffness_N_per_m * lost_s(alpha, loop, loop.period_s);
}

std::optional<double> alpha_star(const LoopDelays& loop) {
  const double latency_s = loop.scheduled_s - shortest_period_s(loop) / 2;
  if (latency_s <= 0) return std::nullopt;
  return (loop.scheduled_s + loop.device_s) / latency_s;
}

double damping_limit_N_per_m(double alpha, const LoopDelays& loop, double damping_N_s_per_m) {
  if (loop.own_N_per_m > 0) {
    const double all_own_N_per_m = over(damping_N_s_per_m, lost_s(alpha, loop, loop.own_period_s));
    if (alpha * all_own_N_per_m <= loop.own_N_per_m) return all_own_N_per_m;
  }
  return over(damping_N_s_per_m + loop.own_N_per_m * sooner_s(loop), lost_s(alpha, loop, loop.period_s));
}

double overshoot_limit_N_per_m(double alpha, const LoopDelays& loop, double mass_kg) {
  assert(alpha >= 1 && loop.scheduled_s > 0);
  constexpr double kPi = 3.14159265358979323846;
  const double turn_per_s = kPi / loop.scheduled_s;
  return 0.55 * mass_kg * turn_per_s * turn_per_s / (2 * alpha - 1);
}

double largest_stiffness_N_per_m(double alpha, const LoopDelays& loop, const Plant& plant) {
  const std::optional<double> star = alpha_star(loop);
  if (!star || alpha <= *star) return damping_limit_N_per_m(alpha, loop, plant.damping_N_s_per_m);
  return overshoot_limit_N_per_m(alpha, loop, plant.mass_kg);
}

double automatic_alpha(const LoopDelays& loop, const std::optional<Plant>& plant) {
  const std::optional<double> star = alpha_star(loop);
  if (!star) return 1;
  const double alpha = std::min(*star + kRoundUp, kLargestAlpha);
  if (!plant) return alpha;
  const double ideal_N_per_m = 2 * plant->damping_N_s_per_m / shortest_period_s(loop);
  return ideal_N_per_m > kAboveEnvelope * overshoot_limit_N_per_m(alpha, loop, plant->mass_kg) ? 1 : alpha;
}

}  // namespace evenstep
