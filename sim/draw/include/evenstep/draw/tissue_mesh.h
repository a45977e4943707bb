#pragma once
/// What is drawn of a tissue: its surface as it is now, the tools, and an arrow for the force that each hand feels.
///
/// The surface is that of the lattice's cubes of eight particles: a side of a cube that no other cube shares is a face of
/// four corners. A particle that belongs to no whole cube (of a chain, a sheet, a row that was cut off) is a small
/// octahedron. Particles that a grab or a spring holds have the colour of their tool, fixed ones are grey. A probe is a
/// sphere of its size; a grab or a spring one of 0.6 times its radius, so that what it holds can be seen.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "evenstep/sim/scene.h"
#include "evenstep/sim/solver.h"

namespace evenstep {

/// Corners of a face, counter-clockwise as seen from outside; a triangle repeats its last corner.
using Face = std::array<std::uint32_t, 4>;

struct Mesh {
  std::vector<glm::vec3> positions_m;               ///< block coordinates, one per vertex
  std::vector<glm::vec3> colours;                   ///< red, green and blue from 0 to 1, one per vertex; they never change
  std::vector<Face> faces;                          ///< these never change either
  std::size_t lined_faces = 0;                      ///< how many faces, from the first on, have edges drawn as lines
  std::vector<std::array<glm::dvec3, 2>> arrows_m;  ///< tail and tip of the arrow of each tool's force
};

struct DrawnTool {
  glm::dvec3 moved_m{0};  ///< from where it was at the first sample
  glm::dvec3 force_N{0};  ///< on the hand
};

inline constexpr std::int64_t kMostDrawnParticles = 4'000'000;

class TissueMesh {
 public:
  /// The tissue at rest; it has at most kMostDrawnParticles. An arrow is `arrow_m_per_N` long for each newton, and at most
  /// as long as the block.
  TissueMesh(const TissueScene& tissue, double arrow_m_per_N);
  /// Moves the vertices to this state and these tools (as many as the tissue has). A particle whose position is not finite,
  /// or farther than 1000 blocks away, stays where it rests.
  void move(const ParticleState& state, std::span<const DrawnTool> tools);
  const Mesh& mesh() const { return mesh_; }

 private:
  /// A vertex that moves with a particle.
  struct Vertex {
    std::int64_t site = 0;
    glm::dvec3 offset_m{0};  ///< from where the particle is
  };
  glm::dvec3 rest_m(std::int64_t site) const;
  glm::vec3 colour_of(std::int64_t site) const;
  void add_surface();
  void add_loose_particles();
  void add_tool(std::size_t tool);
  void add_octahedron(std::int64_t site);
  void move_tool(std::size_t tool, const DrawnTool& now);

  TissueScene tissue_;  // without the state at step 0
  double size_m_, arrow_m_per_N_;
  std::vector<Vertex> vertices_;                  ///< the first ones of the mesh
  std::vector<glm::dvec3> sphere_;                ///< a sphere's vertices, at a distance of 1
  std::array<std::size_t, kMaxTools> tool_at_{};  ///< where a tool's vertices begin: its sphere, then its arrow
  Mesh mesh_;
};

/// The longest side of the block, at least one spacing, m.
double block_size_m(const TissueScene& tissue);

}  // namespace evenstep
