#pragma once
/// `evenstep study`, [study] error = "felt-force": the error of the force that the hand feels against CPU time, for every
/// strategy, method and step of a scenario, over the time that the run itself judges. Definition:
/// evenstep/reports/felt_study_record.h.

#include <atomic>
#include <functional>
#include <string>

#include "evenstep/campaigns/study.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/reports/felt_study_record.h"

namespace evenstep {

struct FeltStudyControl {
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(double fraction)> progress;
  /// Lines for people, before anything long begins: what it will cost, and what was wrong with a stored reference.
  std::function<void(const std::string& line)> announce;
  /// Folder in which references are kept. Empty: none is read or kept.
  std::string cache_folder;
};

/// Why the scenario cannot have such a study, with the remedy; empty if it can. The study takes devices whose motion is
/// programmed and that play the scheduled force, and at least one strategy that does not know the motion.
std::string felt_study_objection(const Scenario& scenario);

/// Errors are reproducible, costs are not. Throws RunFailure if there is no reference or if a run fails for a reason other
/// than its method and step; std::invalid_argument if felt_study_objection is not empty. If it is interrupted, it returns
/// the points so far.
FeltStudyRecord run_felt_study(const Scenario& scenario, const FeltStudyControl& control = {});

/// The cheapest point that meets a goal such as "1 % force", as a sentence; `found` is false if none does. A share is
/// relative to the rms force. Costs of several machines: as in StudyAdvice.
struct FeltAdvice {
  bool found = false;
  std::string text;
};
FeltAdvice advise(const FeltStudyRecord& study, const StudyGoal& goal);

/// The files of its folder, study.json first.
std::vector<FolderFile> felt_study_files(const Scenario& scenario, const FeltStudyRecord& study,
                                         const std::string& reproduce);

/// Writes study.json, study.csv, error-against-cost.svg and resolved.toml, all or nothing. Returns what went wrong; empty if
/// nothing did.
std::string write_felt_study_folder(const std::string& folder, const Scenario& scenario, const FeltStudyRecord& study,
                                    const std::string& reproduce);

}  // namespace evenstep
