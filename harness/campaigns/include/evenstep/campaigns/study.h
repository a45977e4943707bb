#pragma once
/// `evenstep study`: computes the tissue of a scenario with every solver, method and step, and compares the results with a
/// reference. The tools move like the hands of the scenario, with the scene's steps on an even schedule: there is no timing
/// model, no device and no map. docs/forces/study.md has definitions and measured tables.

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/reports/study_record.h"
#include "evenstep/text/quantity.h"

namespace evenstep {

struct StudyControl {
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(double fraction)> progress;
};

/// Computes every cell of [study], including those that fail. The errors are reproducible, the costs are not. Throws
/// RunFailure if there is no reference (no method can compute the scene), and std::invalid_argument if the scene is not a
/// tissue. If it is interrupted, it returns the cells so far.
StudyRecord run_study(const Scenario& scenario, const StudyControl& control = {});

/// A goal such as "1 % force", "10 um position" or "5 % energy". For the position, a share is relative to the rms
/// displacement.
struct StudyGoal {
  std::string text;
  StudyQuantity quantity = StudyQuantity::force;
  double most = 0;  ///< SI, or a share
  bool is_share = true;
};
Result<StudyGoal> parse_goal(std::string_view text);

/// The cheapest cell (median CPU time) that meets the goal, and whether it keeps real time here. Costs of several machines
/// (StudyRecord::machines) are compared all the same, and the text ends with a line that warns of it and names them.
struct StudyAdvice {
  const StudyCell* cell = nullptr;  ///< a cell of the record; nullptr: none meets the goal
  bool keeps_real_time = false;     ///< even the slowest repeat took less than a CPU second per simulated second
  std::string text;                 ///< a sentence or two
};
/// An interrupted study has none, and the text says why: what it has not measured may be better or cheaper.
StudyAdvice advise(const StudyRecord& study, const StudyGoal& goal);
/// That text.
std::string no_advice_if_interrupted(const StudyGoal& goal);

/// The files of its folder, study.json first.
std::vector<FolderFile> study_files(const Scenario& scenario, const StudyRecord& study, const std::string& reproduce);

/// Writes study.json, study.csv, a figure per quantity and resolved.toml, all or nothing. Returns what went wrong; empty if
/// nothing did.
std::string write_study_folder(const std::string& folder, const Scenario& scenario, const StudyRecord& study,
                               const std::string& reproduce);

}  // namespace evenstep
