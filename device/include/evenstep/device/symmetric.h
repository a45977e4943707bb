#pragma once
/// A symmetric 3x3 matrix, and its axes: exact arithmetic and square roots only, so the same bits everywhere.

#include <array>
#include <glm/vec3.hpp>

namespace evenstep {

struct Symmetric {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
};
inline glm::dvec3 operator*(const Symmetric& a, const glm::dvec3& v) {
  return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z, a.xz * v.x + a.yz * v.y + a.zz * v.z};
}

/// a = sum over i of values[i] axes[i] axes[i]'; the axes are orthonormal. In no order.
struct Axes {
  std::array<double, 3> values{};
  std::array<glm::dvec3, 3> axes{};
};
/// By cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5), until what is left beside the diagonal is below
/// rounding; values to a few roundings of the largest. A diagonal matrix is its own answer. What is not finite has values that
/// are not.
Axes axes_of(const Symmetric& a);
/// The largest of the values; not finite where one is not.
double largest_value(const Axes& of);

}  // namespace evenstep
