#pragma once
/// From where a tissue is seen: from above one of its corners, from infinitely far away (orthographic). The view is always
/// the same for a scene, so what moves in the picture moves in the tissue.

#include <glm/vec3.hpp>

#include "evenstep/sim/scene.h"

namespace evenstep {

/// All vectors are block coordinates. right, up and to_eye have length 1 and are perpendicular to each other.
struct View {
  glm::dvec3 right{1, 0, 0}, up{0, 0, 1}, to_eye{0, -1, 0};
  glm::dvec3 center_m{0};
  double half_width_m = 1, half_height_m = 1, half_depth_m = 1;  ///< what is shown around the center

  /// x from -1 (left) to 1 (right), y from -1 (bottom) to 1 (top), z from -1 (nearest) to 1 (farthest); outside: not shown.
  glm::dvec3 clip(const glm::dvec3& position_m) const;
};

/// A view of the whole block at rest, with a fifth of its size around it; `width` and `height` are those of the picture.
View view_of(const TissueScene& tissue, int width, int height);

/// How bright a face with this `normal` is (of any length, turned towards the eye): from kAmbient to 1. The light comes from
/// above the left shoulder.
double brightness(const View& view, const glm::dvec3& normal);
/// Where the light comes from, for `brightness`: its components along right, up and to_eye.
inline constexpr glm::dvec3 kLight{-0.28, 0.60, 0.75};
inline constexpr double kAmbient = 0.42;
/// How bright lines are, whatever the light.
inline constexpr double kLine = 0.36;

/// The colour behind everything: red, green and blue from 0 to 1.
inline constexpr glm::vec3 kBackground{0.96F, 0.96F, 0.97F};

}  // namespace evenstep
