#pragma once
/// A scene's numbers in the scalar type of a solver, derived in one place so that every solver computes with the same bits.
/// Forces are divided by the scene's stiffness, so they are in metres; materials are relative to the scene's own, for which
/// the factor 1 is exact.

#include <array>
#include <vector>

#include "src/tissue/lattice.h"
#include "src/tissue/materials.h"

namespace evenstep::internal {

/// A tool's displacement since its first sample, and how fast it got there.
struct ToolState {
  std::array<double, 3> offset_m{};
  std::array<double, 3> velocity_m_per_s{};
};
using ToolStates = std::array<ToolState, kMaxTools>;

/// The constants of a spring coupling or a probe. For other kinds of tools they are all zero and so have no effect.
template <class Real>
struct ToolConstants {
  Real stiffness{};                ///< of one particle, over the scene's
  Real damping_s{};                ///< of one particle, over the scene's stiffness
  Real half_stiffness_N_per_m{};   ///< of one particle
  Real radius_m{};                 ///< probe
  std::array<Real, 3> center_m{};  ///< probe
};

template <class Real>
struct TissueConstants {
  TissueConstants(const TissueScene& scene, const Lattice& lattice, double substep_s);
  void set_substep(const TissueScene& scene, double substep_s);
  std::array<std::array<Real, 3>, kNeighbours> rest_m{};  ///< vector to the neighbour at rest
  std::array<Real, kNeighbours> length_m{};               ///< its length sqrt(x x + y y + z z), computed in Real
  std::array<Real, kNeighbours> axial_s_per_m2{};         ///< c / (k L^2): axial damping over the stiffness
  Real step_s{}, half_step_s{};
  Real acceleration{};            ///< k step / m: velocity change per metre of (1 - L/len) d
  Real decay{};                   ///< 1 - damping step
  std::array<Real, 3> gravity{};  ///< step g; -0 where g is 0, because x + -0 is x for every x but -0 + 0 is 0
  Real stiffness_per_kg{};        ///< k / m: acceleration per metre of (1 - L/len) d
  Real damping_per_s{};
  std::array<Real, 3> gravity_m_per_s2{};  ///< -0 instead of 0, as above
  Real stiffness_N_per_m{};
  Real half_mass_kg{};
  Real quarter_stiffness_N_per_m{};  ///< a spring's energy k x^2 / 2 is shared by its two ends
  std::array<Real, 3> weight_N{};
  std::array<ToolConstants<Real>, kMaxTools> tools{};
};
extern template struct TissueConstants<float>;
extern template struct TissueConstants<double>;

/// The material per cell; 0 outside the tissue.
template <class Real>
struct MaterialArrays {
  MaterialArrays(const TissueScene& scene, const Lattice& lattice);
  std::vector<Real> stiffness;     ///< over the scene's
  std::vector<Real> inverse_mass;  ///< over the scene's; 0 for what does not move
  std::vector<Real> mass;          ///< over the scene's; 0 for what does not move
};
extern template struct MaterialArrays<float>;
extern template struct MaterialArrays<double>;

/// 1 for the cells that the tool holds as a spring coupling; all 0 if it is another kind of tool.
template <class Real>
std::vector<Real> held_cells(const TissueScene& scene, const Lattice& lattice, std::size_t tool);
/// One component (0 to 2) of the particles' rest positions, m.
template <class Real>
std::vector<Real> rest_positions(const TissueScene& scene, const Lattice& lattice, int component);

}  // namespace evenstep::internal
