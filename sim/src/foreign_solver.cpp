#include "src/foreign_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "evenstep/time/digest.h"
#include "src/environments.h"

namespace evenstep::internal {
namespace {

std::vector<std::string> lacking(const SolverCapabilities& has) {
  std::vector<std::string> names;
  for (const auto& [there, name] :
       {std::pair{has.contacts, "contacts"}, std::pair{has.state_digest, "state_digest"}, std::pair{has.energy, "energy"},
        std::pair{has.particles, "particles"}, std::pair{has.reset, "reset"}}) {
    if (!there) names.emplace_back(name);
  }
  return names;
}

std::vector<std::string> left_out_by(const SolverCapabilities& has, const Scene& scene) {
  std::vector<std::string> names;
  if (!has.particles) names.emplace_back("particles");
  if (!scene.variable_step) names.emplace_back("variable step");
  if (!scene.needs_state_digest || !(has.state_digest || has.particles)) names.emplace_back("state digest");
  if (!scene.needs_energy || !has.energy) names.emplace_back("energy");
  if (scene.local_model == LocalModel::none || !has.contacts) names.emplace_back("local model");
  return names;
}

std::uint64_t digest_of(const ParticleState& state) {
  std::uint64_t digest = 0;
  for (const auto* vectors : {&state.displacement_m, &state.velocity_m_per_s}) {
    for (const glm::dvec3& v : *vectors) digest = mix(mix(mix(digest, v.x), v.y), v.z);
  }
  return digest;
}

/// Energy that the work of the tools does not explain: SolverVerdict::energy_growth, with the whole energy as the part that
/// is never negative. No work has moved the tools to their places in the first step, so the account begins after that step.
class EnergyAccount {
 public:
  /// After a step. Returns the growth so far.
  double add(std::span<const glm::dvec3> positions_m, const ToolResponse& response, double energy_J) {
    if (!begun_) initial_J_ = energy_J;
    for (std::size_t tool = 0; tool < positions_m.size() && begun_; ++tool) {
      const glm::dvec3 mean_N = (last_N_.force_N[tool] + response.force_N[tool]) * 0.5;
      const glm::dvec3 moved_m = positions_m[tool] - last_m_[tool];
      work_J_ -= mean_N.x * moved_m.x + mean_N.y * moved_m.y + mean_N.z * moved_m.z;
    }
    begun_ = true;
    last_N_ = response;
    std::copy(positions_m.begin(), positions_m.end(), last_m_.begin());
    scale_J_ = std::max({scale_J_, std::abs(work_J_), std::abs(energy_J)});
    worst_J_ = std::max(worst_J_, energy_J - initial_J_ - work_J_);
    return scale_J_ > 0 ? worst_J_ / scale_J_ : 0;
  }

 private:
  bool begun_ = false;
  double initial_J_ = 0, work_J_ = 0, scale_J_ = 0, worst_J_ = 0;
  ToolResponse last_N_;
  std::array<glm::dvec3, kMaxTools> last_m_{};
};

class ForeignAsSolver final : public Solver {
 public:
  ForeignAsSolver(const ForeignScene& foreign, const Scene& scene)
      : foreign_(foreign),
        request_{.name = foreign.name,
                 .options = foreign.options,
                 .step_s = period_s(scene.step_rate),
                 .tool_count = scene.tool_count,
                 .variable_step = scene.variable_step,
                 .local_model = scene.local_model,
                 .seed = foreign.seed},
        needs_energy_(scene.needs_energy) {
    make();
    if (scene.local_model != LocalModel::none && !has_.contacts)
      throw SolverError(SolverFault::bad_scene,
                        fmt::format("the solver '{}' has no contacts, from which a device renders locally", foreign.name),
                        "render = { kind = \"force\" } in [[device]], or a solver with contacts");
    info_.name = foreign.name;
    info_.left_out = left_out_by(has_, scene);
    info_.lacks = lacking(has_);
    contacts_.resize(scene.local_model == LocalModel::none ? 0 : static_cast<std::size_t>(scene.tool_count));
  }

  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s) override {
    check_positions(positions_m);
    const ToolResponse given = guarded([&] { return solver_->step(positions_m, step_s.value_or(request_.step_s)); });
    ToolResponse response;
    std::copy_n(given.force_N.begin(), positions_m.size(), response.force_N.begin());
    for (const glm::dvec3& f : response.force_N) note_finite(std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.z));
    if (!contacts_.empty()) take_contacts();
    if (needs_energy_ && has_.energy) account(positions_m, response);
    ++steps_;
    return response;
  }
  std::span<const ToolContact> contacts() const override { return contacts_; }
  std::uint64_t state_digest() override {
    if (has_.state_digest) return guarded([&] { return solver_->state_digest(); });
    return has_.particles ? digest_of(particle_state()) : 0;
  }
  void reset() override {
    if (has_.reset)
      guarded([&] { solver_->reset(); });
    else
      make();
    verdict_ = {};
    steps_ = 0;
    energy_ = {};
    std::fill(contacts_.begin(), contacts_.end(), ToolContact{});
  }
  ParticleState particle_state() override {
    if (!has_.particles) return {};
    return guarded([&] { return solver_->particles(); });
  }
  SolverVerdict verdict() override { return verdict_; }
  const SolverInfo& info() const override { return info_; }

 private:
  void make() {
    if (!foreign_.make)
      throw SolverError(SolverFault::unavailable, "the solver '" + foreign_.name + "' is not registered",
                        "register it in the program that runs the scenario");
    solver_ = guarded([&] { return foreign_.make(request_); });
    if (!solver_) throw failed("its factory returned nothing", "return a solver, or throw why there is none");
    has_ = solver_->capabilities();
  }

  /// Runs the solver's own code; adds the solver's name and the step to its errors.
  template <class Call>
  auto guarded(Call call) -> decltype(call()) {
    try {
      return call();
    } catch (const SolverError& error) {
      throw SolverError(error.fault(), named(error.what()), error.remedy());
    } catch (const std::exception& error) {
      throw failed(error.what(), "see what the solver does there");
    } catch (...) {
      throw failed("it threw something that is no std::exception", "throw SolverError");
    }
  }
  std::string named(const std::string& what) const {
    return fmt::format("the solver '{}'{}: {}", foreign_.name, solver_ ? fmt::format(", step {}", steps_) : "", what);
  }
  SolverError failed(const std::string& what, const std::string& remedy) const {
    return SolverError(SolverFault::unavailable, named(what), remedy);
  }

  void take_contacts() {
    const std::span<const ToolContact> given = guarded([&] { return solver_->contacts(); });
    if (given.size() < contacts_.size())
      throw failed(fmt::format("contacts() gave {} for {} tools", given.size(), contacts_.size()), "return one per tool");
    std::copy_n(given.begin(), contacts_.size(), contacts_.begin());
  }

  void account(std::span<const glm::dvec3> positions_m, const ToolResponse& response) {
    verdict_.energy_J = guarded([&] { return solver_->energy_J(); });
    note_finite(std::isfinite(verdict_.energy_J));
    const double growth = energy_.add(positions_m, response, verdict_.energy_J);
    verdict_.energy_growth = verdict_.non_finite ? std::numeric_limits<double>::infinity() : growth;
  }

  void note_finite(bool is_finite) {
    if (is_finite || verdict_.non_finite) return;
    verdict_.non_finite = true;
    verdict_.first_bad_step = steps_;
  }

  ForeignScene foreign_;
  SolverRequest request_;
  bool needs_energy_;
  std::unique_ptr<ForeignSolver> solver_;
  SolverCapabilities has_;
  SolverInfo info_;
  SolverVerdict verdict_;
  EnergyAccount energy_;
  std::vector<ToolContact> contacts_;
  std::int64_t steps_ = 0;
};

}  // namespace

std::unique_ptr<Solver> make_foreign_solver(const ForeignScene& foreign, const Scene& scene) {
  return std::make_unique<ForeignAsSolver>(foreign, scene);
}

}  // namespace evenstep::internal
