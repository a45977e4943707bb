#pragma once
/// From metres to newtons: a solver takes the positions of the tools, advances the scene by exactly one step (a constant
/// amount of simulation time, unless the scene asks for a variable one) and returns what the tools feel. It never sees a
/// clock.

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/sim/device_commands.h"
#include "evenstep/sim/scene.h"
#include "evenstep/sim/stability.h"

namespace evenstep {

struct ToolResponse {
  std::array<glm::dvec3, kMaxTools> force_N{};  ///< on the hand, one per tool; unused entries are zero
};

/// Where the tool touches and how stiff the contact is. This is enough to compute the force between two steps, at the rate
/// of the device, from a local model:
///   f(x + d) = force - stiffness d,    and 0 if unilateral and normal . f(x + d) < 0: a surface does not pull.
/// A unilateral contact that is not touched has force 0 and the stiffness that it will have when touched, so the model can
/// predict the touch:
///   f(x + d) = -stiffness (gap normal + d).
/// A wall and a one-sided mode predict it from any distance. For a probe, the stiffness is that of the particles that it
/// would touch if its radius were larger by the gap plus a tenth of the spacing: the nearest particle, and those that it
/// would meet at nearly the same time. Farther away than a hundred spacings its stiffness and normal are 0.
struct ToolContact {
  bool touching = false;    ///< always true for grab and spring
  bool unilateral = false;  ///< it only pushes (probe, wall, one-sided mode)
  /// Block coordinates. Tissue, grab and spring: center_m moved with the tool; probe: mean of the particles touched or about
  /// to be touched, weighted by penetration, or the sphere's centre if there are none. The scenes spring, wall and mode: the
  /// position of the tool.
  glm::dvec3 point_m{0};
  /// Probe: unit vector from point_m to the sphere's centre, out of the surface towards the tool; wall and one-sided mode:
  /// their normal. 0 where no normal is defined: grab and spring, a probe with nothing within reach, a probe whose centre is
  /// at the mean of what it touches.
  glm::dvec3 normal{0};
  /// Probe: distance from the sphere to the nearest mobile particle, < 0 if that is inside; wall and one-sided mode:
  /// distance of the tool from the surface, < 0 behind it; otherwise 0.
  double gap_m = 0;
  glm::dmat3 stiffness_N_per_m{0};  ///< symmetric
  /// With Scene::local_coupling, how the force follows the other tool:
  ///   f(x + d, x' + d') = force - stiffness d - coupling d'.
  /// The coupling of the other tool is the transpose, and [stiffness coupling; coupling' stiffness'] is symmetric. Tissue
  /// with two tools that are held by grabs or springs; 0 for everything else.
  glm::dmat3 coupling_N_per_m{0};
};

/// One entry per site (x-fastest), particle_count entries each.
struct ParticleState {
  std::vector<glm::dvec3> displacement_m, velocity_m_per_s;
};

/// What a solver reports about a finished run.
struct SolverVerdict {
  bool non_finite = false;
  std::int64_t first_bad_step = -1;  ///< first step after which a force (or the energy, if needed) was not finite; -1 = none
  /// The energy E now: that of springs, couplings and probes, and the kinetic energy and weight (0 at rest) of the particles
  /// that move by their forces; 0 unless Scene::needs_energy.
  double energy_J = 0;
  /// Energy that physics does not explain: the maximum over all steps n of E_n - E_0 - W_n, but at least 0, divided by the
  /// maximum over all n of |W_n|, of the part of E_n that is never negative, and of the absolute energy of the weight.
  /// W_n = -sum of (f_i-1 + f_i)/2 (x_i - x_i-1) is the work of the tools, f the force on the hand. A stable run stays near
  /// 0 (in the order of the step size), a diverging one reaches 1, a non-finite one infinity. 0 unless Scene::needs_energy.
  double energy_growth = 0;
  std::int64_t steps_over_limit = 0;  ///< steps whose substeps were longer than StepLimit::step_s
  double step_over_limit_max = 0;     ///< longest substep so far / StepLimit::step_s; above 1 stability is not proven
};

struct SolverInfo {
  std::string name;    ///< "cpu-double", "opencl"
  std::string device;  ///< "pthread-…", empty for cpu
  std::int64_t particles = 0;
  std::int64_t springs = 0;
  int substeps = 1;
  Method method = Method::symplectic_euler;
  int iterations = 0;              ///< for methods that iterate; otherwise 0
  std::optional<StepLimit> limit;  ///< empty for the spring; StepLimit::step_s is infinite for implicit methods
  /// The features that the scene does not need and that the solver therefore leaves out (no kernel code, no array, no
  /// launch): evenstep::left_out.
  std::vector<std::string> left_out;
  /// The capabilities that a solver of the program does not have: "contacts", "state_digest", "energy", "particles",
  /// "reset". Always empty for evenstep's own.
  std::vector<std::string> lacks;
};

enum class SolverFault { unavailable, bad_scene, unstable_step, bad_input, out_of_memory };
/// The word for it in the key `reason` of [expect_stop]: "unstable-step", "bad-input"; "solver" for faults that no scenario
/// can expect.
const char* name_of(SolverFault fault);

/// An error with its message and its remedy, e.g. "no OpenCL platform" and "install pocl-opencl-icd".
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
  /// One step that ends with the tools at `positions_m` (tool_count entries; during the substeps they move linearly from
  /// their positions before). A position that is not finite, or farther from the first one than a float can hold, throws
  /// SolverError and moves nothing. Blocks until the forces are known. Only one thread may call it at a time.
  ///
  /// `step_s` is the length of this step in simulated seconds, instead of the nominal 1 / step_rate (giving exactly that
  /// value makes the same step, bit for bit). It must be between 1e-15 and 1e15, and needs Scene::variable_step; otherwise
  /// SolverError. There are as many substeps as in the nominal step, so each is h = step_s / substeps long:
  ///   v <- (1 - h damping) v + h f(u) / m,    u <- u + h v
  /// The state is the displacement u and the velocity v, not a displacement per step, so this is well defined for any
  /// sequence of h. It is not stable for every sequence (stability.h): steps above the limit are run and counted in the
  /// verdict, and a run that diverges is reported as usual. The spring has no memory and ignores the length.
  virtual ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s = std::nullopt) = 0;
  /// The contact of each tool after the last step (all zero before the first); empty without Scene::local_model. Valid until
  /// the next call of step() or reset().
  virtual std::span<const ToolContact> contacts() const = 0;
  /// Digest of all particle positions and velocities, bit for bit. It does not depend on threads or work-group size and is
  /// the same for cpu float and opencl (all NaNs count as equal). 0 for the spring and without Scene::needs_state_digest.
  virtual std::uint64_t state_digest() = 0;
  /// Back to the rest state at step 0.
  virtual void reset() = 0;
  /// The current displacements from rest and velocities. It copies everything, so it is for studies and tests only.
  virtual ParticleState particle_state() = 0;
  virtual SolverVerdict verdict() = 0;
  virtual const SolverInfo& info() const = 0;
  /// What the device says of the commands of the steps so far; null without SolverOptions::log_commands, and for a solver
  /// that gives no commands to a device.
  virtual CommandLog* command_log() { return nullptr; }
};

struct SolverOptions {
  // Results do not depend on any of these.
  std::string
      opencl_device;  ///< part of the name of a device or of its platform; empty: see choose_opencl (opencl_devices.h)
  int work_group_size = 64;   ///< a divisor of 256
  bool log_commands = false;  ///< OpenCL keeps the times of its commands
  bool prefer_gpu = false;    ///< where opencl_device is empty: a GPU before PoCL
};

/// Throws SolverError for: no platform (naming the package to install), out of memory (naming the size needed and the size
/// there is), unstable substeps without allow_unstable, a scene without particles, mass, spacing or stiffness, a grab that
/// holds nothing, a surface without a normal. Spring, wall and mode are a few operations in double, whatever the kind of
/// solver. OpenCL kernels are built and warmed up before this returns (a first launch can take 250 ms).
std::unique_ptr<Solver> make_solver(SolverKind kind, const Scene& scene, const SolverOptions& options = {});

/// The features that the solver of this scene leaves out, in a fixed order. Nothing is built, except the solver of a foreign
/// scene, because only that solver knows what it lacks. Throws SolverError if it cannot be made.
std::vector<std::string> left_out(const Scene& scene);
/// The scene's solver with one of the features that it leaves out compiled in, with neutral coefficients: its forces are the
/// same, bit for bit, so what the feature costs can be measured. Null for a feature without a neutral form ("tools", "grab",
/// "fixed particles": with one of these it would be another scene) and for scenes other than a tissue. Throws SolverError
/// like make_solver.
std::unique_ptr<Solver> make_solver_with(const std::string& feature, SolverKind kind, const Scene& scene,
                                         const SolverOptions& options = {});
/// Whether the OpenCL solver is a part of this build (EVENSTEP_OPENCL). Without it, whoever asks for it gets a SolverError.
bool built_with_opencl();
/// What a scene can have instead.
inline constexpr std::string_view kInsteadOfOpenCl = "choose solver = \"cpu\", which computes the same bits";
/// Loads OpenCL and opens the device that a solver with these options would use, as make_solver does when it is needed.
/// Throws SolverError.
void open_opencl(const SolverOptions& options = {});
/// What that device says of itself. Throws SolverError.
OpenClDescription describe_opencl(const SolverOptions& options = {});

}  // namespace evenstep
