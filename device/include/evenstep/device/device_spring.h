#pragma once
/// Expresses a contact as springs, which the device renders at its own rate of thousands of times a second, instead of as
/// forces at the rate of the loop:
///
///   F(x) = F_a + alpha K (x_c - x)   is, along an axis with k = alpha K > 0, the spring k (cp - x),   cp = x_c + F_a / k.
///
/// There is one spring per axis, so only the diagonal of K can be expressed. What the springs leave out (the off-diagonal
/// stiffness of tissue, the coupling of two hands) is small where the tissue is symmetric to the axes, and is left to the
/// loop as a force, like what a device does not render. A contact that only pushes has one spring, along the axis that is
/// nearest to its normal and only on the penetrating side of cp: below cp if the normal points up the axis.

#include <glm/vec3.hpp>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/renderer.h"

namespace evenstep {

/// The springs for a contact. An axis along which K is not above 0 gets none.
DeviceSpring device_spring(const AffineContact& contact, double alpha, double limit_N);

/// The springs' force on a hand at `hand_m`.
glm::dvec3 force_N(const DeviceSpring& spring, const glm::dvec3& hand_m);

}  // namespace evenstep
