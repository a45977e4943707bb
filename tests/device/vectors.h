#pragma once
/// Vectors of random size and direction, and functions that measure them.

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <random>

namespace evenstep::test {

inline double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(const glm::dvec3& v) { return std::hypot(v.x, v.y, v.z); }
inline glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline bool same_bits(const glm::dvec3& a, const glm::dvec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Random numbers made from the generator's bits alone, so that they are the same with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform(double from, double to) { return from + (to - from) * (static_cast<double>(bits_() >> 11) * 0x1p-53); }
  glm::dvec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  glm::dvec3 direction() {
    for (;;) {
      const glm::dvec3 v = vector(1);
      const double size = length(v);
      if (size > 0.1 && size < 1) return v / size;
    }
  }
  /// Three orthonormal directions.
  std::array<glm::dvec3, 3> basis() {
    for (;;) {
      const glm::dvec3 a = vector(1), b = vector(1);
      const glm::dvec3 c = cross(a, b);
      if (length(c) < 0.1) continue;
      return {a / length(a), c / length(c), cross(c, a) / (length(c) * length(a))};
    }
  }

 private:
  std::mt19937_64 bits_;
};

}  // namespace evenstep::test
