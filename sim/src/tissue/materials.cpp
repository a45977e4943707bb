#include "src/tissue/materials.h"

namespace evenstep::internal {

Materials::Materials(const TissueScene& scene, const Lattice& lattice)
    : stiffness_N_per_m_{scene.stiffness_N_per_m}, mass_kg_{scene.particle_mass_kg} {
  for (const MaterialRegion& region : scene.regions) {
    stiffness_N_per_m_.push_back(region.stiffness_N_per_m);
    mass_kg_.push_back(region.particle_mass_kg);
  }
  if (scene.regions.empty()) return;
  region_.assign(lattice.cells, 0);
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const auto [x, y, z] = site_coordinates(scene, site);
    const glm::dvec3 at_m = glm::dvec3(x, y, z) * scene.spacing_m;
    for (std::size_t r = 0; r < scene.regions.size(); ++r) {
      const auto& [min_m, max_m, stiffness, mass] = scene.regions[r];
      const bool inside = at_m.x >= min_m.x && at_m.y >= min_m.y && at_m.z >= min_m.z && at_m.x <= max_m.x &&
                          at_m.y <= max_m.y && at_m.z <= max_m.z;
      if (inside) region_[lattice.cell(site)] = static_cast<std::uint8_t>(r + 1);
    }
  }
}

}  // namespace evenstep::internal
