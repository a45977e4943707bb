#pragma once
/// The value returned by a read past the newest entry of a buffer. Such a read is an underrun under every policy; the
/// policy only chooses its value. With x the newest value, at time t, and x_w the buffer's own value at t - window:
///
///   value(t + b) = x + (x - x_w) min(b, furthest) / window
///
/// furthest = 0 is called "clamp" for samples and "hold" for forces: the value is x itself, bit for bit. The same holds if
/// the buffer does not reach back to t - window (it has one entry, or its ring is too small: latency_budget.h says how much
/// the window needs).
///
/// The line starts a window back, not at the last entry but one. So a quantization q of the value tilts it by q / window
/// at most, and emission times that were repaired to 1 ns apart (SlotMap::emission) do not tilt it at all. If entries are
/// further apart than the window, it is the line through the last two.
///
/// Choice of the window: at a distance b the value is wrong by q b / window (quantization) + a b (b + window) / 2
/// (acceleration a); the sum is least at window = sqrt(2 q / a).

#include <algorithm>

#include "evenstep/remap/sample.h"
#include "evenstep/remap/timed_ring.h"

namespace evenstep {

struct Extrapolation {
  Duration window;    ///< how far back the line starts; <= 0: no line
  Duration furthest;  ///< how far past the newest entry the line goes on before its value is held; <= 0: not at all
  constexpr bool none() const { return window.ns <= 0 || furthest.ns <= 0; }
};

/// "clamp" for samples of the hand, "hold" for forces.
inline constexpr Extrapolation kHoldNewest{};
/// "extrapolate". Window: q = 30 um (a usual desktop device) and a = 4 m/s^2 (1 mm at 10 Hz) give 3.9 ms. Furthest: 10 Hz
/// is the fastest voluntary motion of a hand; continuing its line for a time b is wrong by up to (2 pi f)^2 b^2 / 2 of the
/// amplitude, 20 % at 10 ms (28 % with the window's own lag); beyond that, holding the value is no worse.
inline constexpr Extrapolation kContinueLine{{4'000'000}, {10'000'000}};
/// For the strategy `predict`. It extrapolates at every step, so its window is chosen for ordinary motion, a = 1 m/s^2
/// (7.7 ms), and it goes on without a limit.
inline constexpr Extrapolation kPredictHand{{8'000'000}, {INT64_MAX}};

/// The value at a time `at` past `newest`, the last of the first `head` entries of `ring`, by the equation above. If the
/// newest value and the one a window before it are equal, the result is exactly that value.
template <class Value>
Value value_beyond(const TimedRing<Value>& ring, std::uint64_t head, const typename TimedRing<Value>::Entry& newest,
                   RealTime at, Extrapolation policy) {
  using Ring = TimedRing<Value>;
  if (policy.none()) return newest.value;
  const RealTime start = newest.time - policy.window;
  typename Ring::Entry earlier{}, later = newest;
  if (ring.find(start, head, earlier, later) != Ring::Place::between) return newest.value;
  const Value before = lerp(earlier.value, later.value, ratio(start - earlier.time, later.time - earlier.time));
  return lerp(newest.value, before, -ratio(std::min(at - newest.time, policy.furthest), policy.window));
}

}  // namespace evenstep
