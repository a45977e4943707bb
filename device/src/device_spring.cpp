#include "evenstep/device/device_spring.h"

#include <algorithm>
#include <cassert>

namespace evenstep {
namespace {

glm::dvec3 diagonal(const Symmetric& k) { return {k.xx, k.yy, k.zz}; }

/// The axis along which a normal lies; -1 if it lies along none.
int axis_of(const glm::dvec3& normal) {
  int axis = -1;
  for (int i = 0; i < 3; ++i) {
    if (normal[i] == 0) continue;
    if (axis >= 0) return -1;
    axis = i;
  }
  return axis;
}

}  // namespace

std::optional<DeviceSpring> device_spring(const AffineContact& contact, double alpha, double limit_N) {
  assert(alpha > 0 && limit_N >= 0);
  const Symmetric& stiffness = contact.stiffness_N_per_m;
  if (stiffness.xy != 0 || stiffness.yz != 0 || stiffness.xz != 0) return std::nullopt;
  const glm::dvec3 k = diagonal(stiffness) * alpha;
  const bool pushes_only = contact.outward != glm::dvec3(0);
  const int pushed = axis_of(contact.outward);
  if (pushes_only && pushed < 0) return std::nullopt;
  DeviceSpring spring;
  for (int axis = 0; axis < 3; ++axis) {
    if (k[axis] == 0) continue;
    if (k[axis] < 0 || (pushes_only && axis != pushed)) return std::nullopt;
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
