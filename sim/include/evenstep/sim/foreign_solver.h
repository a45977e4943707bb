#pragma once
/// A solver of your own, as evenstep calls it: only step() must be there. Contacts, digest, energy, particles and reset are
/// capabilities: those that a solver lacks are left out of the run, which reports it, and whatever needs them is refused
/// with the reason.
///
///   class MySpring final : public evenstep::ForeignSolver {
///     evenstep::ToolResponse step(std::span<const glm::dvec3> positions_m, double) override {
///       return {{positions_m[0] * -200.0}};
///     }
///   };
///   registry.add_solver("my-spring", [](const evenstep::SolverRequest&) { return std::make_unique<MySpring>(); });
///
/// Several strategies run at the same time, each with a solver of its own, so two solvers must not share anything that
/// changes; one solver is only ever called by one thread at a time. All that a solver may know of time comes with each step,
/// and it must not ask a clock: the same positions must give the same forces, bit for bit, or `--repeat` names it.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "evenstep/sim/solver.h"

namespace evenstep {

/// What a solver is made for.
struct SolverRequest {
  std::string name;            ///< the name it is registered under
  std::string options = "{}";  ///< [scene] options as a JSON object, keys in alphabetical order; unread by evenstep
  double step_s = 0;           ///< nominal simulated seconds per step; > 0
  int tool_count = 1;          ///< 1 to kMaxTools; 0 in a [case]
  bool variable_step = false;  ///< steps will differ from step_s
  LocalModel local_model = LocalModel::none;  ///< other than `none`: contacts() will be read, with this stiffness
  std::uint64_t seed = 1;                     ///< [run] seed: all that may be drawn at random follows from it
};

/// What a solver has besides step(). For each member that is set, the function of that name must be there.
struct SolverCapabilities {
  bool contacts = false;
  bool state_digest = false;
  bool energy = false;
  bool particles = false;
  bool reset = false;
};

/// Any function may throw std::exception: the run then stops with its message and the solver's name. SolverError adds a
/// remedy, and with SolverFault::bad_input or unstable_step a reason that [expect_stop] can name.
class ForeignSolver {
 public:
  virtual ~ForeignSolver() = default;
  /// Advances the scene by `step_s` simulated seconds (> 0), at the end of which the tools are at `positions_m` (tool_count
  /// entries, m, always finite), and returns the forces on the hand, N; entries beyond tool_count are not read. A force that
  /// is not finite ends the run ("diverged").
  virtual ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) = 0;

  /// Must not change once the solver is made.
  virtual SolverCapabilities capabilities() const { return {}; }
  /// One per tool: where it touches, and how stiff, after the last step (solver.h). For renderers that correct a force for
  /// where the hand is by now.
  virtual std::span<const ToolContact> contacts() const { return {}; }
  /// A digest of the whole state, bit for bit, after the last step: with it, a trace hash sees a difference before a force
  /// does. Without it evenstep takes the digest of particles(); without particles() only forces are compared.
  virtual std::uint64_t state_digest() { return 0; }
  /// The energy of everything that moves or is stored, J, after the last step. evenstep adds up the work of the tools from
  /// the end of the first step on, and reports energy that nothing explains (SolverVerdict::energy_growth).
  virtual double energy_J() { return 0; }
  /// Displacements from rest and velocities, in a fixed order.
  virtual ParticleState particles() { return {}; }
  /// Back to the state before the first step. Without it another solver is made.
  virtual void reset() {}
};

/// Makes a solver; called once per strategy, by any thread, and also to find out its capabilities. Throws std::exception if
/// it cannot.
using SolverFactory = std::function<std::unique_ptr<ForeignSolver>(const SolverRequest& request)>;

}  // namespace evenstep
