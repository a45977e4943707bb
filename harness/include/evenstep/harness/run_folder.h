#pragma once
/// The run folder: written beside its place and renamed into it, so that nobody ever sees half of one. An older run folder
/// in its place is replaced; any other folder is left alone and the write is refused.

#include <string>
#include <vector>

#include "evenstep/harness/run.h"

namespace evenstep {

inline constexpr const char* kSummaryFile = "summary.json";  ///< what makes a folder a run folder
inline constexpr const char* kStudyFile = "study.json";      ///< what makes it one of `evenstep study`

/// Whether `folder` can be written, before a long run is spent on it: absent, empty, or with a file of this name. Empty, or
/// the reason with the remedy.
std::string run_folder_objection(const std::string& folder, const std::string& its_file = kSummaryFile);
/// Empty, or what went wrong.
std::string write_run_folder(const std::string& folder, const Scenario& scenario, const RunOutcome& outcome,
                             const std::string& reproduce);

struct FolderFile {
  std::string name;
  std::string content;
};
/// Any such folder: an older one that has a file with the name of the first is replaced.
std::string write_folder(const std::string& folder, const std::vector<FolderFile>& files);

/// The text of summary.json.
std::string summary_of(const RunOutcome& outcome);

}  // namespace evenstep
