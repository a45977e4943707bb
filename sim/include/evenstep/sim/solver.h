#pragma once
/// Metres to newtons: a solver takes the tools' positions, advances the scene by exactly one step (a constant amount of
/// simulation time, unless the scene asks for a variable one) and says what the tools feel. It never sees a clock.

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "evenstep/sim/scene.h"
#include "evenstep/sim/stability.h"

namespace evenstep {

struct ToolResponse {
  std::array<glm::dvec3, kMaxTools> force_N{};  ///< on the hand, one per tool; unused entries are zero
};

/// Where the tool touches and how stiff that is: enough for a local model at the device's rate, between two steps:
///   f(x + d) = force - stiffness d,    and 0 where unilateral and normal . f(x + d) < 0: a surface does not pull.
/// What is unilateral and not touched has the force 0 and the stiffness of the touch to come, which foresees it:
///   f(x + d) = -stiffness (gap normal + d).
/// A wall and a one-sided mode do so from anywhere. Of a probe the touch to come is that of the particles that it would touch if
/// its radius were larger by the gap and a tenth of the spacing: the nearest one, and those that it meets nearly with it. Farther
/// than a hundred spacings away its stiffness and normal are 0.
struct ToolContact {
  bool touching = false;    ///< grab and spring: always
  bool unilateral = false;  ///< pushes only (probe, wall, one-sided mode)
  /// Block coordinates. Grab, spring: center_m moved with the tool; probe: mean of the particles touched or to be touched,
  /// weighted by penetration, or the sphere's centre where there are none. Of a spring, wall or mode: the tool's position.
  glm::dvec3 point_m{0};
  /// Probe: unit vector from point_m to the sphere's centre, out of the surface towards the tool; wall, one-sided mode: theirs.
  /// 0 where there is no such side: grab and spring, nothing within reach, the centre amid what it touches.
  glm::dvec3 normal{0};
  /// Probe: distance of the nearest particle that moves to the sphere, < 0 inside it; wall, one-sided mode: of the tool from
  /// the surface, < 0 behind it; otherwise 0.
  double gap_m = 0;
  glm::dmat3 stiffness_N_per_m{0};  ///< symmetric
};

/// By site (x-fastest), particle_count entries each.
struct ParticleState {
  std::vector<glm::dvec3> displacement_m, velocity_m_per_s;
};

/// What a scene does not need and so does not exist in its solver: no kernel code, no array, no launch.
struct LeftOut {
  std::string feature;
  /// What it would add to the CPU time of a substep, as measured at 20,270 particles (docs/performance.md); none where the
  /// scene is a spring.
  std::optional<int> cost_percent;
};

/// What a solver says of a finished run.
struct SolverVerdict {
  bool non_finite = false;
  std::int64_t first_bad_step = -1;  ///< first step after which a force (or the energy, if needed) was not finite; -1 = none
  /// E now: springs, couplings, probes, kinetic energy and weight (0 at rest) of the particles that move by their forces; 0
  /// unless Scene::needs_energy.
  double energy_J = 0;
  /// What physics does not explain: max over steps n of (E_n - E_0 - W_n), 0 at least, over max over n of |W_n|, the part of
  /// E_n that is never negative, and |the weight's|.
  /// W_n = -sum of (f_i-1 + f_i)/2 (x_i - x_i-1) is the tools' work, f the force on the hand. Stable runs stay near 0 (the
  /// order of the step size), a diverging one reaches 1, a non-finite one infinity. 0 unless Scene::needs_energy.
  double energy_growth = 0;
  std::int64_t steps_over_limit = 0;  ///< steps whose substeps were longer than StepLimit::step_s
  double step_over_limit_max = 0;     ///< longest substep so far over StepLimit::step_s; above 1 nothing is proven
};

struct SolverInfo {
  std::string name;    ///< "cpu-double", "opencl"
  std::string device;  ///< "pthread-…", empty for cpu
  std::int64_t particles = 0;
  std::int64_t springs = 0;
  int substeps = 1;
  Method method = Method::symplectic_euler;
  int iterations = 0;                 ///< of a method that iterates; otherwise 0
  std::optional<StepLimit> limit;     ///< none for the spring; StepLimit::step_s is infinite for implicit methods
  std::vector<LeftOut> left_out;
};

enum class SolverFault { unavailable, bad_scene, unstable_step, bad_input, out_of_memory };
/// The word that [expect_stop] reason has for it: "unstable-step", "bad-input"; "solver" for all that no scenario expects.
const char* name_of(SolverFault fault);

/// Message and remedy, e.g. "no OpenCL platform" / "install pocl-opencl-icd".
class SolverError : public std::runtime_error {
 public:
  SolverError(SolverFault fault, const std::string& what, std::string remedy)
      : std::runtime_error(what), fault_(fault), remedy_(std::move(remedy)) {}
  SolverFault fault() const { return fault_; }
  const std::string& remedy() const { return remedy_; }

 private:
  SolverFault fault_;
  std::string remedy_;
};

class Solver {
 public:
  virtual ~Solver() = default;
  /// One step with the tools at `positions_m` (tool_count entries; substeps move linearly from the positions before). A
  /// position that is not finite, or more than float holds away from the first, throws SolverError and moves nothing. Blocks
  /// until the forces are known. One thread at a time.
  ///
  /// `step_s`: the length of this step in simulated seconds, instead of the nominal 1 / step_rate (which given here is the
  /// same step, bit for bit). 1e-15 to 1e15 and only with Scene::variable_step, otherwise SolverError. There are as many
  /// substeps as in the nominal step, so each is h = step_s / substeps long:
  ///   v <- (1 - h damping) v + h f(u) / m,    u <- u + h v
  /// The state is the displacement u and the velocity v, not a displacement per step, so this is well defined for any
  /// sequence of h. It is not stable for any (stability.h): steps above the limit run, the verdict counts them, and a run
  /// that diverges is reported as ever. The spring has no memory and so no use for a length.
  virtual ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s = std::nullopt) = 0;
  /// One per tool, of the last step (all zero before the first); empty without Scene::local_model. Valid until the next call
  /// of step() or reset().
  virtual std::span<const ToolContact> contacts() const = 0;
  /// Digest of all particle positions and velocities, bit for bit, independent of threads and work-group size, equal for
  /// cpu float and opencl (all NaNs count as one). 0 for the spring and without Scene::needs_state_digest.
  virtual std::uint64_t state_digest() = 0;
  /// Back to the rest state at step 0.
  virtual void reset() = 0;
  /// Displacements from rest and velocities now. Copies everything: for studies and tests, not for the loop.
  virtual ParticleState particle_state() = 0;
  virtual SolverVerdict verdict() = 0;
  virtual const SolverInfo& info() const = 0;
};

struct SolverOptions {
  std::string opencl_platform;  ///< part of the platform's name; empty = PoCL if there, otherwise the first
  std::string opencl_device;    ///< part of the device's name; empty = the first
  int work_group_size = 64;     ///< a divisor of 256; results do not depend on it
};

/// Throws SolverError: no platform (with the package to install), out of memory (size asked for and there), unstable
/// substeps without allow_unstable, a scene without particles, mass, spacing or stiffness, a grab that holds nothing, a surface
/// without a normal. Spring, wall and mode are a few operations in double for every kind. OpenCL kernels are built and warmed up before it returns (a first
/// launch can take 250 ms).
std::unique_ptr<Solver> make_solver(SolverKind kind, const Scene& scene, const SolverOptions& options = {});

}  // namespace evenstep
