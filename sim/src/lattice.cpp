#include "src/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {
namespace {

/// More sites than fit 32-bit cell indices with room to spare, and far more than a haptic scene needs.
constexpr std::int64_t kMostSitesPerAxis = 1024;
constexpr std::int64_t kMostSites = 64'000'000;

std::int64_t sites(const TissueScene& scene) {
  return static_cast<std::int64_t>(scene.lattice[0]) * scene.lattice[1] * scene.lattice[2];
}

void require(bool holds, const std::string& what, const std::string& remedy) {
  if (!holds) throw SolverError(SolverFault::bad_scene, what, remedy);
}

bool positive(double value) { return std::isfinite(value) && value > 0; }

}  // namespace

const std::array<Neighbour, kNeighbours> kNeighbourhood{{{-1, 0, 0},  {1, 0, 0},  {0, -1, 0}, {0, 1, 0},  {0, 0, -1},  {0, 0, 1},
                                                         {-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0},  {-1, 0, -1}, {1, 0, -1},
                                                         {-1, 0, 1},  {1, 0, 1},  {0, -1, -1}, {0, 1, -1}, {0, -1, 1},  {0, 1, 1}}};

Lattice::Lattice(const TissueScene& scene) {
  const auto [nx, ny, nz] = scene.lattice;
  const std::ptrdiff_t px = nx + 1, py = ny + 1;
  first = static_cast<std::size_t>(px * py + px + 1);
  const std::size_t used = static_cast<std::size_t>(px * py * nz);
  span = (used + kChunk - 1) / kChunk * kChunk;
  cells = first + span + first;
  for (int s = 0; s < kNeighbours; ++s) {
    const Neighbour& n = kNeighbourhood[static_cast<std::size_t>(s)];
    offset[static_cast<std::size_t>(s)] = n.dx + px * (n.dy + py * n.dz);
  }
  active.assign(cells, 0);
  mobile.assign(cells, 0);
  grabbed.resize(scene.grabs.size());
  std::vector<std::int64_t> site_of(cells, -1);
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::int64_t x = site % nx, y = site / nx % ny, z = site / nx / ny;
    const std::size_t cell = first + static_cast<std::size_t>(x + px * (y + py * z));
    active[cell] = 1;
    site_of[cell] = site;
    const bool fixed = scene.fixed_bottom && z == 0;
    mobile[cell] = !fixed;
    if (fixed) continue;
    const glm::dvec3 position_m = glm::dvec3(x, y, z) * scene.spacing_m;
    for (std::size_t tool = 0; tool < scene.grabs.size(); ++tool) {
      const glm::dvec3 d = position_m - scene.grabs[tool].center_m;
      if (d.x * d.x + d.y * d.y + d.z * d.z > scene.grabs[tool].radius_m * scene.grabs[tool].radius_m) continue;
      require(mobile[cell], fmt::format("tools {} and {} both grab the particle at ({}, {}, {}) mm", 0, tool, position_m.x * 1e3, position_m.y * 1e3, position_m.z * 1e3),
              "move the grabs apart or make their radius smaller");
      grabbed[tool].push_back(static_cast<std::uint32_t>(cell));
      mobile[cell] = 0;
    }
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (!active[cell]) continue;
    std::int64_t count = 0;
    for (const std::ptrdiff_t o : offset) count += active[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(cell) + o)];
    springs += count;
    if (count <= most_springs_of_a_particle) continue;
    most_springs_of_a_particle = count;
    particle_with_most_springs = site_of[cell];
  }
  springs /= 2;
  for (std::size_t tool = 0; tool < grabbed.size(); ++tool) {
    const glm::dvec3& c = scene.grabs[tool].center_m;
    require(!grabbed[tool].empty(), fmt::format("tool {} grabs no particle that can move: none within {} mm of ({}, {}, {}) mm", tool, scene.grabs[tool].radius_m * 1e3, c.x * 1e3, c.y * 1e3, c.z * 1e3),
            fmt::format("the block spans (0, 0, 0) to ({}, {}, {}) mm, spacing {} mm; its bottom layer is fixed", (nx - 1) * scene.spacing_m * 1e3, (ny - 1) * scene.spacing_m * 1e3, (nz - 1) * scene.spacing_m * 1e3, scene.spacing_m * 1e3));
  }
}

void check_tissue(const TissueScene& scene, int tool_count) {
  for (const int n : scene.lattice) {
    require(n >= 2 && n <= kMostSitesPerAxis, fmt::format("a lattice axis of {} sites", n), fmt::format("2 to {} per axis", kMostSitesPerAxis));
  }
  require(sites(scene) <= kMostSites, fmt::format("a lattice of {} sites", sites(scene)), fmt::format("at most {}", kMostSites));
  require(scene.particle_count >= 1 && scene.particle_count <= sites(scene),
          fmt::format("{} particles on a lattice of {} sites", scene.particle_count, sites(scene)), "1 to as many as the lattice has");
  require(positive(scene.particle_mass_kg), fmt::format("a particle mass of {} kg", scene.particle_mass_kg), "a positive mass");
  require(positive(scene.spacing_m), fmt::format("a spacing of {} m", scene.spacing_m), "a positive spacing");
  require(std::isfinite(scene.stiffness_N_per_m) && scene.stiffness_N_per_m >= 0, fmt::format("a stiffness of {} N/m", scene.stiffness_N_per_m), "zero or more");
  require(std::isfinite(scene.damping_per_s) && scene.damping_per_s >= 0, fmt::format("a damping of {} /s", scene.damping_per_s), "zero or more");
  require(scene.substeps >= 0, fmt::format("{} substeps", scene.substeps), "1 or more, or \"auto\"");
  require(tool_count >= 0 && tool_count <= kMaxTools, fmt::format("{} tools", tool_count), fmt::format("at most {}", kMaxTools));
  require(static_cast<std::size_t>(tool_count) == scene.grabs.size(), fmt::format("{} tools but {} grabs", tool_count, scene.grabs.size()), "one grab per device");
  for (const Grab& grab : scene.grabs) {
    require(std::isfinite(grab.center_m.x + grab.center_m.y + grab.center_m.z) && std::isfinite(grab.radius_m) && grab.radius_m >= 0, "a grab that is not finite", "a centre and a radius in metres");
  }
}

}  // namespace evenstep::internal
