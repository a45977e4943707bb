#include "hand_over.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace evenstep::internal {
namespace {

using Json = nlohmann::json;

Json json_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

using Site = std::array<int, 3>;

Site site_of(const TissueScene& scene, std::int64_t n) {
  const std::int64_t nx = scene.lattice[0], ny = scene.lattice[1];
  return {static_cast<int>(n % nx), static_cast<int>(n / nx % ny), static_cast<int>(n / (nx * ny))};
}

bool is_fixed(const TissueScene& scene, const Site& site) {
  const FixedFaces& f = scene.fixed;
  const auto [nx, ny, nz] = scene.lattice;
  return (f.x_min && site[0] == 0) || (f.x_max && site[0] == nx - 1) || (f.y_min && site[1] == 0) ||
         (f.y_max && site[1] == ny - 1) || (f.z_min && site[2] == 0) || (f.z_max && site[2] == nz - 1);
}

/// Neighbours differ by at most 1 along one or two axes.
bool are_joined(const Site& a, const Site& b) {
  int axes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int apart = std::abs(a[axis] - b[axis]);
    if (apart > 1) return false;
    axes += apart;
  }
  return axes == 1 || axes == 2;
}

}  // namespace

std::string options_with_particles(const std::string& options, const TissueScene& scene) {
  Json particles{{"mass", scene.particle_mass_kg}, {"stiffness", scene.stiffness_N_per_m},
                 {"rest", Json::array()},          {"displacement", Json::array()},
                 {"fixed", Json::array()},         {"springs", Json::array()}};
  // Sites are numbered x first, then y, then z; joined ones are a layer, a row and a site apart at most.
  const std::int64_t row = scene.lattice[0], layer = row * scene.lattice[1], reach = layer + row + 2;
  for (std::int64_t n = 0; n < scene.particle_count; ++n) {
    const Site site = site_of(scene, n);
    particles["rest"].push_back(json_of(glm::dvec3(site[0], site[1], site[2]) * scene.spacing_m));
    const auto index = static_cast<std::size_t>(n);
    particles["displacement"].push_back(
        json_of(scene.initial_displacement_m.empty() ? glm::dvec3(0) : scene.initial_displacement_m[index]));
    if (is_fixed(scene, site)) particles["fixed"].push_back(n);
    for (std::int64_t other = n + 1; other < std::min(scene.particle_count, n + reach); ++other) {
      if (are_joined(site, site_of(scene, other))) particles["springs"].push_back({n, other});
    }
  }
  Json all = Json::parse(options);
  all["particles"] = std::move(particles);
  return all.dump();
}

std::unique_ptr<Solver> make_case_solver(const ForeignScene& foreign, const Scene& scene) {
  Scene handed_over = scene;
  ForeignScene with_particles = foreign;
  with_particles.options = options_with_particles(foreign.options, std::get<TissueScene>(scene.body));
  handed_over.body = std::move(with_particles);
  std::unique_ptr<Solver> solver = make_solver(SolverKind::cpu_double, handed_over);
  const std::vector<std::string>& lacks = solver->info().lacks;
  if (std::find(lacks.begin(), lacks.end(), "particles") != lacks.end())
    throw SolverError(SolverFault::unavailable, "the solver '" + foreign.name + "' does not show its particles",
                      "the capability `particles` (foreign_solver.h)");
  return solver;
}

}  // namespace evenstep::internal
