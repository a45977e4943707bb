#include "evenstep/draw/tissue_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

namespace evenstep {
namespace {

constexpr glm::vec3 kTissue{0.86F, 0.55F, 0.50F}, kFixed{0.50F, 0.48F, 0.50F}, kArrow{0.10F, 0.10F, 0.13F};
constexpr std::array<glm::vec3, kMaxTools> kTools{glm::vec3{0.0F, 0.45F, 0.70F}, glm::vec3{0.0F, 0.62F, 0.45F}};

using Corner = std::array<int, 3>;
struct Side {
  std::array<int, 3> to;  ///< the cube on the other side
  std::array<Corner, 4> corners;
};
/// The sides of a cube, seen from outside.
constexpr std::array<Side, 6> kSides{{
    {{-1, 0, 0}, {{{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}}}},
    {{1, 0, 0}, {{{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}}}},
    {{0, -1, 0}, {{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}}}},
    {{0, 1, 0}, {{{0, 1, 0}, {0, 1, 1}, {1, 1, 1}, {1, 1, 0}}}},
    {{0, 0, -1}, {{{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}}},
    {{0, 0, 1}, {{{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}}},
}};

/// Vertices 0 and 1 lie along x, 2 and 3 along y, 4 and 5 along z; the positive one comes first.
constexpr std::array<std::array<std::uint32_t, 3>, 8> kOctahedron{
    {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
glm::dvec3 octahedron_vertex(int n) {
  glm::dvec3 vertex(0);
  vertex[n / 2] = n % 2 == 0 ? 1 : -1;
  return vertex;
}

constexpr int kSphereDivisions = 3;  // 512 triangles

struct Sphere {
  std::vector<glm::dvec3> vertices;
  std::vector<Face> faces;
};
/// An octahedron whose triangles are divided into four again and again. No angle is needed, so the bits are the same
/// everywhere.
Sphere unit_sphere() {
  Sphere sphere;
  for (int n = 0; n < 6; ++n) sphere.vertices.push_back(octahedron_vertex(n));
  for (const auto& [a, b, c] : kOctahedron) sphere.faces.push_back({a, b, c, c});
  for (int division = 0; division < kSphereDivisions; ++division) {
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, added] =
          middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::uint32_t>(sphere.vertices.size()));
      if (added) sphere.vertices.push_back(glm::normalize(sphere.vertices[a] + sphere.vertices[b]));
      return place->second;
    };
    std::vector<Face> finer;
    for (const auto& [a, b, c, same] : sphere.faces) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const auto& [u, v, w] : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back({u, v, w, w});
    }
    sphere.faces = std::move(finer);
  }
  return sphere;
}

/// An arrow along z, of length 1: a shaft (vertices 0 to 7), the head's base (8 to 11) and its tip (12). x and y are shares
/// of the arrow's half width.
constexpr std::array<std::array<double, 3>, 13> kArrowVertices{{{-0.35, -0.35, 0},
                                                                {0.35, -0.35, 0},
                                                                {0.35, 0.35, 0},
                                                                {-0.35, 0.35, 0},
                                                                {-0.35, -0.35, 0.75},
                                                                {0.35, -0.35, 0.75},
                                                                {0.35, 0.35, 0.75},
                                                                {-0.35, 0.35, 0.75},
                                                                {-1, -1, 0.75},
                                                                {1, -1, 0.75},
                                                                {1, 1, 0.75},
                                                                {-1, 1, 0.75},
                                                                {0, 0, 1}}};
constexpr std::array<Face, 10> kArrowFaces{{{0, 3, 2, 1},
                                            {0, 1, 5, 4},
                                            {1, 2, 6, 5},
                                            {2, 3, 7, 6},
                                            {3, 0, 4, 7},
                                            {8, 11, 10, 9},
                                            {8, 9, 12, 12},
                                            {9, 10, 12, 12},
                                            {10, 11, 12, 12},
                                            {11, 8, 12, 12}}};

/// Two unit vectors, perpendicular to `along` and to each other.
std::array<glm::dvec3, 2> across(const glm::dvec3& along) {
  const glm::dvec3 other = std::abs(along.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(other, along));
  return {x, glm::cross(along, x)};
}

bool is_held(const TissueScene& tissue, const ToolCoupling& tool, const glm::dvec3& rest_m) {
  return tool.kind != CouplingKind::probe && glm::length(rest_m - tool.center_m) <= tool.radius_m * (1 + 1e-9) &&
         tissue.spacing_m > 0;
}

double sphere_radius_m(const ToolCoupling& tool) { return (tool.kind == CouplingKind::probe ? 1 : 0.6) * tool.radius_m; }

bool is_within(const glm::dvec3& moved_m, double most_m) {
  return std::abs(moved_m.x) <= most_m && std::abs(moved_m.y) <= most_m && std::abs(moved_m.z) <= most_m;
}

}  // namespace

double block_size_m(const TissueScene& tissue) {
  const int sites = std::max({tissue.lattice[0], tissue.lattice[1], tissue.lattice[2], 2});
  return tissue.spacing_m * (sites - 1);
}

TissueMesh::TissueMesh(const TissueScene& tissue, double arrow_m_per_N)
    : tissue_(tissue), size_m_(block_size_m(tissue)), arrow_m_per_N_(arrow_m_per_N) {
  tissue_.initial_displacement_m.clear();
  tissue_.initial_velocity_m_per_s.clear();
  add_surface();
  add_loose_particles();
  mesh_.lined_faces = mesh_.faces.size();
  for (const Vertex& vertex : vertices_) mesh_.colours.push_back(colour_of(vertex.site));
  mesh_.positions_m.resize(vertices_.size());
  for (std::size_t tool = 0; tool < tissue_.tools.size(); ++tool) add_tool(tool);
  const std::vector<DrawnTool> still(tissue_.tools.size());
  const ParticleState rest{std::vector<glm::dvec3>(static_cast<std::size_t>(tissue_.particle_count)), {}};
  move(rest, still);
}

glm::dvec3 TissueMesh::rest_m(std::int64_t site) const {
  const auto [nx, ny, nz] = tissue_.lattice;
  return tissue_.spacing_m * glm::dvec3(site % nx, site / nx % ny, site / nx / ny);
}

glm::vec3 TissueMesh::colour_of(std::int64_t site) const {
  const auto [nx, ny, nz] = tissue_.lattice;
  const std::int64_t x = site % nx, y = site / nx % ny, z = site / nx / ny;
  const FixedFaces& fixed = tissue_.fixed;
  if ((fixed.x_min && x == 0) || (fixed.x_max && x == nx - 1) || (fixed.y_min && y == 0) || (fixed.y_max && y == ny - 1) ||
      (fixed.z_min && z == 0) || (fixed.z_max && z == nz - 1))
    return kFixed;
  for (std::size_t tool = 0; tool < tissue_.tools.size(); ++tool)
    if (is_held(tissue_, tissue_.tools[tool], rest_m(site))) return 0.5F * (kTools[tool] + glm::vec3(0.75F));
  return kTissue;
}

void TissueMesh::add_surface() {
  const int nx = tissue_.lattice[0], ny = tissue_.lattice[1], nz = tissue_.lattice[2];
  const auto site = [nx, ny](int x, int y, int z) {
    return x + static_cast<std::int64_t>(nx) * (y + static_cast<std::int64_t>(ny) * z);
  };
  const auto is_cube = [&](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < nx - 1 && y < ny - 1 && z < nz - 1 &&
           site(x + 1, y + 1, z + 1) < tissue_.particle_count;
  };
  std::map<std::int64_t, std::uint32_t> vertex_of;
  const auto vertex = [&](std::int64_t at) {
    const auto [place, added] = vertex_of.try_emplace(at, static_cast<std::uint32_t>(vertices_.size()));
    if (added) vertices_.push_back({at, glm::dvec3(0)});
    return place->second;
  };
  for (int z = 0; z < nz - 1; ++z) {
    for (int y = 0; y < ny - 1; ++y) {
      for (int x = 0; x < nx - 1; ++x) {
        if (!is_cube(x, y, z)) continue;
        for (const Side& side : kSides) {
          if (is_cube(x + side.to[0], y + side.to[1], z + side.to[2])) continue;
          Face face{};
          for (std::size_t n = 0; n < 4; ++n)
            face[n] = vertex(site(x + side.corners[n][0], y + side.corners[n][1], z + side.corners[n][2]));
          mesh_.faces.push_back(face);
        }
      }
    }
  }
}

void TissueMesh::add_loose_particles() {
  const auto [nx, ny, nz] = tissue_.lattice;
  std::vector<bool> in_cube(static_cast<std::size_t>(tissue_.particle_count));
  const std::int64_t row = nx, plane = static_cast<std::int64_t>(nx) * ny;
  for (std::int64_t site = 0; site + plane + row + 1 < tissue_.particle_count; ++site) {
    if (site % nx == nx - 1 || site / nx % ny == ny - 1) continue;
    for (const std::int64_t corner : {std::int64_t{0}, std::int64_t{1}, row, row + 1})
      in_cube[static_cast<std::size_t>(site + corner)] = in_cube[static_cast<std::size_t>(site + corner + plane)] = true;
  }
  for (std::int64_t site = 0; site < tissue_.particle_count; ++site)
    if (!in_cube[static_cast<std::size_t>(site)]) add_octahedron(site);
}

void TissueMesh::add_octahedron(std::int64_t site) {
  const auto first = static_cast<std::uint32_t>(vertices_.size());
  for (int n = 0; n < 6; ++n) vertices_.push_back({site, 0.25 * tissue_.spacing_m * octahedron_vertex(n)});
  for (const auto& [a, b, c] : kOctahedron) mesh_.faces.push_back({first + a, first + b, first + c, first + c});
}

void TissueMesh::add_tool(std::size_t tool) {
  const Sphere sphere = unit_sphere();
  sphere_ = sphere.vertices;
  tool_at_[tool] = mesh_.positions_m.size();
  mesh_.arrows_m.emplace_back();
  const auto add = [&](std::span<const Face> faces, std::size_t vertices, const glm::vec3& colour) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions_m.size());
    for (const Face& face : faces)
      mesh_.faces.push_back({first + face[0], first + face[1], first + face[2], first + face[3]});
    mesh_.positions_m.resize(first + vertices);
    mesh_.colours.resize(first + vertices, colour);
  };
  add(sphere.faces, sphere.vertices.size(), kTools[tool]);
  add(kArrowFaces, kArrowVertices.size(), kArrow);
}

void TissueMesh::move(const ParticleState& state, std::span<const DrawnTool> tools) {
  const double most_m = 1000 * size_m_;
  for (std::size_t n = 0; n < vertices_.size(); ++n) {
    const Vertex& vertex = vertices_[n];
    const glm::dvec3& moved_m = state.displacement_m[static_cast<std::size_t>(vertex.site)];
    mesh_.positions_m[n] = rest_m(vertex.site) + vertex.offset_m + (is_within(moved_m, most_m) ? moved_m : glm::dvec3(0));
  }
  for (std::size_t tool = 0; tool < tissue_.tools.size(); ++tool) move_tool(tool, tools[tool]);
}

void TissueMesh::move_tool(std::size_t tool, const DrawnTool& now) {
  const ToolCoupling& coupling = tissue_.tools[tool];
  const glm::dvec3 center_m = coupling.center_m + (is_within(now.moved_m, 1000 * size_m_) ? now.moved_m : glm::dvec3(0));
  auto vertex = mesh_.positions_m.begin() + static_cast<std::ptrdiff_t>(tool_at_[tool]);
  const double radius_m = sphere_radius_m(coupling);
  for (const glm::dvec3& direction : sphere_) *vertex++ = center_m + radius_m * direction;
  const double force_N = glm::length(now.force_N);
  const bool has_force = std::isfinite(force_N) && force_N > 0;
  const glm::dvec3 along = has_force ? now.force_N / force_N : glm::dvec3(0, 0, 1);
  const double length_m = has_force ? std::min(force_N * arrow_m_per_N_, size_m_) : 0;
  const double half_width_m = std::min(0.03 * size_m_, 0.2 * length_m);
  mesh_.arrows_m[tool] = {center_m, center_m + length_m * along};
  const auto [x, y] = across(along);
  for (const auto& [right, up, share] : kArrowVertices)
    *vertex++ = center_m + half_width_m * (right * x + up * y) + length_m * share * along;
}

}  // namespace evenstep
