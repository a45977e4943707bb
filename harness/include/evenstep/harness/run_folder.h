#pragma once
/// The run folder. It is written under another name beside its final place and then renamed, so an incomplete one is never
/// seen. An older run folder in its place is replaced; any other folder is left alone, and writing is refused.

#include <string>
#include <vector>

#include "evenstep/harness/run.h"

namespace evenstep {

inline constexpr const char* kSummaryFile = "summary.json";  ///< a folder with this file is a run folder
inline constexpr const char* kReportFile = "report.html";    ///< for people: of a run, a sweep or a study
inline constexpr const char* kStudyFile = "study.json";      ///< a folder with this file is one of `evenstep study`
inline constexpr const char* kStudyFigure = "error-against-cost.svg";  ///< of a study of the felt force, in its folder

struct FolderFile {
  std::string name;
  std::string content;
};

/// Why `folder` cannot be written, with the remedy; empty if it can, because it does not exist, is empty, or contains
/// `its_file`. To be called before a long run, not after it.
std::string run_folder_objection(const std::string& folder, const std::string& its_file = kSummaryFile);
/// With the figure of a study of the felt force, if the folder `<folder>-study` beside it has one of this very scenario.
/// Returns what went wrong; empty if nothing did.
std::string write_run_folder(const std::string& folder, const Scenario& scenario, const RunOutcome& outcome,
                             const std::string& reproduce);

/// Writes a folder with any files. An older folder is replaced if it contains a file with the name of the first one.
std::string write_folder(const std::string& folder, const std::vector<FolderFile>& files);

/// Writes one file under another name, and renames it. Returns what went wrong; empty if nothing did.
std::string replace_file(const std::string& path, const std::string& content);

/// The files of a run folder, summary.json first; its figures.
std::vector<FolderFile> data_files(const Scenario& scenario, const RunOutcome& outcome, const std::string& reproduce);
std::vector<FolderFile> figures(const Scenario& scenario, const RunOutcome& outcome);

/// Digest of everything in the resolved scenario that its runs depend on: not of its name, [study], [sweep] and [[expect]].
std::uint64_t subject_of(const Scenario& scenario);

/// The text of summary.json.
std::string summary_of(const RunOutcome& outcome);

}  // namespace evenstep
