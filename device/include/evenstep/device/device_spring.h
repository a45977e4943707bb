#pragma once
/// Expresses a contact as springs, which the device renders at its own rate of thousands of times a second, instead of as
/// forces at the rate of the loop:
///
///   F(x) = F_a + alpha K (x_c - x)   is, along an axis with k = alpha K > 0, the spring k (cp - x),   cp = x_c + F_a / k.
///
/// A contact that only pushes has a spring only on the penetrating side of cp: below cp if the normal points up the axis.
/// There is one spring per axis, so K must be diagonal. For a contact that only pushes, the normal must lie along one axis,
/// and K must be 0 along the others. The part of the springs that a device does not render is left to the loop as a force.

#include <glm/vec3.hpp>
#include <optional>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/renderer.h"

namespace evenstep {

/// The springs for a contact; empty if springs along the axes cannot express it. An axis with K = 0 gets no spring.
std::optional<DeviceSpring> device_spring(const AffineContact& contact, double alpha, double limit_N);

/// The springs' force on a hand at `hand_m`.
glm::dvec3 force_N(const DeviceSpring& spring, const glm::dvec3& hand_m);

}  // namespace evenstep
