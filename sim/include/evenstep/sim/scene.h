#pragma once
/// The scenes that can be simulated. A run contains only what its scene names.

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr int kMaxTools = 2;
inline constexpr int kMaxSubsteps = 100'000;  ///< per step; needing more is a mistake in the units of mass or stiffness
inline constexpr int kMaxIterations = 10'000;
inline constexpr int kMaxRegions = 60;

// Each kind of scene has these members, for questions that are not the solver's:
//   kAccountsEnergy    its solver keeps an account of energy, so that its growth can be judged
//   kMemoryless        a force depends on the tool alone, so the step size changes none
//   kCostsLittle       a step is a few operations: a second solver beside a run costs nothing to speak of
//   felt_stiffness..   stiffness that a tool at rest feels; none where nobody knows it without running
//   stored_energy_J    energy that it holds while a tool rests at `tool_m`; none where the position alone does not
//                      determine it
//   text               in one line, for people

/// F = -k x on every tool, as the hand feels it. It is memoryless, so a constant velocity must give a force that is linear
/// in time.
struct SpringScene {
  double stiffness_N_per_m = 200;

  static constexpr bool kAccountsEnergy = true;
  static constexpr bool kMemoryless = true;
  static constexpr bool kCostsLittle = true;
  std::optional<double> felt_stiffness_N_per_m() const { return stiffness_N_per_m; }
  std::optional<double> stored_energy_J(const glm::dvec3& tool_m) const;
  std::string text() const;
};

/// A wall that pushes each tool out along its normal n and never pulls: F = n k (p + p^2 / l) at the depth
/// p = surface - n . x, and 0 where p < 0. Memoryless.
struct WallScene {
  double stiffness_N_per_m = 200;
  glm::dvec3 normal{1, 0, 0};  ///< out of the surface, towards the tool; of any length
  double surface_m = 0;        ///< distance of the surface from the origin, along the normal
  double hardening_m = 0;      ///< l; 0: none, F = n k p

  static constexpr bool kAccountsEnergy = false;
  static constexpr bool kMemoryless = true;
  static constexpr bool kCostsLittle = true;
  std::optional<double> felt_stiffness_N_per_m() const { return stiffness_N_per_m; }
  std::optional<double> stored_energy_J(const glm::dvec3& tool_m) const;
  std::string text() const;
};

/// The simplest tissue that rings: a mass on a ground spring 2 k, which the tool presses with a contact spring 2 k; each
/// tool has a mass of its own. So the tool feels 2 k at first, and k when the mass has come to rest. f0 and the damping
/// ratio are those of the mass between its two springs while the tool is held still. If not one-sided, it pushes and pulls
/// along every axis, from the origin. If one-sided, it pushes along the normal only, like the wall, and its surface moves
/// with the mass.
struct ModeScene {
  double stiffness_N_per_m = 200;  ///< k
  double frequency_Hz = 30;        ///< f0
  double damping_ratio = 0.1;
  bool one_sided = false;
  glm::dvec3 normal{1, 0, 0};
  double surface_m = 0;

  static constexpr bool kAccountsEnergy = false;
  static constexpr bool kMemoryless = false;
  static constexpr bool kCostsLittle = true;
  std::optional<double> felt_stiffness_N_per_m() const { return stiffness_N_per_m; }
  std::optional<double> stored_energy_J(const glm::dvec3& tool_m) const;
  std::string text() const;
};

/// How a tool and the tissue touch. Positions are block coordinates, m: the origin is the block's minimum corner.
enum class CouplingKind {
  grab,    ///< kinematic: the particles held move rigidly with the tool, in a straight line over the substeps
  spring,  ///< virtual coupling: a spring and damper from the tool to every particle held
  probe    ///< a sphere that pushes and never pulls: f = stiffness (radius - distance) outwards on each particle inside
};

/// `grab` and `spring` hold the particles within `radius_m` of `center_m` that are not fixed; two tools must not hold the
/// same particle. They follow the tool's displacement from its first sample. A `probe` is a sphere of radius `radius_m`
/// whose centre is at `center_m` when the first sample comes. The force on a state is computed with the position that the
/// tool has at the time of that state, and with the velocity with which it got there. The hand feels this force, and it
/// moves the tissue in the substep that follows.
struct ToolCoupling {
  glm::dvec3 center_m{0};
  double radius_m = 0;
  CouplingKind kind = CouplingKind::grab;
  double stiffness_N_per_m = 0;  ///< spring: of the whole coupling, shared evenly; probe: of each particle it touches
  double damping_N_s_per_m = 0;  ///< spring: of the whole coupling, shared evenly; otherwise 0
};

/// Another material for the particles in the box [min_m, max_m] (block coordinates, rest state). If two regions contain the
/// same particle, the later region applies. A spring between two materials has the mean of their stiffnesses, as the
/// elements of two materials that share an edge would.
struct MaterialRegion {
  glm::dvec3 min_m{0}, max_m{0};
  double stiffness_N_per_m = 0;
  double particle_mass_kg = 0;
};

enum class Method {
  symplectic_euler,      ///< v <- (1 - h d) v + h a(u, v), u <- u + h v
  velocity_verlet,       ///< v <- v + h a/2, u <- u + h v, a <- a(u, v), v <- v + h a/2: same path, but v at whole steps
  rk4,                   ///< the classical Runge-Kutta method
  implicit_euler,        ///< linearised once per substep, conjugate gradients with a fixed number of iterations
  implicit_midpoint,     ///< symplectic and symmetric
  vertex_block_descent,  ///< implicit Euler by a fixed number of sweeps over particles in four colours
};

/// The faces of the lattice whose particles do not move.
struct FixedFaces {
  bool x_min = false, x_max = false, y_min = false, y_max = false, z_min = true, z_max = false;
  static constexpr FixedFaces none() { return {false, false, false, false, false, false}; }
  bool any() const { return x_min || x_max || y_min || y_max || z_min || z_max; }
};

/// The paper's tissue: particles on a cubic lattice, each joined by springs to its 18 neighbours (6 faces, 12 edges), rest
/// lengths `spacing` and sqrt(2) `spacing`. The lattice is cut to exactly `particle_count` by leaving out its last sites in
/// x-fastest order (which are in the top layer, farthest from the fixed one). A lattice of n x 1 x 1 is a chain.
struct TissueScene {
  std::array<int, 3> lattice{27, 27, 28};
  std::int64_t particle_count = 20'270;  ///< <= product of lattice
  double spacing_m = 5e-3;
  double particle_mass_kg = 1.25e-4;
  double stiffness_N_per_m = 50;
  /// Drag: a force of -damping_per_s * particle_mass_kg * v on every particle, also on one of another mass in a region.
  double damping_per_s = 0;
  double axial_damping_N_s_per_m = 0;  ///< along every spring: c ((v_j - v_i) . n) n
  glm::dvec3 gravity_m_per_s2{0};
  std::vector<MaterialRegion> regions;
  FixedFaces fixed;
  Method method = Method::symplectic_euler;
  /// Most iterations of conjugate gradients, or sweeps, per substep; 0: 20 (implicit Euler), 40 (implicit midpoint) or 10
  /// (vertex block descent).
  int iterations = 0;
  int substeps = 0;  ///< per step; 0 = "auto": the fewest that meet the configuration-free bound, 1 without a bound
  std::vector<ToolCoupling> tools;  ///< one per tool
  /// State at step 0, by site (x-fastest, particle_count entries); empty: at rest.
  std::vector<glm::dvec3> initial_displacement_m, initial_velocity_m_per_s;

  static constexpr bool kAccountsEnergy = true;
  static constexpr bool kMemoryless = false;
  static constexpr bool kCostsLittle = false;
  std::optional<double> felt_stiffness_N_per_m() const { return std::nullopt; }
  std::optional<double> stored_energy_J(const glm::dvec3& tool_m) const;
  std::string text() const;
};

class ForeignSolver;
struct SolverRequest;

/// A solver that is not evenstep's own (foreign_solver.h). `options` is a JSON object that only the solver reads.
struct ForeignScene {
  std::string name;
  std::string options = "{}";
  std::function<std::unique_ptr<ForeignSolver>(const SolverRequest&)>
      make;                                                     ///< a SolverFactory; may be called by any thread
  std::string origin = "a solver that the program registered";  ///< for reports
  std::uint64_t seed = 1;                                       ///< SolverRequest::seed

  static constexpr bool kAccountsEnergy = true;  // if it has the capability: SolverInfo::lacks
  static constexpr bool kMemoryless = false;
  static constexpr bool kCostsLittle = false;
  std::optional<double> felt_stiffness_N_per_m() const { return std::nullopt; }
  std::optional<double> stored_energy_J(const glm::dvec3& tool_m) const;
  std::string text() const;
};

/// How the tool's local linear model f(x + d) = force - stiffness d is computed (Solver::contacts).
enum class LocalModel {
  none,
  instantaneous,  ///< the other particles stay where they are
  /// The other particles come to rest again. For a grab or a spring the stiffness is computed once, at rest, when the scene
  /// loads, by solving three linear systems. A probe touches different particles in every step. For the 16 nearest to its
  /// centre at the start the nodal compliance is computed, three systems each, and every one of them that is touched counts
  /// as in series with it. The result is never below the true settled stiffness: it neglects that particles yield under the
  /// load of their neighbours, and particles other than these 16 count as in `instantaneous`.
  settled
};

struct Scene {
  std::variant<SpringScene, WallScene, ModeScene, TissueScene, ForeignScene> body;
  Rate step_rate{450, 1};  ///< 1 / step_size: simulated seconds per step, constant (the paper's premise)
  int tool_count = 1;
  bool needs_state_digest = true;             ///< Solver::state_digest will be called
  bool needs_energy = false;                  ///< an expectation asks for the energy
  bool allow_unstable = false;                ///< [scene] allow_unstable
  bool variable_step = false;                 ///< Solver::step will be given lengths
  LocalModel local_model = LocalModel::none;  ///< other than `none`: Solver::contacts will be read
  bool local_coupling = false;                ///< and in these ToolContact::coupling_N_per_m
};

// Of a scene's body:
bool accounts_energy(const Scene& scene);
bool costs_little(const Scene& scene);
bool is_memoryless(const Scene& scene);
/// The scene has a stiffness_N_per_m that a search may change.
bool has_stiffness(const Scene& scene);
std::optional<double> felt_stiffness_N_per_m(const Scene& scene);
std::optional<double> stored_energy_J(const Scene& scene, const glm::dvec3& tool_m);
std::string describe(const Scene& scene);

enum class SolverKind { cpu_float, cpu_double, opencl };

inline constexpr std::array kAllMethods{Method::symplectic_euler, Method::velocity_verlet,   Method::rk4,
                                        Method::implicit_euler,   Method::implicit_midpoint, Method::vertex_block_descent};
inline constexpr std::array kAllSolvers{SolverKind::opencl, SolverKind::cpu_float, SolverKind::cpu_double};
/// The names used in scenario files: "symplectic-euler", "cpu-double".
const char* name_of(Method method);
const char* name_of(SolverKind solver);
/// Whether the method solves its equations by iterations, whose number a scene may set.
bool iterates(Method method);

}  // namespace evenstep
