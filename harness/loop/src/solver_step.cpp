#include "evenstep/loop/solver_step.h"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "evenstep/clock/wall_clock.h"

namespace evenstep {
namespace {

Symmetric symmetric(const glm::dmat3& k) {  // [column][row]
  return {.xx = k[0][0], .yy = k[1][1], .zz = k[2][2], .xy = k[1][0], .xz = k[2][0], .yz = k[2][1]};
}

bool is_finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

RunFailure run_failure(const SolverError& error, std::int64_t at_step) {
  return RunFailure(name_of(error.fault()), error.what(), error.remedy(), at_step);
}

void SolverStep::begins(RealTime began) {
  ++begun;
  if (variable_ && began_) step_s_ = evenstep::seconds(began - *began_);
  if (!first_began_) first_began_ = began;
  simulated_ = variable_ ? SimTime{(began - *first_began_).ns} : sim_time(step_rate_, step_);
  began_ = began;
}

void SolverStep::give(int tool, const glm::dvec3& position_m, RealTime read_at) {
  positions_m[static_cast<std::size_t>(tool)] = position_m;
  read_at_[static_cast<std::size_t>(tool)] = read_at;
}

ContactRecord SolverStep::contact(int tool) const {
  const auto index = static_cast<std::size_t>(tool);
  ContactRecord record;
  record.force_N = response.force_N[index];
  record.tool_m = positions_m[index];
  record.read_at = read_at_[index];
  const std::span<const ToolContact> contacts = solver_.contacts();
  if (contacts.empty()) return record;
  const ToolContact& contact = contacts[index];
  record.stiffness_N_per_m = symmetric(contact.stiffness_N_per_m);
  record.coupling_N_per_m = contact.coupling_N_per_m;
  if (tool_count_ == 2) {
    record.other_m = positions_m[1 - index];
    record.other_stiffness_N_per_m = symmetric(contacts[1 - index].stiffness_N_per_m);
    record.other_force_N = response.force_N[1 - index];
  }
  record.normal = contact.normal;
  record.gap_m = contact.gap_m;
  record.unilateral = contact.unilateral;
  return record;
}

void SolverStep::run() {
  const double started_s = monotonic_seconds();
  const std::span<const glm::dvec3> tools(positions_m.data(), static_cast<std::size_t>(tool_count_));
  try {
    response = variable_ ? solver_.step(tools, step_s_) : solver_.step(tools);
  } catch (const SolverError& error) {
    throw run_failure(error, step_);
  }
  for (const glm::dvec3& force_N : response.force_N) {
    if (is_finite(force_N)) continue;
    throw RunFailure("diverged", fmt::format("step {}: the solver's force is not finite", step_),
                     "a smaller step size or substeps = \"auto\"", step_);
  }
  if (digest_) state_digest = solver_.state_digest();
  ++step_;
  seconds += monotonic_seconds() - started_s;
}

}  // namespace evenstep
