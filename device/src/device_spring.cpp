#include "evenstep/device/device_spring.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace evenstep {
namespace {

glm::dvec3 diagonal(const Symmetric& k) { return {k.xx, k.yy, k.zz}; }

/// The axis that is nearest to a normal; of several equally near ones, the first.
int axis_of(const glm::dvec3& normal) {
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
  return axis;
}

}  // namespace

DeviceSpring device_spring(const AffineContact& contact, double alpha, double limit_N) {
  assert(alpha > 0 && limit_N >= 0);
  const glm::dvec3 k = diagonal(contact.stiffness_N_per_m) * alpha;
  const bool pushes_only = contact.outward != glm::dvec3(0);
  const int pushed = axis_of(contact.outward);
  DeviceSpring spring;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(k[axis] > 0) || (pushes_only && axis != pushed)) continue;
    spring.center_m[axis] = contact.tool_m[axis] + contact.force_N[axis] / k[axis];
    if (!pushes_only || contact.outward[axis] > 0) spring.below_N_per_m[axis] = k[axis];
    if (!pushes_only || contact.outward[axis] < 0) spring.above_N_per_m[axis] = k[axis];
    spring.limit_N[axis] = limit_N;
  }
  return spring;
}

glm::dvec3 force_N(const DeviceSpring& spring, const glm::dvec3& hand_m) {
  glm::dvec3 force{0};
  for (int axis = 0; axis < 3; ++axis) {
    const double stretch_m = spring.center_m[axis] - hand_m[axis];
    const double k = stretch_m > 0 ? spring.below_N_per_m[axis] : spring.above_N_per_m[axis];
    force[axis] = std::clamp(k * stretch_m, -spring.limit_N[axis], spring.limit_N[axis]);
  }
  return force;
}

}  // namespace evenstep
