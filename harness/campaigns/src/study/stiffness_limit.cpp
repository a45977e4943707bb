#include "evenstep/campaigns/stiffness_limit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "evenstep/harness/run.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_run.h"
#include "evenstep/harness/version.h"
#include "evenstep/pages/campaign_pages.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/scheduler/parallel_for.h"
#include "stiffness_cells.h"

namespace evenstep {
namespace {

constexpr double kRung = 1.15;  // the limits of closed loops differ by large factors; these steps need few runs
constexpr double kCloseEnough = 1.01;

bool interrupted(const StudyControl& control) { return control.interrupted && *control.interrupted; }

/// Makes a tissue stiffer, with its regions and tools in proportion, and if asked also its masses.
void make_stiffer(TissueScene& tissue, double factor, bool masses_too) {
  for (MaterialRegion& region : tissue.regions) region.stiffness_N_per_m *= factor;
  for (ToolCoupling& tool : tissue.tools) tool.stiffness_N_per_m *= factor;
  if (!masses_too) return;
  tissue.particle_mass_kg *= factor;
  tissue.axial_damping_N_s_per_m *= factor;
  for (MaterialRegion& region : tissue.regions) region.particle_mass_kg *= factor;
  for (ToolCoupling& tool : tissue.tools) tool.damping_N_s_per_m *= factor;
}

/// The scenario with another stiffness, without anything that only a report needs, and run to its end: a loop that is cut
/// off before it shakes would count as stable.
Scenario with_stiffness(const Scenario& scenario, double stiffness_N_per_m) {
  Scenario changed = scenario;
  if (auto* tissue = std::get_if<TissueScene>(&changed.scene.body))
    make_stiffer(*tissue, stiffness_N_per_m / tissue->stiffness_N_per_m, scenario.study.stiffness_limit->scales_mass);
  std::visit(
      [&](auto& body) {
        if constexpr (requires { body.stiffness_N_per_m; })
          body.stiffness_N_per_m = stiffness_N_per_m;  // the reader asks for it
      },
      changed.scene.body);
  changed.interrupt = std::nullopt;
  changed.scene.needs_state_digest = false;
  changed.needs_undelayed = false;
  changed.keep_rows = false;
  return changed;
}

/// Runs one strategy of the scenario, whose seed and stiffness are set; returns whether it is stable.
bool stable_run(const Scenario& scenario, const StrategyPlan& plan, const StudyControl& control) {
  RunControl run_control;
  run_control.interrupted = control.interrupted;
  try {
    const StrategyRecord record = run_strategy(scenario, plan, run_control);
    if (interrupted(control)) return false;
    const Nominal nominal = nominal_of(scenario);
    for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool) {
      if (!scenario.devices[tool].hand) continue;
      const std::optional<Oscillation> swing = oscillation(record.devices[tool], nominal);
      if (!swing || !swing->stable()) return false;
    }
    return true;
  } catch (const RunFailure& failure) {
    if (failure.reason == "diverged") return false;
    throw;
  }
}

class Search {
 public:
  Search(const Scenario& scenario, const StudyControl& control, StrategyKind kind) : control_(control) {
    limit_.strategy = name_of(kind);
    for (int i = 0; i < scenario.study.stiffness_limit->seeds; ++i) {
      seeds_.push_back(scenario);
      seeds_.back().seed += static_cast<std::uint64_t>(i);
      seeds_.back().timing.programmed.seed = seeds_.back().seed;
      seeds_.back().strategies = {kind};
      plans_.push_back(plan(seeds_.back()).front());
    }
    limit_.latency_s = seconds(plans_.front().latency);
  }

  StiffnessLimit run(double from_N_per_m, double to_N_per_m) {
    double stable = 0, unstable = from_N_per_m;
    while (stable < to_N_per_m && is_stable(unstable)) {
      stable = unstable;
      unstable = std::min(stable * kRung, to_N_per_m);
    }
    while (stable > 0 && stable < to_N_per_m && unstable > kCloseEnough * stable && !interrupted(control_)) {
      const double middle = std::sqrt(stable * unstable);
      (is_stable(middle) ? stable : unstable) = middle;
    }
    using State = StiffnessLimit::State;
    limit_.state = stable == 0 ? State::below : stable >= to_N_per_m ? State::above : State::found;
    limit_.stable_N_per_m = stable;
    limit_.unstable_N_per_m = limit_.state == State::above ? 0 : unstable;
    return limit_;
  }

 private:
  bool is_stable(double stiffness_N_per_m) {
    for (std::size_t i = 0; i < seeds_.size(); ++i) {
      ++limit_.runs;
      if (!stable_run(with_stiffness(seeds_[i], stiffness_N_per_m), plans_[i], control_)) return false;
    }
    return true;
  }

  const StudyControl& control_;
  std::vector<Scenario> seeds_;
  std::vector<StrategyPlan> plans_;
  StiffnessLimit limit_;
};

}  // namespace

StiffnessLimits internal::stiffness_description(const Scenario& scenario) {
  const StiffnessSearch& search = *scenario.study.stiffness_limit;
  return {.scenario = scenario.name,
          .file = scenario.file,
          .version = kVersion,
          .from_N_per_m = search.from_N_per_m,
          .to_N_per_m = search.to_N_per_m,
          .seed = scenario.seed,
          .seeds = search.seeds,
          .limits = {}};
}

std::optional<StiffnessLimit> internal::stiffness_limit_of(const Scenario& scenario, std::size_t strategy,
                                                           const StudyControl& control) {
  const StiffnessSearch& search = *scenario.study.stiffness_limit;
  const StiffnessLimit limit =
      Search(scenario, control, scenario.strategies[strategy]).run(search.from_N_per_m, search.to_N_per_m);
  if (interrupted(control)) return std::nullopt;
  return limit;
}

StiffnessLimits run_stiffness_limits(const Scenario& scenario, const StudyControl& control) {
  StiffnessLimits study = internal::stiffness_description(scenario);
  std::vector<std::optional<StiffnessLimit>> limits(scenario.strategies.size());
  parallel_for(limits.size(), 0, [&](std::size_t i) { limits[i] = internal::stiffness_limit_of(scenario, i, control); });
  for (const std::optional<StiffnessLimit>& limit : limits) {
    if (limit) study.limits.push_back(*limit);
  }
  study.interrupted = study.limits.size() < limits.size();
  return study;
}

std::vector<FolderFile> stiffness_files(const Scenario& scenario, const StiffnessLimits& study,
                                        const std::string& reproduce) {
  return {{kStudyFile, stiffness_json(study)},
          {"study.csv", stiffness_csv(study)},
          {kReportFile, stiffness_page(study, reproduce)},
          {"resolved.toml", scenario.resolved_toml}};
}

std::string write_stiffness_folder(const std::string& folder, const Scenario& scenario, const StiffnessLimits& study,
                                   const std::string& reproduce) {
  return write_folder(folder, stiffness_files(scenario, study, reproduce));
}

}  // namespace evenstep
