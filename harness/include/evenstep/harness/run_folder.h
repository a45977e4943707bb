#pragma once
/// The run folder, and other folders and files that replace an older one of their kind. They are written under another name
/// beside their final place and then change places with the older one, so whatever happens meanwhile (a full disk, a killed
/// process), the older one or the new one is there, and whole. What a killed process has left beside it is removed by the
/// next one that writes there. A folder that is not of their kind is left alone, and writing is refused.

#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "evenstep/harness/run.h"
#include "evenstep/reports/writers.h"

namespace evenstep {

inline constexpr const char* kSummaryFile = "summary.json";  ///< a folder with this file is a run folder
inline constexpr const char* kReportFile = "report.html";    ///< for people: of a run, a sweep or a study
inline constexpr const char* kStudyFile = "study.json";      ///< a folder with this file is one of `evenstep study`
inline constexpr const char* kStudyFigure = "error-against-cost.svg";  ///< of a study of the felt force, in its folder

struct FolderFile {
  std::string name;
  std::function<void(std::ostream&)> write;  ///< puts the content into the file

  FolderFile(std::string its_name, std::function<void(std::ostream&)> its_write)
      : name(std::move(its_name)), write(std::move(its_write)) {}
  FolderFile(std::string its_name, std::string content)
      : name(std::move(its_name)), write([text = std::move(content)](std::ostream& out) { out << text; }) {}
};

/// Why `folder` cannot be written, with the remedy; empty if it can, because it does not exist, is empty, or contains
/// `its_file`. To be called before a long run, not after it.
std::string run_folder_objection(const std::string& folder, const std::string& its_file = kSummaryFile);
/// The folder also gets the figure of a study of the felt force, if the folder `<folder>-study` beside it has one of this
/// very scenario. `also` has further files for the folder. Returns what went wrong; empty if nothing did.
std::string write_run_folder(const std::string& folder, const Scenario& scenario, const RunOutcome& outcome,
                             const std::string& reproduce, const std::vector<FolderFile>& also = {});

/// Writes a folder with any files. An older folder is replaced if it contains a file with the name of the first of `files`.
std::string write_folder(const std::string& folder, const std::vector<FolderFile>& files);

/// The files of a run folder, summary.json first; its figures. Scenario and outcome must outlive what they return.
std::vector<FolderFile> data_files(const Scenario& scenario, const RunOutcome& outcome, const std::string& reproduce);
std::vector<FolderFile> figures(const Scenario& scenario, const RunOutcome& outcome);

/// Digest of everything in the resolved scenario that its runs depend on: not of its name, [study], [sweep] and [[expect]].
std::uint64_t subject_of(const Scenario& scenario);

/// The run as JUnit shows it. Errors are runs that broke or gave no answer: a file that cannot be read, a solver that
/// failed, a trace that differed the second time. A run that should have stopped and did not, or that asserts nothing, is a
/// failure.
JunitSuite junit_suite(const RunOutcome& outcome, const std::string& reproduce);

/// The text of summary.json.
std::string summary_of(const RunOutcome& outcome);

}  // namespace evenstep
