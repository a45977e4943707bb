#include "evenstep/harness/run_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>
#include <vector>

#include "evenstep/harness/recorded_timing.h"
#include "evenstep/harness/version.h"
#include "evenstep/pages/run_page.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/reports/figures.h"
#include "evenstep/reports/writers.h"
#include "evenstep/time/digest.h"

namespace evenstep {
namespace fs = std::filesystem;
namespace {

/// Strategy and device of figure 2 to 4: those of the first expectation that fails at a known place, or else the live
/// strategy and the first device.
std::pair<std::string, std::string> segment_shown(const Scenario& scenario, const RunOutcome& outcome) {
  for (const ExpectationResult& result : outcome.results) {
    const std::size_t first = result.signal.find('.'), last = result.signal.rfind('.');
    if (result.worst && first != last && !result.signal.starts_with("events."))
      return {result.signal.substr(last + 1), result.signal.substr(0, first)};
  }
  return {name_of(scenario.live), outcome.record.nominal.devices.front().name};
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

fs::path absolute_folder(const std::string& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();  // "runs/x/" means "runs/x"
}

/// Whether the folder may be replaced: it does not exist, is empty, or is one of ours.
bool replaceable(const fs::path& folder, const std::string& its_file) {
  return !fs::exists(folder) || (fs::is_directory(folder) && (fs::is_empty(folder) || fs::exists(folder / its_file)));
}

/// The figure of a study of the felt force of this scenario that is stored beside the run folder; empty if there is none.
std::string stored_study(const std::string& folder, const Scenario& scenario) {
  const fs::path study = absolute_folder(folder).string() + "-study";
  const std::string subject = fmt::format("\"subject\":\"{:016x}\"", subject_of(scenario));
  if (content_of(study / kStudyFile).find(subject) == std::string::npos) return {};
  return content_of(study / kStudyFigure);
}

/// The scenario, and the files that it extends if an expectation of theirs was judged.
std::vector<SourceText> sources_of(const Scenario& scenario, const RunOutcome& outcome) {
  std::vector<SourceText> sources{{scenario.file, content_of(scenario.file)}};
  for (const ExpectationResult& result : outcome.results) {
    const auto is_it = [&](const SourceText& source) { return source.file == result.file; };
    if (std::none_of(sources.begin(), sources.end(), is_it)) sources.push_back({result.file, content_of(result.file)});
  }
  std::erase_if(sources, [](const SourceText& source) { return source.text.empty(); });
  return sources;
}

std::string report_of(const Scenario& scenario, const RunOutcome& outcome, const std::string& reproduce,
                      const std::string& study) {
  const CaseRecord* const case_record = outcome.case_record ? &*outcome.case_record : nullptr;
  return run_page({outcome.record, outcome.metrics, outcome.results, case_record, kVersion, name_of(outcome.verdict),
                   outcome.failure, outcome.exit == ExitCode::pass ? "" : outcome.remedy, reproduce, study,
                   sources_of(scenario, outcome)});
}

void write_file(const fs::path& path, const std::string& content) {
  std::ofstream out(path, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  if (!out) throw std::runtime_error(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
}

}  // namespace

std::vector<FolderFile> data_files(const Scenario& scenario, const RunOutcome& outcome, const std::string& reproduce) {
  const RunRecord& run = outcome.record;
  std::vector<FolderFile> files;
  files.push_back({kSummaryFile, summary_of(outcome)});
  files.push_back({"junit.xml", junit_xml(run, outcome.results, outcome.failure, reproduce)});
  files.push_back({"resolved.toml", scenario.resolved_toml});
  if (outcome.case_record) files.push_back({"cells.csv", cells_csv(*outcome.case_record)});
  if (run.strategies.empty()) return files;  // the run failed before it began
  files.push_back({"series.csv", series_csv(run)});
  files.push_back({"underruns.csv", underruns_csv(run)});
  if (run.keep_rows) {
    const std::vector<std::byte> events = events_bin(run);
    files.push_back({"events.bin", std::string(reinterpret_cast<const char*>(events.data()), events.size())});
  }
  for (const StrategyRecord& strategy : run.strategies) {
    if (strategy.reference) continue;
    files.push_back({"timing.csv", format_timing_csv(recorded_timing(strategy))});
    break;
  }
  return files;
}

std::vector<FolderFile> figures(const Scenario& scenario, const RunOutcome& outcome) {
  const RunRecord& run = outcome.record;
  std::vector<FolderFile> files;
  if (outcome.case_record) files.push_back({"strip.svg", case_strip_svg(*outcome.case_record, scenario.name)});
  if (run.strategies.empty()) return files;
  for (const Nominal::Device& device : run.nominal.devices) {
    files.push_back({fmt::format("figure-1a-{}.svg", device.name), figure_1a_svg(run, device.name, outcome.results)});
    files.push_back({fmt::format("figure-1b-{}.svg", device.name), figure_1b_svg(run, device.name, outcome.results)});
  }
  if (const auto figure = error_over_time_svg(run, outcome.metrics)) files.push_back({"error-over-time.svg", *figure});
  if (const auto figure = latency_over_time_svg(run)) files.push_back({"latency-over-time.svg", *figure});
  const auto [strategy, device] = segment_shown(scenario, outcome);
  files.push_back({"figure-2to4.svg", figure_2to4_svg(run, strategy, device, outcome.results)});
  return files;
}

std::uint64_t subject_of(const Scenario& scenario) {
  std::istringstream lines(scenario.resolved_toml);
  std::uint64_t digest = 0;
  bool counts = false;  // not before the first table: name, because and tags
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first != std::string::npos && line[first] == '[') {
      const std::string name = line.substr(line.find_first_not_of('[', first));
      counts = !(name.starts_with("study") || name.starts_with("sweep") || name.starts_with("expect"));
    }
    if (counts) digest = mix(digest, name_digest(line));
  }
  return digest;
}

std::string summary_of(const RunOutcome& outcome) {
  return summary_json(outcome.record, outcome.metrics, outcome.results, kVersion, name_of(outcome.verdict), outcome.failure);
}

std::string run_folder_objection(const std::string& folder, const std::string& its_file) {
  try {
    const fs::path path = absolute_folder(folder);
    if (!replaceable(path, its_file)) {
      return fmt::format("'{}' exists and is not a run folder (no {} in it); give another place with --out", folder,
                         its_file);
    }
    fs::create_directories(path.parent_path());
    if (::access(path.parent_path().c_str(), W_OK | X_OK) != 0) {
      return fmt::format("cannot write into '{}': {}; give a writable place with --out", path.parent_path().string(),
                         std::strerror(errno));
    }
    return {};
  } catch (const fs::filesystem_error& error) {
    return fmt::format("cannot use '{}' as run folder: {}; give a writable place with --out", folder,
                       error.code().message());
  }
}

std::string write_run_folder(const std::string& folder, const Scenario& scenario, const RunOutcome& outcome,
                             const std::string& reproduce) {
  std::vector<FolderFile> files = data_files(scenario, outcome, reproduce);
  for (FolderFile& figure : figures(scenario, outcome)) files.push_back(std::move(figure));
  const std::string study = stored_study(folder, scenario);
  if (!study.empty()) files.push_back({kStudyFigure, study});
  files.push_back({kReportFile, report_of(scenario, outcome, reproduce, study)});
  return write_folder(folder, files);
}

std::string replace_file(const std::string& path, const std::string& content) {
  const std::string aside = fmt::format("{}.writing-{}", path, ::getpid());
  try {
    write_file(aside, content);
    fs::rename(aside, path);
    return {};
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove(aside, ignored);
    return error.what();
  }
}

std::string write_folder(const std::string& folder, const std::vector<FolderFile>& files) {
  const fs::path path = absolute_folder(folder);
  const fs::path aside = path.parent_path() / fmt::format(".{}.writing-{}", path.filename().string(), ::getpid());
  const fs::path old = path.parent_path() / fmt::format(".{}.old-{}", path.filename().string(), ::getpid());
  try {
    fs::create_directories(aside);
    for (const FolderFile& file : files) write_file(aside / file.name, file.content);
    if (!replaceable(path, files.front().name))
      throw std::runtime_error(fmt::format("'{}' is not a run folder and is left alone", path.string()));
    if (fs::exists(path)) fs::rename(path, old);
    fs::rename(aside, path);
    fs::remove_all(old);
    return {};
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove_all(aside, ignored);
    return error.what();
  }
}

}  // namespace evenstep
