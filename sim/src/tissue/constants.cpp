#include "src/tissue/constants.h"

#include <cmath>

namespace evenstep::internal {
namespace {

template <class Real>
std::array<Real, 3> neutral_where_zero(const glm::dvec3& v) {
  const auto real = [](double x) { return x == 0 ? -Real{0} : static_cast<Real>(x); };
  return {real(v.x), real(v.y), real(v.z)};
}

}  // namespace

template <class Real>
TissueConstants<Real>::TissueConstants(const TissueScene& scene, const Lattice& lattice, double substep_s) {
  const Real spacing = static_cast<Real>(scene.spacing_m);
  for (std::size_t s = 0; s < kNeighbours; ++s) {
    const Neighbour& n = kNeighbourhood[s];
    rest_m[s] = {spacing * static_cast<Real>(n.dx), spacing * static_cast<Real>(n.dy), spacing * static_cast<Real>(n.dz)};
    const auto& [x, y, z] = rest_m[s];
    length_m[s] = std::sqrt(x * x + y * y + z * z);  // computed as in the kernels: at rest 1 - L/len is exactly 0
    const double length2_m2 = scene.spacing_m * scene.spacing_m * (n.dx * n.dx + n.dy * n.dy + n.dz * n.dz);
    axial_s_per_m2[s] = static_cast<Real>(scene.axial_damping_N_s_per_m / scene.stiffness_N_per_m / length2_m2);
  }
  set_substep(scene, substep_s);
  stiffness_per_kg = static_cast<Real>(scene.stiffness_N_per_m / scene.particle_mass_kg);
  damping_per_s = static_cast<Real>(scene.damping_per_s);
  gravity_m_per_s2 = neutral_where_zero<Real>(scene.gravity_m_per_s2);
  stiffness_N_per_m = static_cast<Real>(scene.stiffness_N_per_m);
  half_mass_kg = static_cast<Real>(scene.particle_mass_kg / 2);
  quarter_stiffness_N_per_m = static_cast<Real>(scene.stiffness_N_per_m / 4);
  for (int axis = 0; axis < 3; ++axis)
    weight_N[static_cast<std::size_t>(axis)] = static_cast<Real>(scene.particle_mass_kg * scene.gravity_m_per_s2[axis]);
  for (std::size_t tool = 0; tool < scene.tools.size(); ++tool) {
    const ToolCoupling& coupling = scene.tools[tool];
    if (coupling.kind == CouplingKind::grab) continue;
    const bool is_probe = coupling.kind == CouplingKind::probe;
    const double shared_by = is_probe ? 1 : static_cast<double>(lattice.held[tool].size());
    ToolConstants<Real>& constants = tools[tool];
    constants.stiffness = static_cast<Real>(coupling.stiffness_N_per_m / shared_by / scene.stiffness_N_per_m);
    constants.damping_s = static_cast<Real>(coupling.damping_N_s_per_m / shared_by / scene.stiffness_N_per_m);
    constants.half_stiffness_N_per_m = static_cast<Real>(coupling.stiffness_N_per_m / shared_by / 2);
    if (!is_probe) continue;
    constants.radius_m = static_cast<Real>(coupling.radius_m);
    for (int axis = 0; axis < 3; ++axis)
      constants.center_m[static_cast<std::size_t>(axis)] = static_cast<Real>(coupling.center_m[axis]);
  }
}
template <class Real>
void TissueConstants<Real>::set_substep(const TissueScene& scene, double substep_s) {
  step_s = static_cast<Real>(substep_s);
  half_step_s = static_cast<Real>(substep_s / 2);
  acceleration = static_cast<Real>(scene.stiffness_N_per_m * substep_s / scene.particle_mass_kg);
  decay = static_cast<Real>(1 - scene.damping_per_s * substep_s);
  gravity = neutral_where_zero<Real>(scene.gravity_m_per_s2 * substep_s);
}
template struct TissueConstants<float>;
template struct TissueConstants<double>;

template <class Real>
MaterialArrays<Real>::MaterialArrays(const TissueScene& scene, const Lattice& lattice)
    : stiffness(lattice.cells), inverse_mass(lattice.cells), mass(lattice.cells) {
  const Materials materials(scene, lattice);
  for (std::size_t cell = 0; cell < lattice.cells; ++cell) {
    if (lattice.active[cell] == 0) continue;
    stiffness[cell] = static_cast<Real>(materials.stiffness_N_per_m(cell) / scene.stiffness_N_per_m);
    if (lattice.mobile[cell] == 0) continue;
    inverse_mass[cell] = static_cast<Real>(scene.particle_mass_kg / materials.mass_kg(cell));
    mass[cell] = static_cast<Real>(materials.mass_kg(cell) / scene.particle_mass_kg);
  }
}
template struct MaterialArrays<float>;
template struct MaterialArrays<double>;

template <class Real>
std::vector<Real> held_cells(const TissueScene& scene, const Lattice& lattice, std::size_t tool) {
  std::vector<Real> held(lattice.cells);
  if (tool < scene.tools.size() && scene.tools[tool].kind == CouplingKind::spring)
    for (const std::uint32_t cell : lattice.held[tool]) held[cell] = 1;
  return held;
}
template std::vector<float> held_cells(const TissueScene&, const Lattice&, std::size_t);
template std::vector<double> held_cells(const TissueScene&, const Lattice&, std::size_t);

template <class Real>
std::vector<Real> rest_positions(const TissueScene& scene, const Lattice& lattice, int component) {
  std::vector<Real> rest_m(lattice.cells);
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const int at = site_coordinates(scene, site)[static_cast<std::size_t>(component)];
    rest_m[lattice.cell(site)] = static_cast<Real>(static_cast<double>(at) * scene.spacing_m);
  }
  return rest_m;
}
template std::vector<float> rest_positions(const TissueScene&, const Lattice&, int);
template std::vector<double> rest_positions(const TissueScene&, const Lattice&, int);

}  // namespace evenstep::internal
