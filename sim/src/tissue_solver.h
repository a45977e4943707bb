#pragma once
/// What every tissue solver does around its substeps: tool offsets, substep targets, force sums, energy balance, verdict.

#include <array>
#include <span>
#include <vector>

#include "evenstep/sim/solver.h"
#include "src/lattice.h"

namespace evenstep::internal {

/// Where each tool has its particles at the end of a substep, relative to rest, and how fast they got there.
struct GrabTarget {
  std::array<double, 3> offset_m{};
  std::array<double, 3> velocity_m_per_s{};
};

/// The scene's constants in the solver's scalar type, derived once, so that every solver computes with the same bits.
template <class Real>
struct TissueConstants {
  TissueConstants(const TissueScene& scene, double substep_s);
  void set_substep(const TissueScene& scene, double substep_s);
  std::array<std::array<Real, 3>, kNeighbours> rest_m{};  ///< vector to the neighbour at rest
  std::array<Real, kNeighbours> length_m{};               ///< sqrt(x x + y y + z z) of it, in Real
  Real step_s{};
  Real acceleration{};  ///< k step / m: velocity change per metre of (1 - L/len) d
  Real decay{};         ///< 1 - damping step
  Real stiffness_N_per_m{};
  Real half_mass_kg{};
  Real quarter_stiffness_N_per_m{};  ///< a spring's energy k x^2 / 2 is shared by its two ends
};
extern template struct TissueConstants<float>;
extern template struct TissueConstants<double>;

class TissueSolver : public Solver {
 public:
  TissueSolver(const Scene& scene, std::string name);
  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s) final;
  std::uint64_t state_digest() final { return needs_digest_ ? digest() : 0; }
  void reset() final;
  ParticleState particle_state() final;
  SolverVerdict verdict() final;
  const SolverInfo& info() const final { return info_; }

 protected:
  /// One substep of every particle, then the grabbed ones to their targets.
  virtual void substep(std::span<const GrabTarget> targets) = 0;
  /// Length of the substeps to come, where variable_step().
  virtual void set_substep(double substep_s) = 0;
  /// Spring force on every grabbed particle (tool after tool, in the order of Lattice::held), newtons.
  virtual void grab_forces(std::span<std::array<double, 3>> forces_N) = 0;
  virtual std::uint64_t digest() = 0;  ///< only where needs_digest()
  virtual double energy() = 0;         ///< joules; only where needs_energy()
  virtual void to_rest() = 0;
  /// Of the particle in `cell`; put_state comes after to_rest() and before a step.
  virtual void put_state(const ParticleState& state) = 0;
  virtual void read_state(ParticleState& state) = 0;

  const TissueScene& scene() const { return scene_; }
  const Lattice& lattice() const { return lattice_; }
  double substep_s() const { return substep_s_; }  ///< before the first step: the nominal one
  bool variable_step() const { return variable_step_; }
  bool needs_energy() const { return needs_energy_; }
  bool needs_digest() const { return needs_digest_; }
  std::size_t grabbed_count() const { return grab_forces_N_.size(); }
  /// To the scene's initial state; the last thing a solver's constructor does.
  void to_start();
  void set_device(std::string device) { info_.device = std::move(device); }

 private:
  void check_position(std::size_t tool, const glm::dvec3& position_m) const;
  void check_length(double step_s) const;
  void take_length(double substep_s);
  ToolResponse sum_forces();
  void note_finite(bool is_finite);
  void balance_energy(std::span<const glm::dvec3> moved_m, const ToolResponse& response);

  TissueScene scene_;
  Lattice lattice_;
  bool needs_energy_, needs_digest_, variable_step_;
  SolverInfo info_;
  double nominal_substep_s_ = 0, substep_s_ = 0;
  std::vector<std::array<double, 3>> grab_forces_N_;
  std::vector<glm::dvec3> origin_m_, offset_m_;  // per tool: first sample; displacement since
  ToolResponse last_response_;
  SolverVerdict verdict_;
  std::int64_t steps_ = 0;
  double work_J_ = 0, energy_scale_J_ = 0, worst_excess_J_ = 0;
};

/// The digest before the first chunk's sum is mixed in.
constexpr std::uint64_t kDigestStart = 0x6576656e73746570ULL;  // "evenstep"

}  // namespace evenstep::internal
