// What springs between particles cannot change, checked on the particles of the reference solver.
#include "catch.h"
#include "cpu/cell_loops.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::internal;

namespace {

/// A pseudo-random value in [-1, 1), computed with integers only.
double scattered(std::uint32_t n) {
  n = (n ^ 61u) ^ (n >> 16);
  n *= 9u;
  n ^= n >> 4;
  n *= 0x27d4eb2du;
  n ^= n >> 15;
  return n / 2147483648.0 - 1;
}

struct Cells {
  explicit Cells(std::size_t count) : x(count), y(count), z(count) {}
  std::vector<double> x, y, z;
  Vectors<double> from(std::size_t first) { return {&x[first], &y[first], &z[first]}; }
  Vectors<const double> read(std::size_t first) const { return {&x[first], &y[first], &z[first]}; }
};

}  // namespace

TEST_CASE("A free block keeps its momentum and its angular momentum", "[conservation]") {
  TissueScene block;
  block.lattice = {6, 5, 7};
  block.particle_count = 6 * 5 * 7 - 11;
  block.fixed = FixedFaces::none();
  const Lattice lattice(block);
  const double a = block.spacing_m;
  const TissueConstants<double> constants(block, lattice, 5e-4);
  const std::vector<double> active(lattice.active.begin(), lattice.active.end());
  CellArrays<double> cells;
  cells.active = cells.mobile = cells.inverse_mass = &active[lattice.first];
  cells.offset = lattice.offset;
  Cells u(lattice.cells), next(lattice.cells), v(lattice.cells);
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < lattice.cells; ++i) {
    if (active[i] == 0) continue;
    for (std::vector<double>* component : {&u.x, &u.y, &u.z}) (*component)[i] = 0.2 * a * scattered(n++);
    for (std::vector<double>* component : {&v.x, &v.y, &v.z}) (*component)[i] = 0.1 * scattered(n++);
  }
  const auto momenta = [&] {
    glm::dvec3 linear(0), angular(0);
    for (std::size_t i = 0; i < lattice.cells; ++i) {
      if (active[i] == 0) continue;
      const auto site = static_cast<std::ptrdiff_t>(i - lattice.first);
      const std::ptrdiff_t px = block.lattice[0] + 1, py = block.lattice[1] + 1;
      const glm::dvec3 x = glm::dvec3(site % px, site / px % py, site / px / py) * a + glm::dvec3(u.x[i], u.y[i], u.z[i]);
      const glm::dvec3 w(v.x[i], v.y[i], v.z[i]);
      linear += w;
      angular += glm::dvec3(x.y * w.z - x.z * w.y, x.z * w.x - x.x * w.z, x.x * w.y - x.y * w.x);
    }
    return std::pair{linear, angular};
  };
  const auto [linear, angular] = momenta();
  const auto speed_before = v.x;
  for (int step = 0; step < 2000; ++step) {
    ChunkForces<double> forces;
    for (std::ptrdiff_t begin = 0; begin < static_cast<std::ptrdiff_t>(lattice.span); begin += kChunk) {
      chunk_forces<double>({}, begin, u.read(lattice.first), v.read(lattice.first), cells, constants, {}, forces);
      advance_chunk<BodyFeatures{}, double>(begin, forces, cells, constants, u.read(lattice.first), next.from(lattice.first),
                                            v.read(lattice.first), v.from(lattice.first));
    }
    std::swap(u, next);
  }
  const auto [linear_after, angular_after] = momenta();
  REQUIRE(v.x != speed_before);
  // 2000 steps x 200 particles x 18 springs, with roundings of 1e-17 m/s and random signs, make 1e-14. Ten times that is
  // allowed.
  CHECK(test::norm(linear_after - linear) < 1e-13);
  CHECK(test::norm(angular_after - angular) < 1e-13 * 7 * a * 10);
}
