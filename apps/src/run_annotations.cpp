#include "run_annotations.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/reports/writers.h"
#include "output.h"

namespace evenstep::app {
namespace {

using Verdict = ExpectationResult::Verdict;

bool holds(const ExpectationResult& result) { return result.verdict <= Verdict::pass; }

/// Why a run has no verdict on its expectations; empty if it has one.
std::string stopped_by(const RunOutcome& outcome) {
  if (!outcome.failure.empty() && outcome.exit != ExitCode::pass)
    return outcome.failure + (outcome.remedy.empty() ? "" : "; remedy: " + outcome.remedy);
  if (!outcome.repeat_difference.empty()) return "not reproducible: " + outcome.repeat_difference;
  return "";
}

}  // namespace

void annotate_run(const std::string& file, const RunOutcome& outcome, std::string_view words, const std::string& again) {
  const AnnotationLevel level = outcome.exit == ExitCode::pass ? AnnotationLevel::warning : AnnotationLevel::error;
  const std::string ending = outcome.exit == ExitCode::pass ? "" : "\nagain: " + again;
  for (const ExpectationResult& result : outcome.results) {
    if (holds(result)) continue;
    const std::string because = result.because.empty() ? "" : "\nbecause: " + result.because;
    annotate(level, {result.file, result.line, result.column}, "evenstep: " + outcome.record.scenario,
             failure_message(result) + because + ending);
  }
  std::string stop = stopped_by(outcome);
  if (stop.empty() && outcome.verdict == RunVerdict::none) stop = words;
  if (!stop.empty()) annotate(level, {file, 0, 0}, "evenstep: " + outcome.record.scenario, stop + ending);
}

SummaryRow summary_row(const std::string& file, const RunOutcome& outcome, std::string_view words) {
  const auto failed = std::find_if_not(outcome.results.begin(), outcome.results.end(), holds);
  std::string note = stopped_by(outcome);
  if (note.empty() && failed != outcome.results.end())
    note = fmt::format("{}:{}: {}", failed->file, failed->line, failure_message(*failed));
  else if (note.empty())
    note = fmt::format("{} expectations", outcome.results.size());
  return {file, std::string(words), note};
}

}  // namespace evenstep::app
