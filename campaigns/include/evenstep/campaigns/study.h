#pragma once
/// `evenstep study`: a tissue's scene under every solver, method and step, against a reference of its own. The tools move as
/// the scenario's hands do, at the scene's steps on an even schedule: no timing model, no device, no map. Definitions and
/// measured tables: docs/study.md.

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "evenstep/text/quantity.h"
#include "evenstep/format/scenario.h"
#include "evenstep/reports/study.h"

namespace evenstep {

struct StudyControl {
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(double fraction)> progress;
};

/// Every cell of [study], whatever becomes of it. The errors are reproducible, the costs are not. Throws RunFailure where
/// there is no reference (a scene that no method takes), std::invalid_argument for what is no tissue. Interrupted: the cells so far.
StudyRecord run_study(const Scenario& scenario, const StudyControl& control = {});

/// "1 % force", "10 um position", "5 % energy". A share of the position's error is one of the rms displacement.
struct StudyGoal {
  std::string text;
  StudyQuantity quantity = StudyQuantity::force;
  double most = 0;  ///< SI, or a share
  bool is_share = true;
};
Parsed<StudyGoal> parse_goal(std::string_view text);

/// The cheapest cell (median CPU time) that meets the goal, and whether it keeps real time here.
struct StudyAdvice {
  const StudyCell* cell = nullptr;  ///< of the record; nullptr: none meets it
  bool keeps_real_time = false;     ///< less than a CPU second per simulated second, in the slowest repeat
  std::string text;                 ///< a sentence or two
};
StudyAdvice advise(const StudyRecord& study, const StudyGoal& goal);

/// study.json, study.csv, a figure per quantity and resolved.toml; whole or not at all. Empty: written.
std::string write_study_folder(const std::string& folder, const Scenario& scenario, const StudyRecord& study);

}  // namespace evenstep
