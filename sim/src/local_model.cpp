#include "src/local_model.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "src/materials.h"

namespace evenstep::internal {
namespace {

constexpr double kSolved = 1e-9;
constexpr int kMostRounds = 5'000;

bool holds(const Lattice& lattice, std::size_t tool, std::size_t cell) {
  return std::binary_search(lattice.held[tool].begin(), lattice.held[tool].end(), static_cast<std::uint32_t>(cell));
}

/// The Hessian at rest over the cells that move, and a tool's coupling to them.
class RestHessian {
 public:
  RestHessian(const TissueScene& scene, const Lattice& lattice, std::size_t tool)
      : scene_(scene), lattice_(lattice), materials_(scene, lattice), tool_(tool), held_N_per_m_(lattice.cells, 0) {
    for (std::size_t cell = 0; cell < lattice.cells; ++cell)
      if (lattice.mobile[cell]) mobile_.push_back(cell);
    for (std::size_t t = 0; t < scene.tools.size(); ++t) {
      if (scene.tools[t].kind != CouplingKind::spring) continue;
      for (const std::uint32_t cell : lattice.held[t]) held_N_per_m_[cell] = share_N_per_m(t);
    }
  }

  /// K e of the tool, with the particles where they settle.
  glm::dvec3 settled_force(const glm::dvec3& e) const {
    std::vector<glm::dvec3> load(lattice_.cells, glm::dvec3(0));
    glm::dvec3 own_N(0);
    for_couplings([&](std::size_t free, const glm::dmat3& k) {
      own_N += k * e;
      if (lattice_.mobile[free]) load[free] += k * e;
    });
    const std::vector<glm::dvec3> u = solve(load);
    glm::dvec3 returned_N(0);
    for_couplings([&](std::size_t free, const glm::dmat3& k) { returned_N += k * u[free]; });
    return own_N - returned_N;
  }

 private:
  double share_N_per_m(std::size_t tool) const {
    return scene_.tools[tool].stiffness_N_per_m / static_cast<double>(lattice_.held[tool].size());
  }

  /// k n n' of the spring from a cell to its neighbour s.
  glm::dmat3 spring(std::size_t cell, std::size_t s) const {
    const Neighbour& d = kNeighbourhood[s];
    const glm::dvec3 n = glm::normalize(glm::dvec3(d.dx, d.dy, d.dz));
    const std::size_t to = neighbour(cell, s);
    return glm::outerProduct(n, n) * spring_stiffness(materials_.stiffness_N_per_m(cell), materials_.stiffness_N_per_m(to));
  }
  std::size_t neighbour(std::size_t cell, std::size_t s) const {
    return cell + static_cast<std::size_t>(lattice_.offset[s]);
  }

  /// Everything that pulls at the tool: visit(the particle at the other end, k).
  template <class Visit>
  void for_couplings(const Visit& visit) const {
    for (const std::uint32_t cell : lattice_.held[tool_]) {
      if (scene_.tools[tool_].kind == CouplingKind::spring) {
        visit(cell, glm::dmat3(share_N_per_m(tool_)));
        continue;
      }
      for (std::size_t s = 0; s < kNeighbours; ++s) {
        const std::size_t to = neighbour(cell, s);
        if (lattice_.active[to] && !holds(lattice_, tool_, to)) visit(to, spring(cell, s));
      }
    }
  }

  void apply(const std::vector<glm::dvec3>& x, std::vector<glm::dvec3>& y) const {
    for (const std::size_t cell : mobile_) {
      glm::dvec3 sum = x[cell] * held_N_per_m_[cell];
      for (std::size_t s = 0; s < kNeighbours; ++s) {
        const std::size_t to = neighbour(cell, s);
        if (!lattice_.active[to]) continue;
        const Neighbour& d = kNeighbourhood[s];
        const glm::dvec3 n(d.dx, d.dy, d.dz);
        const double k = spring_stiffness(materials_.stiffness_N_per_m(cell), materials_.stiffness_N_per_m(to));
        sum += n * (k * glm::dot(n, x[cell] - x[to]) / glm::dot(n, n));
      }
      y[cell] = sum;
    }
  }

  /// Of the diagonal; 1 where nothing resists, and so nothing pushes either.
  std::vector<glm::dvec3> preconditioner() const {
    std::vector<glm::dvec3> inverse(lattice_.cells, glm::dvec3(0));
    for (const std::size_t cell : mobile_) {
      glm::dvec3 diagonal(held_N_per_m_[cell]);
      for (std::size_t s = 0; s < kNeighbours; ++s) {
        if (!lattice_.active[neighbour(cell, s)]) continue;
        const glm::dmat3 k = spring(cell, s);
        diagonal += glm::dvec3(k[0][0], k[1][1], k[2][2]);
      }
      for (int axis = 0; axis < 3; ++axis) inverse[cell][axis] = diagonal[axis] > 0 ? 1 / diagonal[axis] : 1;
    }
    return inverse;
  }

  double dot(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) const {
    double sum = 0;
    for (const std::size_t cell : mobile_) sum += glm::dot(a[cell], b[cell]);
    return sum;
  }

  /// Conjugate gradients. Where a part of the tissue is free the matrix is singular, and the load is in its range.
  std::vector<glm::dvec3> solve(const std::vector<glm::dvec3>& load) const {
    const std::vector<glm::dvec3> inverse = preconditioner();
    std::vector<glm::dvec3> x(lattice_.cells, glm::dvec3(0)), y = x, z = x, r = load;
    for (const std::size_t cell : mobile_) z[cell] = inverse[cell] * r[cell];
    std::vector<glm::dvec3> p = z;
    const double enough = kSolved * kSolved * dot(load, load);
    double rz = dot(r, z);
    for (int round = 0; round < kMostRounds && dot(r, r) > enough; ++round) {
      apply(p, y);
      const double curvature = dot(p, y);
      if (!(curvature > 0)) break;
      const double length = rz / curvature;
      for (const std::size_t cell : mobile_) {
        x[cell] += length * p[cell];
        r[cell] -= length * y[cell];
        z[cell] = inverse[cell] * r[cell];
      }
      const double next = dot(r, z);
      for (const std::size_t cell : mobile_) p[cell] = z[cell] + (next / rz) * p[cell];
      rz = next;
    }
    return x;
  }

  const TissueScene& scene_;
  const Lattice& lattice_;
  Materials materials_;
  std::size_t tool_;
  std::vector<std::size_t> mobile_;
  std::vector<double> held_N_per_m_;
};

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
    springs_[tool].push_back({index(cell), index(to), rest_m, glm::length(rest_m), k});
  });
}

glm::dmat3 GrabStiffness::of(std::size_t tool, std::span<const std::array<double, 3>> displacement_m) const {
  glm::dmat3 sum(0);
  for (const Spring& spring : springs_[tool]) {
    const auto &from = displacement_m[spring.held], &to = displacement_m[spring.other];
    const glm::dvec3 d = glm::dvec3(to[0] - from[0], to[1] - from[1], to[2] - from[2]) + spring.rest_m;
    const double length_m = glm::length(d);
    if (length_m == 0) continue;  // no direction
    const glm::dmat3 along = glm::outerProduct(d, d) / (length_m * length_m);
    sum += (along + (glm::dmat3(1) - along) * (1 - spring.length_m / length_m)) * spring.stiffness_N_per_m;
  }
  return sum;
}

glm::dmat3 settled_stiffness(const TissueScene& scene, const Lattice& lattice, std::size_t tool) {
  const RestHessian hessian(scene, lattice, tool);
  glm::dmat3 k;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 e(0);
    e[axis] = 1;
    k[axis] = hessian.settled_force(e);
  }
  return (k + glm::transpose(k)) * 0.5;
}

}  // namespace evenstep::internal
