#include "src/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {
namespace {

/// So that a cell's index fits the 32 bits of a grab list.
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

/// Positive and finite in float too, with its square and reciprocal: from 1e-15 to 1e15.
void require_positive(double value, const char* name, const char* unit) {
  require(value >= 1e-15 && value <= 1e15, fmt::format("a {} of {:g} {}", name, value, unit),
          fmt::format("a positive {}", name));
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

Lattice::Lattice(const TissueScene& scene) {
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
  grabbed.resize(scene.grabs.size());
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::int64_t x = site % nx, y = site / nx % ny, z = site / nx / ny;
    const std::size_t cell = first + static_cast<std::size_t>(x + px * (y + py * z));
    active[cell] = 1;
    if (scene.fixed_bottom && z == 0) continue;
    mobile[cell] = !grab(scene, cell, glm::dvec3(x, y, z) * scene.spacing_m);
  }
  for (std::size_t tool = 0; tool < grabbed.size(); ++tool) {
    const Grab& empty = scene.grabs[tool];
    require(!grabbed[tool].empty(),
            fmt::format("tool {} grabs no particle that can move: none within {:g} mm of {}", tool, empty.radius_m * 1e3,
                        millimetres(empty.center_m)),
            fmt::format("the block spans (0, 0, 0) mm to {} in steps of {:g} mm{}",
                        millimetres(glm::dvec3(nx - 1, ny - 1, nz - 1) * scene.spacing_m), scene.spacing_m * 1e3,
                        scene.fixed_bottom ? "; its bottom layer is fixed" : ""));
  }
  count_springs(scene);
}

bool Lattice::grab(const TissueScene& scene, std::size_t cell, const glm::dvec3& position_m) {
  int holder = -1;
  for (int tool = 0; tool < static_cast<int>(scene.grabs.size()); ++tool) {
    const Grab& candidate = scene.grabs[static_cast<std::size_t>(tool)];
    const glm::dvec3 d = position_m - candidate.center_m;
    if (d.x * d.x + d.y * d.y + d.z * d.z > candidate.radius_m * candidate.radius_m) continue;
    require(holder < 0, fmt::format("tools {} and {} both grab the particle at {}", holder, tool, millimetres(position_m)),
            "move the grabs apart or make their radius smaller");
    grabbed[static_cast<std::size_t>(tool)].push_back(static_cast<std::uint32_t>(cell));
    holder = tool;
  }
  return holder >= 0;
}

void Lattice::count_springs(const TissueScene& scene) {
  const auto [nx, ny, nz] = scene.lattice;
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::size_t cell =
        first + static_cast<std::size_t>(site % nx + (nx + 1) * (site / nx % ny + (ny + 1) * (site / nx / ny)));
    std::int64_t count = 0;
    for (const std::ptrdiff_t o : offset) count += active[cell + static_cast<std::size_t>(o)];
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
    require(n >= 2 && n <= kMostSitesPerAxis, fmt::format("a lattice axis of {} sites", n),
            fmt::format("2 to {} per axis", kMostSitesPerAxis));
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
  require(static_cast<std::size_t>(tool_count) == scene.grabs.size(),
          fmt::format("{} tools but {} grabs", tool_count, scene.grabs.size()), "one grab per device");
  for (const Grab& grab : scene.grabs) {
    require(finite(grab.center_m) && std::isfinite(grab.radius_m) && grab.radius_m >= 0, "a grab that is not finite",
            "a centre and a radius in metres");
  }
}

}  // namespace evenstep::internal
