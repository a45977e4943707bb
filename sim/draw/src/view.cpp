#include "evenstep/draw/view.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "evenstep/draw/tissue_mesh.h"

namespace evenstep {

glm::dvec3 View::clip(const glm::dvec3& position_m) const {
  const glm::dvec3 from_center_m = position_m - center_m;
  return {glm::dot(right, from_center_m) / half_width_m, glm::dot(up, from_center_m) / half_height_m,
          -glm::dot(to_eye, from_center_m) / half_depth_m};
}

View view_of(const TissueScene& tissue, int width, int height) {
  View view;
  view.to_eye = glm::normalize(glm::dvec3(0.55, -1, 0.62));
  view.right = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), view.to_eye));
  view.up = glm::cross(view.to_eye, view.right);
  const auto [nx, ny, nz] = tissue.lattice;
  const glm::dvec3 block_m = tissue.spacing_m * glm::dvec3(nx - 1, ny - 1, nz - 1);
  view.center_m = 0.5 * block_m;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 from_center_m = block_m * (glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) - glm::dvec3(0.5));
    view.half_width_m = std::max(corner == 0 ? 0 : view.half_width_m, std::abs(glm::dot(view.right, from_center_m)));
    view.half_height_m = std::max(corner == 0 ? 0 : view.half_height_m, std::abs(glm::dot(view.up, from_center_m)));
  }
  const double around_m = 0.2 * block_size_m(tissue);
  view.half_width_m += around_m;
  view.half_height_m += around_m;
  const double aspect = static_cast<double>(width) / height;
  view.half_width_m = std::max(view.half_width_m, view.half_height_m * aspect);
  view.half_height_m = view.half_width_m / aspect;
  view.half_depth_m = 8 * block_size_m(tissue);
  return view;
}

double brightness(const View& view, const glm::dvec3& normal) {
  const double length = glm::length(normal);
  if (!(length > 0)) return 1;
  const glm::dvec3 seen =
      glm::dvec3(glm::dot(normal, view.right), glm::dot(normal, view.up), glm::dot(normal, view.to_eye)) *
      ((glm::dot(normal, view.to_eye) < 0 ? -1 : 1) / length);
  return kAmbient + (1 - kAmbient) * std::max(0.0, glm::dot(seen, kLight));
}

}  // namespace evenstep
