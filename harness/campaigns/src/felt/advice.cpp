// The advice on what to use for a given error of the felt force, and the folder of such a study.
#include <fmt/format.h>

#include "evenstep/campaigns/felt_study.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/pages/campaign_pages.h"

namespace evenstep {

FeltAdvice advise(const FeltStudyRecord& study, const StudyGoal& goal) {
  if (goal.quantity != StudyQuantity::force)
    return {false,
            fmt::format("a study of the felt force cannot tell what meets {}; write such as \"1 % force\"", goal.text)};
  if (study.interrupted) return {false, no_advice_if_interrupted(goal)};
  const double most_N = goal.most * study.reference.scale_N;
  if (!(study.reference.estimate_N <= most_N))
    return {false, fmt::format("cannot tell what meets {}: the reference itself may be off by {:.3g} %", goal.text,
                               100 * study.reference.estimate_N / study.reference.scale_N)};
  const FeltPoint *best = nullptr, *least = nullptr;
  for (const FeltPoint& point : study.points) {
    if (point.state != StudyCell::State::measured) continue;
    if (least == nullptr || point.total.rms_N < least->total.rms_N) least = &point;
    if (!(point.total.rms_N <= most_N)) continue;
    // All strategies with one method and step cost the same: of these the one with the least error.
    if (best == nullptr || point.cpu.median < best->cpu.median ||
        (point.cpu.median == best->cpu.median && point.total.rms_N < best->total.rms_N))
      best = &point;
  }
  const auto name = [&](const FeltPoint& point) {
    return fmt::format("{}, {} on {}, step {:.6g} ms: error {:.3g} %", point.strategy, point.method, point.solver,
                       1e3 * point.substep_s, 100 * point.total.rms_N / study.reference.scale_N);
  };
  if (best == nullptr)
    return {false, fmt::format("none meets {}{}", goal.text, least ? "; the least error has " + name(*least) : "")};
  std::string text = fmt::format("cheapest for {}: {}, latency {:.3g} ms, {:.3g} CPU seconds per simulated second",
                                 goal.text, name(*best), 1e3 * (best->latency_s + best->device_latency_s), best->cpu.median);
  if (!best->machine.empty()) text += " on " + best->machine;
  if (const std::string warning = warning_of(study.machines); !warning.empty()) text += '\n' + warning;
  return {true, text};
}

std::vector<FolderFile> felt_study_files(const Scenario& scenario, const FeltStudyRecord& study,
                                         const std::string& reproduce) {
  return {{kStudyFile, felt_study_json(study)},
          {"study.csv", felt_study_csv(study)},
          {kStudyFigure, felt_study_svg(study)},
          {kReportFile, felt_study_page(study, reproduce)},
          {"resolved.toml", scenario.resolved_toml}};
}

std::string write_felt_study_folder(const std::string& folder, const Scenario& scenario, const FeltStudyRecord& study,
                                    const std::string& reproduce) {
  return write_folder(folder, felt_study_files(scenario, study, reproduce));
}

}  // namespace evenstep
