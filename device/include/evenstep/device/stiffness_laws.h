#pragma once
/// How much stiffness a delay costs, and how much of it a local model wins back: closed forms for a spring K felt by a hand
/// of mass m and damping b (docs/forces/stiffness.md compares them with measurements). The loop is
///
///   F(t) = -K [(1 - alpha) x(t - L_e - d) + alpha x(t - h/2 - d)]
///
/// L_e  the delay from the hand's position to the force that answers it, including the hold: L + h/2 with linear emission,
///      half a slot more with hold; for `direct` the mean age of the position that the force belongs to.
/// h/2  the mean age of a force that is held for a tick.         d  the delay of the device itself, both ways together.
///
/// A delay turns stiffness into negative damping. To first order in the delays, the loop renders a damper b_eq in addition
/// to its spring, and it is stable as long as b + b_eq > 0.

#include <optional>

namespace evenstep {

/// The delays of one loop, s. All at least 0, L_e at least h/2.
struct LoopDelays {
  double scheduled_s = 0;  ///< L_e
  double period_s = 1e-3;  ///< h
  double device_s = 0;     ///< d
  /// A device that renders springs of up to own_N_per_m by itself (device_spring.h) holds their force for h_own =
  /// own_period_s instead of h.
  double own_N_per_m = 0, own_period_s = 0;
};

/// The hand and the device's handle, without the spring.
struct Plant {
  double mass_kg = 0;            ///< > 0
  double damping_N_s_per_m = 0;  ///< >= 0
};

/// b_eq = K [(alpha - 1) L_e - alpha h/2 - d] + min(alpha K, own) (h - h_own)/2, N s/m. alpha = 0: no local model. Valid at
/// frequencies f with 2 pi f L_e < 1; agrees with measurements to 0.03 N s/m at K = 300 N/m and 3 Hz.
double rendered_damping(double stiffness_N_per_m, double alpha, const LoopDelays& loop);

/// alpha* = (L_e + d) / (L_e - h/2), for which b_eq = 0 whatever K is; for the springs that the device renders itself, with
/// h_own in place of h. Empty if L_e is not above h/2: without a latency there is nothing to make up for.
std::optional<double> alpha_star(const LoopDelays& loop);

/// For alpha <= alpha*: K_max = b / [(1 - alpha) L_e + alpha h/2 + d], with h_own in place of h if alpha K_max is not above
/// own; otherwise with h, and with b + own (h - h_own)/2 in place of b. It is 0 to 13 % below the measured limit at b = 1
/// N s/m, and far below it for alpha just under alpha* with strong damping, where the mass matters. Infinite for alpha* and
/// above, where this law does not apply.
double damping_limit_N_per_m(double alpha, const LoopDelays& loop, double damping_N_s_per_m);

/// For alpha > 1: K_max = 0.55 m (pi / L_e)^2 / (2 alpha - 1), an empirical lower envelope for alpha 1.1 to 2, m 0.1 to
/// 0.4 kg, b 0.5 to 2 N s/m and d = 0. There the largest stable K is up to 1.8 times as high.
double overshoot_limit_N_per_m(double alpha, const LoopDelays& loop, double mass_kg);

/// The law that applies at alpha: that of the damping up to alpha*, that of the overshoot above.
double largest_stiffness_N_per_m(double alpha, const LoopDelays& loop, const Plant& plant);

/// The alpha to use. It is rounded up, never down: below alpha* the loop generates energy, and alpha = 0.9 already loses
/// three quarters of the stiffness that alpha = 1 allows; above alpha* only the overshoot limits. So it is alpha* + 0.07.
/// But it is 1 if the plant's damping alone allows more than the overshoot does, that is if 2 b / h is above 1.6 times the
/// overshoot's envelope (measured at m = 0.2 kg and L_e = 15.6 ms: both alphas are equally good at b = 3.2 N s/m, the rule
/// changes at 3.0), and 1 if there is no alpha*. At most 4.
double automatic_alpha(const LoopDelays& loop, const std::optional<Plant>& plant);

}  // namespace evenstep
