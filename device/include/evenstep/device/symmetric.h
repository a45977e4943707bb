#pragma once
/// A symmetric 3x3 matrix and its principal axes, computed with basic arithmetic and square roots only, so that the result
/// has the same bits on every machine.

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace evenstep {

struct Symmetric {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
};
inline glm::dvec3 operator*(const Symmetric& a, const glm::dvec3& v) {
  return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z, a.xz * v.x + a.yz * v.y + a.zz * v.z};
}

/// a = sum over i of values[i] axes[i] axes[i]'. The axes are orthonormal and in no particular order.
struct Axes {
  std::array<double, 3> values{};
  std::array<glm::dvec3, 3> axes{};
};
/// By cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5), until the off-diagonal part is below rounding.
/// The values are right to a few roundings of the largest one. For a diagonal matrix the result is exact. For a matrix that
/// is not finite the values are not finite either.
Axes axes_of(const Symmetric& a);
/// The largest of the values; not finite if one of them is not.
double largest_value(const Axes& of);

/// The symmetric 6x6 matrix [K C; C' K'] of two hands in one tissue: rows and columns 0 to 2 are those of the first hand.
using Joint = std::array<std::array<double, 6>, 6>;
/// C as glm has it, [column][row]: the change of the first hand's force with the second hand.
Joint joint_of(const Symmetric& first, const glm::dmat3& coupling, const Symmetric& second);
/// a = sum over i of values[i] v_i v_i', where v_i is column i of `axes`. As axes_of.
struct JointAxes {
  std::array<double, 6> values{};
  Joint axes{};
};
JointAxes joint_axes_of(const Joint& a);
/// The largest of the values; not finite if one of them is not.
double largest_value(const JointAxes& of);

}  // namespace evenstep
