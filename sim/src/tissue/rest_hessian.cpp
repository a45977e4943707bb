#include "src/tissue/rest_hessian.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <utility>

namespace evenstep::internal {
namespace {

constexpr double kSolved = 1e-9, kFound = 1e-6;
constexpr int kMostRounds = 5'000;

glm::dvec3 direction(std::size_t s) {
  return glm::normalize(glm::dvec3(kNeighbourhood[s].dx, kNeighbourhood[s].dy, kNeighbourhood[s].dz));
}

}  // namespace

RestHessian::RestHessian(const TissueScene& scene, const Lattice& lattice)
    : lattice_(lattice), materials_(scene, lattice), coupling_N_per_m_(lattice.cells, 0) {
  for (std::size_t cell = 0; cell < lattice.cells; ++cell)
    if (lattice.mobile[cell]) mobile_.push_back(cell);
  for (std::size_t tool = 0; tool < scene.tools.size(); ++tool) {
    if (scene.tools[tool].kind != CouplingKind::spring) continue;
    const double share_N_per_m = scene.tools[tool].stiffness_N_per_m / static_cast<double>(lattice.held[tool].size());
    for (const std::uint32_t cell : lattice.held[tool]) coupling_N_per_m_[cell] = share_N_per_m;
  }
}

glm::dmat3 RestHessian::spring(std::size_t cell, std::size_t s) const {
  const glm::dvec3 n = direction(s);
  return glm::outerProduct(n, n) *
         spring_stiffness(materials_.stiffness_N_per_m(cell), materials_.stiffness_N_per_m(neighbour(cell, s)));
}

void RestHessian::apply(const Cells& x, Cells& y) const {
  for (const std::size_t cell : mobile_) {
    glm::dvec3 sum = x[cell] * coupling_N_per_m_[cell];
    for (std::size_t s = 0; s < kNeighbours; ++s) {
      const std::size_t to = neighbour(cell, s);
      if (!lattice_.active[to]) continue;
      const Neighbour& d = kNeighbourhood[s];
      const glm::dvec3 n(d.dx, d.dy, d.dz);
      const double k = spring_stiffness(materials_.stiffness_N_per_m(cell), materials_.stiffness_N_per_m(to));
      sum += n * (k * glm::dot(n, x[cell] - x[to]) * (s < 6 ? 1.0 : 0.5));  // 1 / n . n
    }
    y[cell] = sum;
  }
}

/// 1 where nothing resists, since nothing pushes there either.
RestHessian::Cells RestHessian::inverse_diagonal() const {
  Cells inverse(lattice_.cells, glm::dvec3(0));
  for (const std::size_t cell : mobile_) {
    glm::dvec3 diagonal(coupling_N_per_m_[cell]);
    for (std::size_t s = 0; s < kNeighbours; ++s) {
      if (!lattice_.active[neighbour(cell, s)]) continue;
      const glm::dmat3 k = spring(cell, s);
      diagonal += glm::dvec3(k[0][0], k[1][1], k[2][2]);
    }
    for (int axis = 0; axis < 3; ++axis) inverse[cell][axis] = diagonal[axis] > 0 ? 1 / diagonal[axis] : 1;
  }
  return inverse;
}

double RestHessian::dot(const Cells& a, const Cells& b) const {
  double sum = 0;
  for (const std::size_t cell : mobile_) sum += glm::dot(a[cell], b[cell]);
  return sum;
}

RestHessian::Solution RestHessian::solve(const Cells& load) const {
  const Cells inverse = inverse_diagonal();
  Cells x(lattice_.cells, glm::dvec3(0)), y = x, z = x, r = load;
  for (const std::size_t cell : mobile_) z[cell] = inverse[cell] * r[cell];
  Cells p = z;
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
  // The residual is computed anew, because the iterations' own residual is mere rounding if there is no solution.
  apply(x, y);
  for (const std::size_t cell : mobile_) r[cell] = load[cell] - y[cell];
  return {std::move(x), dot(r, r) <= kFound * kFound * dot(load, load)};
}

}  // namespace evenstep::internal
