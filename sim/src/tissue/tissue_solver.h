#pragma once
/// What all tissue solvers have in common around their substeps: tool offsets, substep targets, force sums, energy balance,
/// verdict.

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "evenstep/sim/solver.h"
#include "src/features.h"
#include "src/tissue/constants.h"
#include "src/tissue/lattice.h"
#include "src/tissue/local_model.h"

namespace evenstep::internal {

/// Sums over the mobile particles that a probe touches: force divided by the scene's stiffness (3), and for the local model
/// also depth, depth times position (3) and stiffness divided by the scene's (xx, yy, zz, xy, xz, yz). The last entry is not
/// a sum but the least distance to the sphere.
using ProbeSums = std::array<double, kProbeValues>;

/// Adds up partial sums [value][partial] in the order of the partials.
template <class Real>
ProbeSums add_partials(std::span<const Real> sums, bool local_model) {
  ProbeSums total{};
  const std::size_t values = local_model ? kProbeValues : kProbeForces, partials = sums.size() / values;
  for (std::size_t value = 0; value < values; ++value) {
    const auto parts = sums.subspan(value * partials, partials);
    double& sum = total[value] = value + 1 == kProbeValues ? parts[0] : 0.0;
    for (const Real part : parts) sum = value + 1 == kProbeValues ? std::min<double>(sum, part) : sum + part;
  }
  return total;
}

/// A probe that touches nothing predicts the touch of all particles that it would touch within this many spacings after the
/// first one. With a smaller value it would predict only one of several particles that it meets at nearly the same time.
inline constexpr double kMeets = 0.1;
/// It predicts a touch from at most this many spacings away: a hand cannot come further before the next record arrives.
inline constexpr double kForeseen = 100;

/// Stored and kinetic energy of springs, couplings, probes and particles, which is never negative; and the energy of
/// gravity, 0 at rest.
struct Energy {
  double stored_J = 0, gravity_J = 0;
};

/// What the tools feel from the particles, read once per step.
struct ToolReadings {
  /// The force on the hand from every particle held (tool after tool, in the order of Lattice::held), newtons.
  std::vector<std::array<double, 3>> held_N;
  /// Per probe: sums of probe_parts (cpu/cell_loops.h) over the particles that it touches.
  std::array<ProbeSums, kMaxTools> probes{};
  /// For the local model: the same sums, but for a probe that touches nothing as if it reached the particles it will touch.
  std::array<ProbeSums, kMaxTools> to_come{};
  /// The displacements of the cells in TissueSolver::watched().
  std::vector<std::array<double, 3>> displacement_m;
};

class TissueSolver : public Solver {
 public:
  TissueSolver(const Scene& scene, const SceneFeatures& features, std::string name);
  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s) final;
  std::span<const ToolContact> contacts() const final { return contacts_; }
  std::uint64_t state_digest() final { return features_.digest ? digest() : 0; }
  void reset() final;
  ParticleState particle_state() final;
  SolverVerdict verdict() final;
  const SolverInfo& info() const final { return info_; }

 protected:
  /// One substep of every particle; the grabbed ones are then put where their tools are `after` it. Forces are evaluated
  /// with couplings and probes where they are at the time of the state.
  virtual void substep(const ToolStates& before, const ToolStates& after) = 0;
  /// Sets the length of the substeps to come, if the step is variable.
  virtual void set_substep(double substep_s) = 0;
  /// Fills `readings`, whose arrays already have their sizes, from the current state with the tools where they are `now`.
  virtual void read_tools(const ToolStates& now, ToolReadings& readings) = 0;
  /// The sums of a probe from the same state, as if its radius were `radius_m`.
  virtual ProbeSums read_probe(std::size_t tool, const ToolStates& now, double radius_m) = 0;
  virtual std::uint64_t digest() = 0;                ///< called only if the scene needs it
  virtual Energy energy(const ToolStates& now) = 0;  ///< called only if the scene needs it
  virtual void to_rest() = 0;
  /// Called after to_rest() and before any step.
  virtual void put_state(const ParticleState& state) = 0;
  /// Initialises what a method keeps between substeps, from the state that the run starts with and tools at rest.
  virtual void start() {}
  virtual void read_state(ParticleState& state) = 0;

  const TissueScene& scene() const { return scene_; }
  const Lattice& lattice() const { return lattice_; }
  const SceneFeatures& features() const { return features_; }
  double substep_s() const { return substep_s_; }  ///< the nominal one before the first step
  /// Sets the scene's initial state; the last thing a solver's constructor does.
  void to_start();
  void set_device(std::string device) { info_.device = std::move(device); }
  /// The cells whose displacements the local model of a grab or a probe needs; empty without a local model.
  const std::vector<std::uint32_t>& watched() const { return watched_; }
  ToolReadings empty_readings() const;

 private:
  void check_position(std::size_t tool, const glm::dvec3& position_m) const;
  void check_length(double step_s) const;
  void take_length(double substep_s);
  ToolResponse sum_forces();
  void prepare_local_model();
  /// The radius of a probe; for one that touches nothing, the radius that would reach what it is about to touch.
  double probe_reach_m(std::size_t tool) const;
  void foresee_touches();
  ToolContact contact(std::size_t tool) const;
  void put_probe(std::size_t tool, ToolContact& contact) const;
  glm::dmat3 coupling(std::size_t tool) const;
  void move_tools(std::span<const glm::dvec3> moved_m);
  void note_finite(bool is_finite);
  void balance_energy(std::span<const glm::dvec3> moved_m, const ToolResponse& response);

  TissueScene scene_;
  Lattice lattice_;
  SceneFeatures features_;
  LocalModel local_model_;
  bool coupled_;                                     // the tools' coupling is requested, and both are grabs or springs
  std::optional<GrabStiffness> grab_stiffness_;      // for the instantaneous model of grabs
  std::optional<ProbeCompliance> probe_compliance_;  // for the settled model of probes
  std::array<glm::dmat3, kMaxTools> settled_{};      // stiffnesses that stay the same for the whole run, settled or not
  glm::dmat3 settled_coupling_{0};                   // coupling of the first tool to the second
  std::vector<std::uint32_t> watched_;
  SolverInfo info_;
  double nominal_substep_s_ = 0, substep_s_ = 0;
  ToolReadings readings_;
  std::vector<glm::dvec3> origin_m_, offset_m_;  // per tool: first sample; displacement since
  ToolStates tools_{};                           // at the end of the last substep
  ToolResponse last_response_;
  std::vector<ToolContact> contacts_;  // per tool; empty without a local model
  SolverVerdict verdict_;
  std::int64_t steps_ = 0;
  double initial_energy_J_ = 0, work_J_ = 0, energy_scale_J_ = 0, worst_excess_J_ = 0;
};

/// The digest before the first chunk's sum is mixed in.
constexpr std::uint64_t kDigestStart = 0x6576656e73746570ULL;  // "evenstep"

}  // namespace evenstep::internal
