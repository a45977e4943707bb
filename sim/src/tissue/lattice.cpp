#include "src/tissue/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {
namespace {

/// Limits the lattice so that a cell's index fits into the 32 bits of a grab list.
constexpr std::int64_t kMostSitesPerAxis = 1024;

std::int64_t sites(const TissueScene& scene) {
  return static_cast<std::int64_t>(scene.lattice[0]) * scene.lattice[1] * scene.lattice[2];
}

void require(bool holds, const std::string& what, const std::string& remedy) {
  if (!holds) throw SolverError(SolverFault::bad_scene, what, remedy);
}

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
std::string millimetres(const glm::dvec3& v) {
  return fmt::format("({:g}, {:g}, {:g}) mm", v.x * 1e3, v.y * 1e3, v.z * 1e3);
}

bool is_fixed(const TissueScene& scene, int x, int y, int z) {
  const auto [nx, ny, nz] = scene.lattice;
  const FixedFaces& fixed = scene.fixed;
  return (fixed.x_min && x == 0) || (fixed.x_max && x == nx - 1) || (fixed.y_min && y == 0) ||
         (fixed.y_max && y == ny - 1) || (fixed.z_min && z == 0) || (fixed.z_max && z == nz - 1);
}

std::string fixed_faces(const FixedFaces& fixed) {
  std::string names;
  for (const auto& [is_fixed, name] :
       {std::pair{fixed.x_min, "left"}, std::pair{fixed.x_max, "right"}, std::pair{fixed.y_min, "front"},
        std::pair{fixed.y_max, "back"}, std::pair{fixed.z_min, "bottom"}, std::pair{fixed.z_max, "top"}}) {
    if (is_fixed) names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names;
}

/// Requires 1e-15 to 1e15, so that the value, its square and its reciprocal are positive and finite in float too.
void require_positive(double value, const char* name, const char* unit) {
  require(value >= 1e-15 && value <= 1e15, fmt::format("a {} of {:g} {}", name, value, unit),
          fmt::format("a positive {}", name));
}

double greatest(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

void check_coupling(const ToolCoupling& tool) {
  require(finite(tool.center_m) && std::isfinite(tool.radius_m) && tool.radius_m >= 0, "a coupling that is not finite",
          "a centre and a radius in metres");
  if (tool.kind == CouplingKind::grab) {
    require(tool.stiffness_N_per_m == 0 && tool.damping_N_s_per_m == 0, "a grab with a stiffness or a damping",
            "a grab is rigid; a spring has them");
    return;
  }
  require_positive(tool.stiffness_N_per_m, "coupling stiffness", "N/m");
  const double most = tool.kind == CouplingKind::spring ? 1e15 : 0;
  require(tool.damping_N_s_per_m >= 0 && tool.damping_N_s_per_m <= most,
          fmt::format("a coupling damping of {:g} N s/m", tool.damping_N_s_per_m),
          most > 0 ? "zero or more" : "zero: a probe has none");
}

}  // namespace

const std::array<Neighbour, kNeighbours> kNeighbourhood{{{-1, 0, 0},
                                                         {1, 0, 0},
                                                         {0, -1, 0},
                                                         {0, 1, 0},
                                                         {0, 0, -1},
                                                         {0, 0, 1},
                                                         {-1, -1, 0},
                                                         {1, -1, 0},
                                                         {-1, 1, 0},
                                                         {1, 1, 0},
                                                         {-1, 0, -1},
                                                         {1, 0, -1},
                                                         {-1, 0, 1},
                                                         {1, 0, 1},
                                                         {0, -1, -1},
                                                         {0, 1, -1},
                                                         {0, -1, 1},
                                                         {0, 1, 1}}};

Lattice::Lattice(const TissueScene& scene) : nx_(scene.lattice[0]), ny_(scene.lattice[1]) {
  const auto [nx, ny, nz] = scene.lattice;
  const std::ptrdiff_t px = nx + 1, py = ny + 1;
  first = static_cast<std::size_t>(px * py + px + 1);
  const auto used = static_cast<std::size_t>(px * py * nz);
  span = (used + kChunk - 1) / kChunk * kChunk;
  cells = first + span + first;
  for (std::size_t s = 0; s < kNeighbours; ++s) {
    const Neighbour& n = kNeighbourhood[s];
    offset[s] = n.dx + px * (n.dy + py * n.dz);
  }
  active.assign(cells, 0);
  mobile.assign(cells, 0);
  held.resize(scene.tools.size());
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const auto [x, y, z] = site_coordinates(scene, site);
    const std::size_t at = cell(site);
    active[at] = 1;
    if (is_fixed(scene, x, y, z)) continue;
    mobile[at] = !hold(scene, at, glm::dvec3(x, y, z) * scene.spacing_m);
  }
  for (std::size_t tool = 0; tool < held.size(); ++tool) {
    const ToolCoupling& empty = scene.tools[tool];
    if (empty.kind == CouplingKind::probe) continue;
    require(!held[tool].empty(),
            fmt::format("tool {} holds no particle that can move: none within {:g} mm of {}", tool, empty.radius_m * 1e3,
                        millimetres(empty.center_m)),
            fmt::format("the block spans (0, 0, 0) mm to {} in steps of {:g} mm{}",
                        millimetres(glm::dvec3(nx - 1, ny - 1, nz - 1) * scene.spacing_m), scene.spacing_m * 1e3,
                        scene.fixed.any() ? fmt::format("; fixed: {}", fixed_faces(scene.fixed)) : ""));
  }
  count_springs(scene);
}

bool Lattice::hold(const TissueScene& scene, std::size_t cell, const glm::dvec3& position_m) {
  int holder = -1;
  for (int tool = 0; tool < static_cast<int>(scene.tools.size()); ++tool) {
    const ToolCoupling& candidate = scene.tools[static_cast<std::size_t>(tool)];
    const glm::dvec3 d = position_m - candidate.center_m;
    if (candidate.kind == CouplingKind::probe) continue;
    if (d.x * d.x + d.y * d.y + d.z * d.z > candidate.radius_m * candidate.radius_m) continue;
    require(holder < 0, fmt::format("tools {} and {} both hold the particle at {}", holder, tool, millimetres(position_m)),
            "move the tools apart or make their radius smaller");
    held[static_cast<std::size_t>(tool)].push_back(static_cast<std::uint32_t>(cell));
    holder = tool;
  }
  return holder >= 0 && scene.tools[static_cast<std::size_t>(holder)].kind == CouplingKind::grab;
}

void Lattice::count_springs(const TissueScene& scene) {
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::size_t at = cell(site);
    std::int64_t count = 0;
    for (const std::ptrdiff_t o : offset) count += active[at + static_cast<std::size_t>(o)];
    springs += count;
    if (count <= most_springs_of_a_particle) continue;
    most_springs_of_a_particle = count;
    particle_with_most_springs = site;
  }
  springs /= 2;
}

double cells_of(const TissueScene& scene) {
  const double px = scene.lattice[0] + 1.0, py = scene.lattice[1] + 1.0;
  return px * py * (scene.lattice[2] + 2.0) + 2 * (px + 1) + kChunk;
}

void check_tissue(const TissueScene& scene, int tool_count) {
  for (const int n : scene.lattice) {
    require(n >= 1 && n <= kMostSitesPerAxis, fmt::format("a lattice axis of {} sites", n),
            fmt::format("1 to {} per axis", kMostSitesPerAxis));
  }
  require(scene.particle_count >= 1 && scene.particle_count <= sites(scene),
          fmt::format("{} particles on a lattice of {} sites", scene.particle_count, sites(scene)),
          "1 to as many as the lattice has");
  require_positive(scene.particle_mass_kg, "particle mass", "kg");
  require_positive(scene.spacing_m, "spacing", "m");
  require_positive(scene.stiffness_N_per_m, "stiffness", "N/m");
  require(scene.damping_per_s >= 0 && scene.damping_per_s <= 1e15, fmt::format("a damping of {:g} /s", scene.damping_per_s),
          "zero or more");
  require(scene.substeps >= 0 && scene.substeps <= kMaxSubsteps, fmt::format("{} substeps", scene.substeps),
          fmt::format("1 to {}, or \"auto\"", kMaxSubsteps));
  require(tool_count >= 0 && tool_count <= kMaxTools, fmt::format("{} tools", tool_count),
          fmt::format("at most {}", kMaxTools));
  require(static_cast<std::size_t>(tool_count) == scene.tools.size(),
          fmt::format("{} tools but {} couplings", tool_count, scene.tools.size()), "one coupling per device");
  for (const ToolCoupling& tool : scene.tools) check_coupling(tool);
  require(scene.axial_damping_N_s_per_m >= 0 && scene.axial_damping_N_s_per_m <= 1e15,
          fmt::format("an axial damping of {:g} N s/m", scene.axial_damping_N_s_per_m), "zero or more");
  require(finite(scene.gravity_m_per_s2) && greatest(scene.gravity_m_per_s2) <= 1e15, "a gravity that is not finite",
          "three accelerations in m/s2");
  require(scene.regions.size() <= kMaxRegions, fmt::format("{} regions", scene.regions.size()),
          fmt::format("at most {}", kMaxRegions));
  for (const MaterialRegion& region : scene.regions) {
    require_positive(region.particle_mass_kg, "particle mass of a region", "kg");
    require_positive(region.stiffness_N_per_m, "stiffness of a region", "N/m");
    require(finite(region.min_m) && finite(region.max_m), "a region that is not finite", "two corners in metres");
  }
  require(scene.iterations >= 0 && scene.iterations <= kMaxIterations, fmt::format("{} iterations", scene.iterations),
          fmt::format("1 to {}", kMaxIterations));
  for (const auto* initial : {&scene.initial_displacement_m, &scene.initial_velocity_m_per_s}) {
    require(initial->empty() || static_cast<std::int64_t>(initial->size()) == scene.particle_count,
            fmt::format("an initial state of {} particles for {}", initial->size(), scene.particle_count), "one entry each");
    for (const glm::dvec3& value : *initial)
      require(finite(value) && greatest(value) <= 1e15, "an initial state that is not finite",
              "metres and metres per second");
  }
}

}  // namespace evenstep::internal
