#pragma once
/// A contact as springs that the device renders at its own rate, thousands of times a second, instead of forces at the
/// loop's:
///
///   F(x) = F_a + alpha K (x_c - x)   is, along an axis with k = alpha K > 0, the spring k (cp - x),   cp = x_c + F_a / k.
///
/// A contact that only pushes is a spring on the penetrating side of cp alone: below it where the normal points up the axis.
/// Springs are one per axis: K must be diagonal, and the normal of a contact that only pushes along one axis, with K along
/// no other. What a device does not render of them is a force for the loop.

#include <glm/vec3.hpp>
#include <optional>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/renderer.h"

namespace evenstep {

/// None where springs along the axes cannot say it. An axis with K = 0 gets no spring.
std::optional<DeviceSpring> device_spring(const AffineContact& contact, double alpha, double limit_N);

/// The springs' force on a hand at `hand_m`.
glm::dvec3 force_N(const DeviceSpring& spring, const glm::dvec3& hand_m);

}  // namespace evenstep
