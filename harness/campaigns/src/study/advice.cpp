// The advice on what to use for a given error, and the folder of a study.
#include <fmt/format.h>

#include "evenstep/campaigns/study.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/pages/campaign_pages.h"

namespace evenstep {
namespace {

std::string amount(const StudyGoal& goal, double error, const StudyRecord& study) {
  if (goal.quantity != StudyQuantity::position) return fmt::format("{:.3g} %", 100 * error);
  const std::string metres = fmt::format("{:.3g} m", error);
  return goal.is_share ? fmt::format("{:.3g} % ({})", 100 * error / study.reference.scale[goal.quantity], metres) : metres;
}

std::string cell_name(const StudyCell& cell) {
  return fmt::format("{} on {}{}, step {:.6g} ms", cell.method, cell.solver,
                     cell.iterations > 0 ? fmt::format(", {} iterations", cell.iterations) : "", 1e3 * cell.substep_s);
}

std::string real_time(const StudyCell& cell) {
  const std::string cost = fmt::format("{:.3g} CPU seconds per simulated second ({:.3g} to {:.3g} in {} repeats)",
                                       cell.cpu.median, cell.cpu.min, cell.cpu.max, cell.repeats);
  const std::string where = cell.machine.empty() ? "here" : "on " + cell.machine;
  return cell.cpu.max < 1 ? fmt::format("{}: keeps real time {}, {:.3g} times over", cost, where, 1 / cell.cpu.max)
                          : fmt::format("{}: does not keep real time {}, {:.3g} times too slow", cost, where, cell.cpu.max);
}

}  // namespace

std::string no_advice_if_interrupted(const StudyGoal& goal) {
  return fmt::format("no advice on {}: the study was interrupted, and what it has not measured may be better or cheaper",
                     goal.text);
}

Result<StudyGoal> parse_goal(std::string_view text) {
  StudyGoal goal;
  goal.text = std::string(text);
  const std::string expected = fmt::format(
      "\"{}\" is not an error to reach; write such as \"1 % force\", \"5 % energy\" or \"10 um position\"", text);
  const std::size_t blank = text.rfind(' ');
  if (blank == std::string_view::npos) return Failure(expected);
  const std::string_view wanted = text.substr(blank + 1), number = text.substr(0, blank);
  bool known = false;
  for (const StudyQuantity q : kStudyQuantities) {
    if (wanted != name_of(q)) continue;
    goal.quantity = q;
    known = true;
  }
  if (!known) return Failure(expected);
  Result<double> most = parse_si(number, Dimension::ratio);
  if (!most && goal.quantity == StudyQuantity::position) {
    most = parse_si(number, Dimension::length);
    goal.is_share = false;
  }
  if (!most) return Failure(expected + ": " + most.error());
  goal.most = *most;
  if (!(goal.most > 0)) return Failure(expected + ": it must be above 0");
  return goal;
}

StudyAdvice advise(const StudyRecord& study, const StudyGoal& goal) {
  const bool of_motion = goal.quantity == StudyQuantity::position && goal.is_share;
  const double most = of_motion ? goal.most * study.reference.scale[goal.quantity] : goal.most;
  StudyAdvice advice;
  if (study.interrupted) {
    advice.text = no_advice_if_interrupted(goal);
    return advice;
  }
  if (!(study.reference.estimate[goal.quantity] <= most)) {
    advice.text = fmt::format("cannot tell what meets {}: the reference itself may be off by {}", goal.text,
                              amount(goal, study.reference.estimate[goal.quantity], study));
    return advice;
  }
  const StudyCell* least = nullptr;
  for (const StudyCell& cell : study.cells) {
    if (cell.state != StudyCell::State::measured) continue;
    if (least == nullptr || cell.error[goal.quantity] < least->error[goal.quantity]) least = &cell;
    if (!(cell.error[goal.quantity] <= most)) continue;
    if (advice.cell == nullptr || cell.cpu.median < advice.cell->cpu.median) advice.cell = &cell;
  }
  if (advice.cell == nullptr) {
    advice.text = fmt::format("none meets {}", goal.text);
    if (least != nullptr)
      advice.text +=
          fmt::format("; the least error is {}: {}", amount(goal, least->error[goal.quantity], study), cell_name(*least));
    return advice;
  }
  advice.keeps_real_time = advice.cell->cpu.max < 1;
  advice.text = fmt::format("cheapest for {}: {}: error {}, {}", goal.text, cell_name(*advice.cell),
                            amount(goal, advice.cell->error[goal.quantity], study), real_time(*advice.cell));
  if (const std::string warning = warning_of(study.machines); !warning.empty()) advice.text += '\n' + warning;
  return advice;
}

std::vector<FolderFile> study_files(const Scenario& scenario, const StudyRecord& study, const std::string& reproduce) {
  std::vector<FolderFile> files{
      {kStudyFile, study_json(study)}, {"study.csv", study_csv(study)}, {"resolved.toml", scenario.resolved_toml}};
  for (const StudyQuantity q : kStudyQuantities)
    files.push_back({fmt::format("{}-error.svg", name_of(q)), study_svg(study, q)});
  files.push_back({kReportFile, study_page(study, reproduce)});
  return files;
}

std::string write_study_folder(const std::string& folder, const Scenario& scenario, const StudyRecord& study,
                               const std::string& reproduce) {
  return write_folder(folder, study_files(scenario, study, reproduce));
}

}  // namespace evenstep
