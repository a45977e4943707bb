#pragma once
/// The values that the buffers hold, and the one operation the buffers need: linear interpolation.
/// A value is a double, a float, any type with value * double, value + value and value - value (glm::dvec3, Eigen vectors),
/// or a std::array of such values.

#include <array>
#include <cstddef>
#include <cstdint>

#include "evenstep/time/time.h"

namespace evenstep {

/// (1 - w) a + w b, evaluated as a + w (b - a): exact at w = 0, and exactly a where a = b.
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

/// part / whole, rounded once (converting both to seconds first would round three times).
constexpr double ratio(Duration part, Duration whole) {
  return static_cast<double>(part.ns) / static_cast<double>(whole.ns);
}

enum class ReadStatus : std::uint8_t {
  inside,    ///< between two entries, or exactly on one; in a sample buffer also before the first ever pushed
  underrun,  ///< newer than the newest entry: value by the buffer's policy (extrapolation.h)
  overrun,   ///< older than the ring holds: the value is the oldest one (Value{} if even the newest entry of that head
             ///< has left the ring) and is wrong for the time asked for
  empty,     ///< nothing was pushed yet: Value{}
};

template <class Value>
struct Reading {
  Value value{};
  ReadStatus status = ReadStatus::empty;
  RealTime newest;  ///< time of the newest entry that was visible
};

}  // namespace evenstep
