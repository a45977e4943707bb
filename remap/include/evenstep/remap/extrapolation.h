#pragma once
/// What a read past the newest entry of a buffer gives. An underrun stays an underrun whatever the policy; the policy
/// only chooses its value. With x the newest value, at time t, and x_w the buffer's own value at t - window:
///
///   value(t + b) = x + (x - x_w) min(b, furthest) / window
///
/// furthest = 0 is "clamp" (interaction) and "hold" (force): x itself, bit for bit. A buffer that does not hold t -
/// window (one entry, or a ring too small: latency_budget.h says how much the window needs) gives x as well.
///
/// The line starts a window back, not at the last entry but one: quantization q of the value tilts it by q / window
/// only, and emission times that were repaired to 1 ns apart (SlotMap::emission) do not tilt it at all. Where entries
/// lie further apart than the window it is the line through the last two.
///
/// Which window: at a distance b the value errs by q b / window (quantization) + a b (b + window) / 2 (acceleration a);
/// the sum is least at window = sqrt(2 q / a).

#include <algorithm>

#include "evenstep/remap/sample.h"

namespace evenstep {

struct Extrapolation {
  Duration window;     ///< base of the line; <= 0: none
  Duration furthest;   ///< how far it goes on before it is held; <= 0: not at all
  constexpr bool none() const { return window.ns <= 0 || furthest.ns <= 0; }
};

/// "clamp" for samples of the hand, "hold" for forces.
inline constexpr Extrapolation kHoldNewest{};
/// "extrapolate". Window: q = 30 um (a usual desktop device), a = 4 m/s^2 (1 mm at 10 Hz): 3.9 ms. Furthest: 10 Hz is
/// the fastest voluntary motion of a hand; continuing its line for b errs by up to (2 pi f)^2 b^2 / 2 of the amplitude,
/// 20 % at 10 ms (28 % with the window's own lag); beyond that holding is no worse.
inline constexpr Extrapolation kContinueLine{{4'000'000}, {10'000'000}};
/// The strategy `predict`: extrapolates at every step, so it is tuned to usual motion, a = 1 m/s^2 (7.7 ms), and has no
/// limit.
inline constexpr Extrapolation kPredictHand{{8'000'000}, {INT64_MAX}};

/// The value of `buffer` at `at`, past `newest`, the last of its first `head` entries; the equation above. Exactly that
/// entry's value where the two agree.
template <class Buffer, class Entry>
auto value_beyond(const Buffer& buffer, std::uint64_t head, const Entry& newest, RealTime at, Extrapolation policy) {
  if (policy.none()) return newest.value;
  const auto before = buffer.at(newest.time - policy.window, head);
  if (before.status != ReadStatus::inside) return newest.value;
  return lerp(newest.value, before.value, -ratio(std::min(at - newest.time, policy.furthest), policy.window));
}

}  // namespace evenstep
