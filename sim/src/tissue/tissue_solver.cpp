#include "src/tissue/tissue_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cfloat>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "src/tissue/iterations.h"

namespace evenstep::internal {
namespace {

bool is_finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Which NaN an operation returns depends on the device, but forces are hashed: so the same NaN is always reported.
double canonical(double value) { return std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value; }
glm::dvec3 canonical(const glm::dvec3& v) { return {canonical(v.x), canonical(v.y), canonical(v.z)}; }

}  // namespace

TissueSolver::TissueSolver(const Scene& scene, const SceneFeatures& features, std::string name)
    : scene_((check_tissue(std::get<TissueScene>(scene.body), scene.tool_count), std::get<TissueScene>(scene.body))),
      lattice_(scene_),
      features_(features),
      local_model_(scene.local_model),
      coupled_(scene.local_coupling && scene_.tools.size() == 2 &&
               std::none_of(scene_.tools.begin(), scene_.tools.end(),
                            [](const ToolCoupling& tool) { return tool.kind == CouplingKind::probe; })) {
  info_.name = std::move(name);
  info_.particles = scene_.particle_count;
  info_.springs = lattice_.springs;
  info_.method = scene_.method;
  info_.iterations = iterations_of(scene_);
  info_.limit = step_limit(scene_);
  info_.substeps = scene_.substeps > 0 ? scene_.substeps : auto_substeps(scene_, scene.step_rate);
  info_.left_out = internal::left_out(features_);
  nominal_substep_s_ = substep_s_ = period_s(scene.step_rate) / info_.substeps;
  if (substep_s_ > info_.limit->step_s && !scene.allow_unstable) {
    throw SolverError(
        SolverFault::unstable_step,
        fmt::format(
            "a substep of {:.4g} ms is above the limit of {:.4g} ms that holds in every configuration (the rest-state "
            "limit is {:.4g} ms; {})",
            substep_s_ * 1e3, info_.limit->step_s * 1e3, info_.limit->rest_state_step_s * 1e3,
            what_sets(scene_, *info_.limit)),
        fmt::format("substeps = \"auto\" or at least {}", auto_substeps(scene_, scene.step_rate)));
  }
  if (features_.local_model) prepare_local_model();
  readings_ = empty_readings();
}

void TissueSolver::prepare_local_model() {
  contacts_.resize(scene_.tools.size());
  for (std::size_t tool = 0; tool < scene_.tools.size(); ++tool) {
    const ToolCoupling& coupling = scene_.tools[tool];
    if (coupling.kind == CouplingKind::probe) {
      if (local_model_ == LocalModel::settled && !probe_compliance_)
        probe_compliance_.emplace(scene_, lattice_, info_.name == "cpu-double");
    } else if (local_model_ == LocalModel::settled)
      settled_[tool] = settled_stiffness(scene_, lattice_, tool);
    else if (coupling.kind == CouplingKind::spring)
      settled_[tool] = glm::dmat3(coupling.stiffness_N_per_m);
    else if (!grab_stiffness_)
      grab_stiffness_.emplace(scene_, lattice_);
  }
  if (coupled_ && local_model_ == LocalModel::settled) settled_coupling_ = settled_coupling(scene_, lattice_, 0, 1);
  if (grab_stiffness_) watched_ = grab_stiffness_->cells();
  if (probe_compliance_) watched_ = probe_compliance_->cells();
}

ToolReadings TissueSolver::empty_readings() const {
  ToolReadings readings;
  std::size_t held = 0;
  for (const auto& cells : lattice_.held) held += cells.size();
  readings.held_N.resize(held);
  readings.displacement_m.resize(watched_.size());
  return readings;
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

  move_tools(std::span(moved_m.data(), tools));
  for (std::size_t tool = 0; tool < tools; ++tool) offset_m_[tool] = positions_m[tool] - origin_m_[tool];

  const ToolResponse response = sum_forces();
  if (!contacts_.empty()) foresee_touches();
  for (std::size_t tool = 0; tool < contacts_.size(); ++tool) contacts_[tool] = contact(tool);
  for (std::size_t tool = 0; tool < tools; ++tool) note_finite(is_finite(response.force_N[tool]));
  if (features_.energy) balance_energy(std::span(moved_m.data(), tools), response);
  last_response_ = response;
  ++steps_;
  return response;
}

void TissueSolver::move_tools(std::span<const glm::dvec3> moved_m) {
  const double step_s = substep_s_ * info_.substeps;
  for (int s = 1; s <= info_.substeps; ++s) {
    const double part = static_cast<double>(s) / info_.substeps;
    const ToolStates before = tools_;
    for (std::size_t tool = 0; tool < moved_m.size(); ++tool) {
      const glm::dvec3 offset_m = offset_m_[tool] + moved_m[tool] * part, velocity_m_per_s = moved_m[tool] / step_s;
      tools_[tool] = {{offset_m.x, offset_m.y, offset_m.z}, {velocity_m_per_s.x, velocity_m_per_s.y, velocity_m_per_s.z}};
    }
    substep(before, tools_);
  }
}

void TissueSolver::check_position(std::size_t tool, const glm::dvec3& position_m) const {
  const glm::dvec3 away_m = origin_m_.empty() ? position_m : position_m - origin_m_[tool];
  const double reach_m = std::max({std::abs(away_m.x), std::abs(away_m.y), std::abs(away_m.z)});
  if (is_finite(position_m) && reach_m <= FLT_MAX) return;
  throw SolverError(SolverFault::bad_input, fmt::format("step {}: the position of tool {} is not finite", steps_, tool),
                    "check the device's reports or the recorded motion");
}

void TissueSolver::check_length(double step_s) const {
  if (!features_.variable_step) {
    throw SolverError(SolverFault::bad_input, fmt::format("step {}: a length of its own, but steps are constant", steps_),
                      "Scene::variable_step");
  }
  if (step_s >= 1e-15 && step_s <= 1e15) return;  // so that its square and reciprocal are finite in float too
  throw SolverError(SolverFault::bad_input, fmt::format("step {}: a length of {:g} s", steps_, step_s), "a positive length");
}

void TissueSolver::take_length(double substep_s) {
  if (substep_s != substep_s_) set_substep(substep_s);
  substep_s_ = substep_s;
  const double over_limit = substep_s / info_.limit->step_s;
  verdict_.steps_over_limit += over_limit > 1;
  verdict_.step_over_limit_max = std::max(verdict_.step_over_limit_max, over_limit);
}

ToolResponse TissueSolver::sum_forces() {
  read_tools(tools_, readings_);
  ToolResponse response;
  auto next = readings_.held_N.begin();
  for (std::size_t tool = 0; tool < lattice_.held.size(); ++tool) {
    glm::dvec3& sum_N = response.force_N[tool];
    for (std::size_t n = 0; n < lattice_.held[tool].size(); ++n, ++next)
      sum_N += glm::dvec3((*next)[0], (*next)[1], (*next)[2]);
    const ProbeSums& probe = readings_.probes[tool];
    if (scene_.tools[tool].kind == CouplingKind::probe)
      sum_N = glm::dvec3(probe[0], probe[1], probe[2]) * -scene_.stiffness_N_per_m;
    sum_N = canonical(sum_N);
  }
  return response;
}

double TissueSolver::probe_reach_m(std::size_t tool) const {
  const double radius_m = scene_.tools[tool].radius_m, gap_m = readings_.probes[tool].back();
  const bool foresees = gap_m >= 0 && gap_m <= kForeseen * scene_.spacing_m;
  return foresees ? radius_m + gap_m + kMeets * scene_.spacing_m : radius_m;
}

void TissueSolver::foresee_touches() {
  for (std::size_t tool = 0; tool < scene_.tools.size(); ++tool) {
    if (scene_.tools[tool].kind != CouplingKind::probe) continue;
    readings_.to_come[tool] = readings_.probes[tool];
    const double reach_m = probe_reach_m(tool);
    if (reach_m > scene_.tools[tool].radius_m) readings_.to_come[tool] = read_probe(tool, tools_, reach_m);
  }
}

ToolContact TissueSolver::contact(std::size_t tool) const {
  const ToolCoupling& coupling = scene_.tools[tool];
  const auto& [x, y, z] = tools_[tool].offset_m;
  const glm::dvec3 center_m = canonical(coupling.center_m + glm::dvec3(x, y, z));
  ToolContact contact{.touching = true, .point_m = center_m, .stiffness_N_per_m = settled_[tool]};
  if (coupling.kind == CouplingKind::grab && grab_stiffness_)
    contact.stiffness_N_per_m = grab_stiffness_->of(tool, readings_.displacement_m);
  if (coupling.kind == CouplingKind::probe) put_probe(tool, contact);
  if (coupled_) contact.coupling_N_per_m = this->coupling(tool);
  for (int column = 0; column < 3; ++column)
    contact.stiffness_N_per_m[column] = canonical(contact.stiffness_N_per_m[column]);
  return contact;
}

glm::dmat3 TissueSolver::coupling(std::size_t tool) const {
  const glm::dmat3 of_first = grab_stiffness_ ? grab_stiffness_->coupling(0, readings_.displacement_m) : settled_coupling_;
  return tool == 0 ? of_first : glm::transpose(of_first);
}

void TissueSolver::put_probe(std::size_t tool, ToolContact& contact) const {
  const auto& [fx, fy, fz, depth, px, py, pz, xx, yy, zz, xy, xz, yz, nearest_m] = readings_.to_come[tool];
  const glm::dvec3 center_m = contact.point_m;
  contact.touching = readings_.probes[tool][3] > 0;
  contact.unilateral = true;
  contact.gap_m = readings_.probes[tool].back();
  if (depth > 0) {
    contact.point_m = canonical(glm::dvec3(px, py, pz) / depth);
    const glm::dvec3 out_m = center_m - contact.point_m;
    const double length_m = glm::length(out_m);
    if (length_m > 0) contact.normal = out_m / length_m;
  }
  contact.stiffness_N_per_m = glm::dmat3(xx, xy, xz, xy, yy, yz, xz, yz, zz) * scene_.stiffness_N_per_m;
  if (!probe_compliance_) return;
  const auto& [x, y, z] = tools_[tool].offset_m;
  contact.stiffness_N_per_m =
      probe_compliance_->settled(tool, {x, y, z}, probe_reach_m(tool), readings_.displacement_m, contact.stiffness_N_per_m);
}

void TissueSolver::note_finite(bool is_finite) {
  if (is_finite || verdict_.non_finite) return;
  verdict_.non_finite = true;
  verdict_.first_bad_step = steps_;
}

/// The hand does work -f dx on the tissue (f is what the hand feels; trapezoid rule over the step). Damping can only take
/// energy away, so energy - work above zero is growth that physics cannot explain.
void TissueSolver::balance_energy(std::span<const glm::dvec3> moved_m, const ToolResponse& response) {
  for (std::size_t tool = 0; tool < moved_m.size(); ++tool) {
    const glm::dvec3 mean_N = (last_response_.force_N[tool] + response.force_N[tool]) * 0.5;
    work_J_ -= mean_N.x * moved_m[tool].x + mean_N.y * moved_m[tool].y + mean_N.z * moved_m[tool].z;
  }
  const auto [stored_J, gravity_J] = energy(tools_);
  verdict_.energy_J = canonical(stored_J + gravity_J);
  note_finite(std::isfinite(verdict_.energy_J) && std::isfinite(work_J_));
  if (verdict_.non_finite) {
    verdict_.energy_growth = std::numeric_limits<double>::infinity();
    return;
  }
  energy_scale_J_ = std::max({energy_scale_J_, std::abs(work_J_), stored_J, std::abs(gravity_J)});
  worst_excess_J_ = std::max(worst_excess_J_, verdict_.energy_J - initial_energy_J_ - work_J_);
  verdict_.energy_growth = energy_scale_J_ > 0 ? worst_excess_J_ / energy_scale_J_ : 0;
}

void TissueSolver::to_start() {
  to_rest();
  if (!scene_.initial_displacement_m.empty() || !scene_.initial_velocity_m_per_s.empty()) {
    ParticleState state{scene_.initial_displacement_m, scene_.initial_velocity_m_per_s};
    state.displacement_m.resize(static_cast<std::size_t>(scene_.particle_count));
    state.velocity_m_per_s.resize(static_cast<std::size_t>(scene_.particle_count));
    for (std::size_t n = 0; n < state.velocity_m_per_s.size(); ++n)
      if (lattice_.mobile[lattice_.cell(static_cast<std::int64_t>(n))] == 0) state.velocity_m_per_s[n] = glm::dvec3(0);
    put_state(state);
  }
  start();
  if (!features_.energy) return;
  const auto [stored_J, gravity_J] = energy({});
  initial_energy_J_ = stored_J + gravity_J;
  energy_scale_J_ = std::max(stored_J, std::abs(gravity_J));
}

ParticleState TissueSolver::particle_state() {
  ParticleState state;
  state.displacement_m.resize(static_cast<std::size_t>(scene_.particle_count));
  state.velocity_m_per_s.resize(static_cast<std::size_t>(scene_.particle_count));
  read_state(state);
  return state;
}

void TissueSolver::reset() {
  origin_m_.clear();
  offset_m_.clear();
  tools_ = {};
  last_response_ = {};
  std::fill(contacts_.begin(), contacts_.end(), ToolContact{});
  verdict_ = {};
  steps_ = 0;
  work_J_ = worst_excess_J_ = 0;
  to_start();
}

SolverVerdict TissueSolver::verdict() { return verdict_; }

}  // namespace evenstep::internal
