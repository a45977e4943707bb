#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/suffered.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
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
#include "write_folder.h"

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

/// The figure of a study of the felt force of this scenario that is stored beside the run folder; empty if there is none.
std::string stored_study(const std::string& folder, const Scenario& scenario) {
  const fs::path study = internal::absolute_folder(folder).string() + "-study";
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
                   suffered(outcome), outcome.failure, outcome.exit == ExitCode::pass ? "" : outcome.remedy, reproduce,
                   study, sources_of(scenario, outcome)});
}

}  // namespace

std::vector<FolderFile> data_files(const Scenario& scenario, const RunOutcome& outcome, const std::string& reproduce) {
  const RunRecord& run = outcome.record;
  std::vector<FolderFile> files;
  files.push_back({kSummaryFile, summary_of(outcome)});
  const std::array suites{junit_suite(outcome, reproduce)};
  files.push_back({"junit.xml", junit_xml(suites)});
  files.push_back({"resolved.toml", scenario.resolved_toml});
  if (outcome.case_record) files.push_back({"cells.csv", cells_csv(*outcome.case_record)});
  if (run.strategies.empty()) return files;  // the run failed before it began
  files.push_back({"series.csv", [&](std::ostream& out) { series_csv(run, out); }});
  files.push_back({"underruns.csv", [&](std::ostream& out) { underruns_csv(run, out); }});
  if (run.keep_rows) files.push_back({"events.bin", [&](std::ostream& out) { events_bin(run, out); }});
  for (const StrategyRecord& strategy : run.strategies) {
    if (strategy.reference) continue;
    files.push_back({"timing.csv", [&](std::ostream& out) { write_recorded_timing(strategy, out); }});
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
  for (const StrategyRecord& one : run.strategies)
    if (!one.tissue.svg.empty()) files.push_back({"tissue.svg", one.tissue.svg});
  if (!run.drawing_png.empty()) files.push_back({"drawing.png", run.drawing_png});
  const auto [strategy, device] = segment_shown(scenario, outcome);
  files.push_back({"figure-2to4.svg", figure_2to4_svg(run, strategy, device, outcome.results)});
  return files;
}

JunitSuite junit_suite(const RunOutcome& outcome, const std::string& reproduce) {
  using Whole = JunitSuite::Whole;
  const RunRecord& run = outcome.record;
  JunitSuite suite{run.scenario,    run.file,      run.seed, run.clock, run.trace_hash,
                   outcome.results, Whole::silent, {},       reproduce};
  suite.why = outcome.failure;
  if (!outcome.repeat_difference.empty())
    suite.why += fmt::format("{}not reproducible: {}", suite.why.empty() ? "" : "\n", outcome.repeat_difference);
  if (outcome.exit == ExitCode::interrupted && suite.why.empty()) suite.why = "interrupted";
  if (outcome.verdict == RunVerdict::none && suite.why.empty()) suite.why = "no verdict: nothing was asserted";
  if (suite.why.empty()) return suite;
  const bool judged = outcome.exit == ExitCode::expectation_failed && outcome.repeat_difference.empty();
  suite.whole = outcome.exit == ExitCode::pass ? Whole::passed : judged ? Whole::failed : Whole::broken;
  return suite;
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

std::string write_run_folder(const std::string& folder, const Scenario& scenario, const RunOutcome& outcome,
                             const std::string& reproduce, const std::vector<FolderFile>& also) {
  try {
    std::vector<FolderFile> files = data_files(scenario, outcome, reproduce);
    for (FolderFile& figure : figures(scenario, outcome)) files.push_back(std::move(figure));
    const std::string study = stored_study(folder, scenario);
    if (!study.empty()) files.push_back({kStudyFigure, study});
    files.push_back({kReportFile, report_of(scenario, outcome, reproduce, study)});
    files.insert(files.end(), also.begin(), also.end());
    return write_folder(folder, files);
  } catch (const RunFailure& failure) {  // no room for what the measures need
    return failure.what();
  }
}

}  // namespace evenstep
