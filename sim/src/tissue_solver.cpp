#include "src/tissue_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cfloat>
#include <cmath>
#include <limits>

#include "src/iterations.h"

namespace evenstep::internal {
namespace {

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Names of what this scene does without.
std::vector<std::string> left_out_of(const Scene& scene, const TissueScene& tissue) {
  std::vector<std::string> left_out;
  if (tissue.damping_per_s == 0) left_out.push_back("damping");
  if (!tissue.fixed.any()) left_out.push_back("fixed particles");
  if (scene.tool_count < kMaxTools) left_out.push_back(scene.tool_count == 0 ? "tools" : "second tool");
  if (!scene.variable_step) left_out.push_back("variable step");
  if (!scene.needs_energy) left_out.push_back("energy");
  if (!scene.needs_state_digest) left_out.push_back("state digest");
  return left_out;
}

}  // namespace

template <class Real>
TissueConstants<Real>::TissueConstants(const TissueScene& scene, double substep_s) {
  const Real spacing = static_cast<Real>(scene.spacing_m);
  for (std::size_t s = 0; s < kNeighbours; ++s) {
    const Neighbour& n = kNeighbourhood[s];
    rest_m[s] = {spacing * static_cast<Real>(n.dx), spacing * static_cast<Real>(n.dy), spacing * static_cast<Real>(n.dz)};
    const auto& [x, y, z] = rest_m[s];
    length_m[s] = std::sqrt(x * x + y * y + z * z);  // as the kernels do: at rest 1 - L/len is exactly 0
  }
  set_substep(scene, substep_s);
  stiffness_N_per_m = static_cast<Real>(scene.stiffness_N_per_m);
  half_mass_kg = static_cast<Real>(scene.particle_mass_kg / 2);
  quarter_stiffness_N_per_m = static_cast<Real>(scene.stiffness_N_per_m / 4);
}
template <class Real>
void TissueConstants<Real>::set_substep(const TissueScene& scene, double substep_s) {
  step_s = static_cast<Real>(substep_s);
  acceleration = static_cast<Real>(scene.stiffness_N_per_m * substep_s / scene.particle_mass_kg);
  decay = static_cast<Real>(1 - scene.damping_per_s * substep_s);
}
template struct TissueConstants<float>;
template struct TissueConstants<double>;

TissueSolver::TissueSolver(const Scene& scene, std::string name)
    : scene_((check_tissue(std::get<TissueScene>(scene.body), scene.tool_count), std::get<TissueScene>(scene.body))),
      lattice_(scene_),
      needs_energy_(scene.needs_energy),
      needs_digest_(scene.needs_state_digest),
      variable_step_(scene.variable_step) {
  info_.name = std::move(name);
  info_.particles = scene_.particle_count;
  info_.springs = lattice_.springs;
  info_.method = scene_.method;
  info_.iterations = iterations_of(scene_);
  info_.limit = step_limit(scene_);
  info_.substeps = scene_.substeps > 0 ? scene_.substeps : auto_substeps(scene_, scene.step_rate);
  info_.left_out = left_out_of(scene, scene_);
  nominal_substep_s_ = substep_s_ = period_s(scene.step_rate) / info_.substeps;
  if (substep_s_ > info_.limit->step_s && !scene.allow_unstable) {
    throw SolverError(
        SolverFault::unstable_step,
        fmt::format(
            "a substep of {:.4g} ms is above the limit of {:.4g} ms that holds in every configuration (the rest-state "
            "limit is {:.4g} ms; particle {} sets it)",
            substep_s_ * 1e3, info_.limit->step_s * 1e3, info_.limit->rest_state_step_s * 1e3, info_.limit->particle),
        fmt::format("substeps = \"auto\" or at least {}", auto_substeps(scene_, scene.step_rate)));
  }
  std::size_t grabbed = 0;
  for (const auto& cells : lattice_.held) grabbed += cells.size();
  grab_forces_N_.resize(grabbed);
}

ToolResponse TissueSolver::step(std::span<const glm::dvec3> positions_m, std::optional<double> length_s) {
  const std::size_t tools = lattice_.held.size();
  assert(positions_m.size() == tools);
  for (std::size_t tool = 0; tool < tools; ++tool) check_position(tool, positions_m[tool]);
  if (length_s) check_length(*length_s);
  take_length(length_s ? *length_s / info_.substeps : nominal_substep_s_);
  if (origin_m_.empty()) {
    origin_m_.assign(positions_m.begin(), positions_m.end());
    offset_m_.assign(tools, glm::dvec3(0));
  }
  std::array<glm::dvec3, kMaxTools> moved_m{};
  for (std::size_t tool = 0; tool < tools; ++tool) moved_m[tool] = positions_m[tool] - origin_m_[tool] - offset_m_[tool];

  std::array<GrabTarget, kMaxTools> targets;
  const double step_s = substep_s_ * info_.substeps;
  for (int s = 1; s <= info_.substeps; ++s) {
    const double part = static_cast<double>(s) / info_.substeps;
    for (std::size_t tool = 0; tool < tools; ++tool) {
      const glm::dvec3 offset_m = offset_m_[tool] + moved_m[tool] * part, velocity_m_per_s = moved_m[tool] / step_s;
      targets[tool] = {{offset_m.x, offset_m.y, offset_m.z}, {velocity_m_per_s.x, velocity_m_per_s.y, velocity_m_per_s.z}};
    }
    substep(std::span(targets.data(), tools));
  }
  for (std::size_t tool = 0; tool < tools; ++tool) offset_m_[tool] = positions_m[tool] - origin_m_[tool];

  const ToolResponse response = sum_forces();
  for (std::size_t tool = 0; tool < tools; ++tool) note_finite(finite(response.force_N[tool]));
  if (needs_energy_) balance_energy(std::span(moved_m.data(), tools), response);
  last_response_ = response;
  ++steps_;
  return response;
}

void TissueSolver::check_position(std::size_t tool, const glm::dvec3& position_m) const {
  const glm::dvec3 away_m = origin_m_.empty() ? position_m : position_m - origin_m_[tool];
  const double reach_m = std::max({std::abs(away_m.x), std::abs(away_m.y), std::abs(away_m.z)});
  if (finite(position_m) && reach_m <= FLT_MAX) return;
  throw SolverError(SolverFault::bad_input, fmt::format("step {}: the position of tool {} is not finite", steps_, tool),
                    "check the device's reports or the recorded motion");
}

void TissueSolver::check_length(double step_s) const {
  if (!variable_step_) {
    throw SolverError(SolverFault::bad_input, fmt::format("step {}: a length of its own, but steps are constant", steps_),
                      "Scene::variable_step");
  }
  if (step_s >= 1e-15 && step_s <= 1e15) return;  // with its square and reciprocal a number in float too
  throw SolverError(SolverFault::bad_input, fmt::format("step {}: a length of {:g} s", steps_, step_s),
                    "a positive length");
}

void TissueSolver::take_length(double substep_s) {
  if (substep_s != substep_s_) set_substep(substep_s);
  substep_s_ = substep_s;
  const double over_limit = substep_s / info_.limit->step_s;
  verdict_.steps_over_limit += over_limit > 1;
  verdict_.step_over_limit_max = std::max(verdict_.step_over_limit_max, over_limit);
}

ToolResponse TissueSolver::sum_forces() {
  grab_forces(grab_forces_N_);
  ToolResponse response;
  auto next = grab_forces_N_.begin();
  for (std::size_t tool = 0; tool < lattice_.held.size(); ++tool) {
    glm::dvec3& sum_N = response.force_N[tool];
    for (std::size_t n = 0; n < lattice_.held[tool].size(); ++n, ++next)
      sum_N += glm::dvec3((*next)[0], (*next)[1], (*next)[2]);
    // Forces are hashed, and which NaN an operation returns is up to the device: report one and the same.
    for (double* component : {&sum_N.x, &sum_N.y, &sum_N.z}) {
      if (std::isnan(*component)) *component = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return response;
}

void TissueSolver::note_finite(bool is_finite) {
  if (is_finite || verdict_.non_finite) return;
  verdict_.non_finite = true;
  verdict_.first_bad_step = steps_;
}

/// The hand does work -f dx on the tissue (f is what the hand feels; trapezoid over the step). Damping only takes energy
/// away, so energy - work above zero is growth that physics does not have.
void TissueSolver::balance_energy(std::span<const glm::dvec3> moved_m, const ToolResponse& response) {
  for (std::size_t tool = 0; tool < moved_m.size(); ++tool) {
    const glm::dvec3 mean_N = (last_response_.force_N[tool] + response.force_N[tool]) * 0.5;
    work_J_ -= mean_N.x * moved_m[tool].x + mean_N.y * moved_m[tool].y + mean_N.z * moved_m[tool].z;
  }
  verdict_.energy_J = energy();
  note_finite(std::isfinite(verdict_.energy_J) && std::isfinite(work_J_));
  if (verdict_.non_finite) {
    verdict_.energy_growth = std::numeric_limits<double>::infinity();
    return;
  }
  energy_scale_J_ = std::max({energy_scale_J_, std::abs(work_J_), verdict_.energy_J});
  worst_excess_J_ = std::max(worst_excess_J_, verdict_.energy_J - work_J_);
  verdict_.energy_growth = energy_scale_J_ > 0 ? worst_excess_J_ / energy_scale_J_ : 0;
}

void TissueSolver::to_start() {
  to_rest();
  if (scene_.initial_displacement_m.empty() && scene_.initial_velocity_m_per_s.empty()) return;
  ParticleState start{scene_.initial_displacement_m, scene_.initial_velocity_m_per_s};
  start.displacement_m.resize(static_cast<std::size_t>(scene_.particle_count));
  start.velocity_m_per_s.resize(static_cast<std::size_t>(scene_.particle_count));
  put_state(start);
}

ParticleState TissueSolver::particle_state() {
  ParticleState state;
  state.displacement_m.resize(static_cast<std::size_t>(scene_.particle_count));
  state.velocity_m_per_s.resize(static_cast<std::size_t>(scene_.particle_count));
  read_state(state);
  return state;
}

void TissueSolver::reset() {
  to_start();
  origin_m_.clear();
  offset_m_.clear();
  last_response_ = {};
  verdict_ = {};
  steps_ = 0;
  work_J_ = energy_scale_J_ = worst_excess_J_ = 0;
}

SolverVerdict TissueSolver::verdict() { return verdict_; }

}  // namespace evenstep::internal
