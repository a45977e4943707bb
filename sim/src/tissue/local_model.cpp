#include "src/tissue/local_model.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "src/tissue/rest_hessian.h"

namespace evenstep::internal {
namespace {

bool holds(const Lattice& lattice, std::size_t tool, std::size_t cell) {
  return std::binary_search(lattice.held[tool].begin(), lattice.held[tool].end(), static_cast<std::uint32_t>(cell));
}

/// k (n n' + (1 - L/|d|) (I - n n')); d must not be 0.
glm::dmat3 spring_hessian(double stiffness_N_per_m, double rest_length_m, const glm::dvec3& d_m) {
  const double length_m = glm::length(d_m);
  const glm::dmat3 along = glm::outerProduct(d_m, d_m) / (length_m * length_m);
  return (along + (glm::dmat3(1) - along) * (1 - rest_length_m / length_m)) * stiffness_N_per_m;
}

/// Calls visit(cell at the other end, k) for each spring that pulls at the tool of a grab or a spring.
template <class Visit>
void for_couplings(const TissueScene& scene, const Lattice& lattice, const RestHessian& hessian, std::size_t tool,
                   const Visit& visit) {
  for (const std::uint32_t cell : lattice.held[tool]) {
    if (scene.tools[tool].kind == CouplingKind::spring) {
      visit(cell, glm::dmat3(hessian.coupling_N_per_m(cell)));
      continue;
    }
    for (std::size_t s = 0; s < kNeighbours; ++s) {
      const std::size_t to = hessian.neighbour(cell, s);
      if (lattice.active[to] && !holds(lattice, tool, to)) visit(to, hessian.spring(cell, s));
    }
  }
}

/// Whether the sums of a probe with this reach contain a particle. Decided with the same bits as in probe_sums
/// (cpu/cell_loops.h, probe.cl).
template <class Real>
bool counts(const glm::dvec3& displacement_m, const glm::dvec3& offset_m, const glm::dvec3& rest_m,
            const glm::dvec3& center_m, double reach_m) {
  Real square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Real d = (static_cast<Real>(displacement_m[axis]) - static_cast<Real>(offset_m[axis])) +
                   (static_cast<Real>(rest_m[axis]) - static_cast<Real>(center_m[axis]));
    square += d * d;
  }
  return square > 0 && static_cast<Real>(reach_m) - std::sqrt(square + Real{FLT_MIN}) > 0;
}

/// A compliance above this means that nothing resists.
constexpr double kFree_m_per_N = 1e30;

/// The displacement of a mobile particle under each of three unit forces on it.
glm::dmat3 nodal_compliance(const RestHessian& hessian, std::size_t cell, std::size_t cells) {
  glm::dmat3 compliance(0);
  for (int axis = 0; axis < 3; ++axis) {
    RestHessian::Cells load(cells, glm::dvec3(0));
    load[cell][axis] = 1;
    const auto [u, found] = hessian.solve(load);
    if (found)
      compliance[axis] = u[cell];
    else
      compliance[axis][axis] = kFree_m_per_N;
  }
  return (compliance + glm::transpose(compliance)) * 0.5;
}

}  // namespace

GrabStiffness::GrabStiffness(const TissueScene& scene, const Lattice& lattice) : springs_(scene.tools.size()) {
  const Materials materials(scene, lattice);
  const auto for_springs = [&](const auto& visit) {
    for (std::size_t tool = 0; tool < scene.tools.size(); ++tool) {
      if (scene.tools[tool].kind != CouplingKind::grab) continue;
      for (const std::uint32_t cell : lattice.held[tool]) {
        for (std::size_t s = 0; s < kNeighbours; ++s) {
          const std::size_t to = cell + static_cast<std::size_t>(lattice.offset[s]);
          if (lattice.active[to] && !holds(lattice, tool, to)) visit(tool, cell, static_cast<std::uint32_t>(to), s);
        }
      }
    }
  };
  for_springs([&](std::size_t, std::uint32_t cell, std::uint32_t to, std::size_t) {
    cells_.push_back(cell);
    cells_.push_back(to);
  });
  std::sort(cells_.begin(), cells_.end());
  cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
  const auto index = [&](std::uint32_t cell) {
    return static_cast<std::size_t>(std::lower_bound(cells_.begin(), cells_.end(), cell) - cells_.begin());
  };
  for_springs([&](std::size_t tool, std::uint32_t cell, std::uint32_t to, std::size_t s) {
    const Neighbour& d = kNeighbourhood[s];
    const glm::dvec3 rest_m = glm::dvec3(d.dx, d.dy, d.dz) * scene.spacing_m;
    const double k = spring_stiffness(materials.stiffness_N_per_m(cell), materials.stiffness_N_per_m(to));
    const bool to_tool =
        scene.tools.size() == 2 && scene.tools[1 - tool].kind == CouplingKind::grab && holds(lattice, 1 - tool, to);
    springs_[tool].push_back({index(cell), index(to), to_tool, rest_m, glm::length(rest_m), k});
  });
}

glm::dvec3 GrabStiffness::between(const Spring& spring, std::span<const std::array<double, 3>> displacement_m) {
  const auto &from = displacement_m[spring.held], &to = displacement_m[spring.other];
  return glm::dvec3(to[0] - from[0], to[1] - from[1], to[2] - from[2]) + spring.rest_m;
}

glm::dmat3 GrabStiffness::of(std::size_t tool, std::span<const std::array<double, 3>> displacement_m) const {
  glm::dmat3 sum(0);
  for (const Spring& spring : springs_[tool]) {
    const glm::dvec3 d = between(spring, displacement_m);
    if (d != glm::dvec3(0)) sum += spring_hessian(spring.stiffness_N_per_m, spring.length_m, d);
  }
  return sum;
}

glm::dmat3 GrabStiffness::coupling(std::size_t tool, std::span<const std::array<double, 3>> displacement_m) const {
  glm::dmat3 sum(0);
  for (const Spring& spring : springs_[tool]) {
    if (!spring.to_tool) continue;
    const glm::dvec3 d = between(spring, displacement_m);
    if (d != glm::dvec3(0)) sum -= spring_hessian(spring.stiffness_N_per_m, spring.length_m, d);
  }
  return sum;
}

glm::dmat3 settled_stiffness(const TissueScene& scene, const Lattice& lattice, std::size_t tool) {
  const RestHessian hessian(scene, lattice);
  glm::dmat3 k(0);
  for (int axis = 0; axis < 3; ++axis) {
    RestHessian::Cells load(lattice.cells, glm::dvec3(0));
    for_couplings(scene, lattice, hessian, tool, [&](std::size_t free, const glm::dmat3& coupling) {
      k[axis] += coupling[axis];
      if (lattice.mobile[free]) load[free] += coupling[axis];
    });
    const RestHessian::Cells u = hessian.solve(load).x;  // always solvable: coupling or springs resist the load
    for_couplings(scene, lattice, hessian, tool,
                  [&](std::size_t free, const glm::dmat3& coupling) { k[axis] -= coupling * u[free]; });
  }
  return (k + glm::transpose(k)) * 0.5;
}

glm::dmat3 settled_coupling(const TissueScene& scene, const Lattice& lattice, std::size_t tool, std::size_t other) {
  const RestHessian hessian(scene, lattice);
  const bool rigid = scene.tools[other].kind == CouplingKind::grab;  // what it holds moves with it
  glm::dmat3 k(0);
  for (int axis = 0; axis < 3; ++axis) {
    RestHessian::Cells load(lattice.cells, glm::dvec3(0));
    for_couplings(scene, lattice, hessian, other, [&](std::size_t free, const glm::dmat3& coupling) {
      if (lattice.mobile[free]) load[free] += coupling[axis];
    });
    const RestHessian::Cells u = hessian.solve(load).x;
    for_couplings(scene, lattice, hessian, tool, [&](std::size_t free, const glm::dmat3& coupling) {
      k[axis] -= rigid && holds(lattice, other, free) ? coupling[axis] : coupling * u[free];
    });
  }
  return k;
}

ProbeCompliance::ProbeCompliance(const TissueScene& scene, const Lattice& lattice, bool in_double)
    : tools_(scene.tools), nodes_(scene.tools.size()), in_double_(in_double) {
  const RestHessian hessian(scene, lattice);
  for (std::size_t tool = 0; tool < tools_.size(); ++tool) {
    if (tools_[tool].kind != CouplingKind::probe) continue;
    std::vector<std::pair<double, std::int64_t>> nearest;  // squared distance, site
    const auto rest_m = [&](std::int64_t site) {
      const auto [x, y, z] = site_coordinates(scene, site);
      return glm::dvec3(x, y, z) * scene.spacing_m;
    };
    for (std::int64_t site = 0; site < scene.particle_count; ++site) {
      const glm::dvec3 d = rest_m(site) - tools_[tool].center_m;
      if (lattice.mobile[lattice.cell(site)]) nearest.emplace_back(glm::dot(d, d), site);
    }
    std::sort(nearest.begin(), nearest.end());
    if (nearest.size() > kMostProbedNodes) nearest.resize(kMostProbedNodes);
    for (const auto& [square_m2, site] : nearest) {
      const std::size_t cell = lattice.cell(site);
      nodes_[tool].push_back({cells_.size(), rest_m(site), nodal_compliance(hessian, cell, lattice.cells)});
      cells_.push_back(static_cast<std::uint32_t>(cell));
    }
  }
}

glm::dmat3 ProbeCompliance::settled(std::size_t tool, const glm::dvec3& offset_m, double reach_m,
                                    std::span<const std::array<double, 3>> displacement_m,
                                    const glm::dmat3& instantaneous_N_per_m) const {
  const ToolCoupling& probe = tools_[tool];
  const glm::dvec3 center_m = probe.center_m + offset_m;
  glm::dmat3 sum = instantaneous_N_per_m;
  for (const Node& node : nodes_[tool]) {
    const auto& [x, y, z] = displacement_m[node.at];
    const glm::dvec3 u(x, y, z), d = u + (node.rest_m - center_m);
    // Only a particle that the instantaneous sum contains may be subtracted from it.
    const bool counted = in_double_ ? counts<double>(u, offset_m, node.rest_m, probe.center_m, reach_m)
                                    : counts<float>(u, offset_m, node.rest_m, probe.center_m, reach_m);
    if (!counted || d == glm::dvec3(0)) continue;
    const glm::dvec3 n = d / glm::length(d);
    const double yields_m_per_N = 1 / probe.stiffness_N_per_m + glm::dot(n, node.compliance_m_per_N * n);
    sum += glm::outerProduct(n, n) / yields_m_per_N - spring_hessian(probe.stiffness_N_per_m, reach_m, d);
  }
  return sum;
}

}  // namespace evenstep::internal
