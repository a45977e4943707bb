#pragma once
/// Values that the buffers carry, and the one operation they need of them.
/// A value is double, float, std::array<linear, N>, or any type with a * double and a + a (glm::dvec3, Eigen vectors).

#include <array>
#include <cstddef>
#include <cstdint>

#include "evenstep/time/time.h"

namespace evenstep {

/// (1 - w) a + w b, evaluated as a + w (b - a): exact at w = 0, and constant where a = b.
template <class Value>
constexpr Value lerp(const Value& a, const Value& b, double w) {
  return a + (b - a) * w;
}
template <class Value, std::size_t N>
constexpr std::array<Value, N> lerp(const std::array<Value, N>& a, const std::array<Value, N>& b, double w) {
  std::array<Value, N> result{};
  for (std::size_t i = 0; i < N; ++i) result[i] = lerp(a[i], b[i], w);
  return result;
}

/// part / whole, correctly rounded (seconds would round three times).
constexpr double ratio(Duration part, Duration whole) {
  return static_cast<double>(part.ns) / static_cast<double>(whole.ns);
}

enum class ReadStatus : std::uint8_t {
  inside,    ///< between two entries, or exactly on one
  underrun,  ///< newer than the newest entry: value by the buffer's policy (extrapolation.h)
  overrun,   ///< older than the ring holds: the oldest value is returned (Value{} if even the newest entry of that head
             ///< has left) and must not be used as if it were right
  empty,     ///< nothing was ever pushed: Value{}
};

template <class Value>
struct Reading {
  Value value{};
  ReadStatus status = ReadStatus::empty;
  RealTime newest;     ///< time of the newest entry that was visible
};

}  // namespace evenstep
