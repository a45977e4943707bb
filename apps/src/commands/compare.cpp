#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <limits>

#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/compare.h"
#include "evenstep/pages/comparison_page.h"
#include "src/commands.h"
#include "src/output.h"

namespace evenstep::app {
namespace {

constexpr std::size_t kRowsShown = 40;

struct CompareArguments {
  std::string program;
  std::string a, b;
  std::vector<std::string> fail_if;
  std::string markdown, html;
  bool all = false, allow_missing = false, json = false;
};

/// The runs of one side; empty, after printing why, if one of its files cannot be read.
std::optional<CompareSide> side_of(const std::string& given) {
  SummariesRead read = read_summaries(given);
  print(read.errors);
  if (!read.errors.empty()) return std::nullopt;
  return CompareSide{given, std::move(read.runs)};
}

std::optional<std::vector<Threshold>> thresholds_of(const std::vector<std::string>& given) {
  std::vector<Threshold> thresholds;
  bool good = true;
  for (const std::string& text : given.empty() ? std::vector<std::string>{"verdict"} : given) {
    const Result<Threshold, Diagnostic> threshold = parse_threshold(text);
    if (threshold)
      thresholds.push_back(*threshold);
    else
      print({threshold.error()}), good = false;
  }
  if (!good) return std::nullopt;
  return thresholds;
}

/// The command that makes the page again.
std::string again(const CompareArguments& arguments) {
  std::string command = fmt::format("{} compare {} {}", arguments.program, shell_file(arguments.a), shell_file(arguments.b));
  for (const std::string& threshold : arguments.fail_if) command += " --fail-if " + shell_word(threshold);
  if (arguments.allow_missing) command += " --allow-missing";
  return command + " --html " + shell_file(arguments.html);
}

ExitCode compare_runs(const CompareArguments& arguments, const std::atomic<bool>&) {
  const std::optional<std::vector<Threshold>> thresholds = thresholds_of(arguments.fail_if);
  const std::optional<CompareSide> a = side_of(arguments.a), b = side_of(arguments.b);
  if (!thresholds || !a || !b) return ExitCode::usage;
  const ComparisonRecord record = compare(*a, *b, *thresholds, arguments.allow_missing);
  if (!arguments.markdown.empty() && !write_text(arguments.markdown, comparison_markdown(record)))
    return ExitCode::run_failed;
  if (!arguments.html.empty() && !write_text(arguments.html, comparison_page(record, again(arguments))))
    return ExitCode::run_failed;
  const bool colour = isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR");
  const std::size_t rows = arguments.all ? std::numeric_limits<std::size_t>::max() : kRowsShown;
  fmt::print("{}", arguments.json ? comparison_json(record) : comparison_text(record, colour, rows, arguments.all));
  for (const ComparedCondition& condition : record.conditions) {
    if (!condition.holds()) annotate(AnnotationLevel::error, {}, "evenstep compare", condition_text(condition));
  }
  return record.holds() ? ExitCode::pass : ExitCode::expectation_failed;
}

}  // namespace

void add_compare(Commands& commands) {
  auto [command, arguments] = commands.add<CompareArguments>(
      "compare", "the figures of two runs, or of two folders of runs: what got worse, and whether by too much",
      compare_runs);
  arguments.program = commands.program();
  command.operand("a", arguments.a, "before: run folder, folder of run folders, summary.json, or what `run --json` printed");
  command.operand("b", arguments.b, "after: the same, of the later run or runs");
  command.repeated("--fail-if", arguments.fail_if,
                   "exit 1 if so: 'latency > +5 %', 'left.force.paper velocity_jump > +0.1 mN', 'worse > +10 %', 'missing', "
                   "'trace', 'verdict' (default)");
  command.flag("--allow-missing", arguments.allow_missing, "a run that only A has breaks no condition");
  command.flag("--all", arguments.all, "every figure that differs, also margins and what the machine's clock says");
  command.option("--markdown", arguments.markdown, "file: the same for a pull request");
  command.option("--html", arguments.html, "file: the same as a page");
  command.flag("--json", arguments.json, "everything for other programs, instead of tables");
}

}  // namespace evenstep::app
