#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/summary.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/pages/index_page.h"
#include "evenstep/reports/limit_text.h"
#include "evenstep/text/text_file.h"
#include "src/commands.h"

namespace evenstep::app {
namespace fs = std::filesystem;
namespace {

struct IndexArguments {
  std::string program;
  std::string folder;
};

constexpr const char* kIndexFile = "index.html";
constexpr std::int64_t kMostIndexBytes = std::int64_t{64} << 20;

IndexedRun indexed(const RunSummary& run, const fs::path& folder) {
  IndexedRun out{run.name, "", run.scenario, run.file, run.date, run.commit, run.verdict, {}, ""};
  std::error_code error;
  const char* const report = fs::exists(folder / run.name / "report.html", error) ? "report.html" : kSummaryFile;
  out.link = run.name.empty() ? report : run.name + '/' + report;
  for (const ExpectationResult& result : run.expectations) {
    const std::optional<double> margin = relative_margin(result);
    if (!margin || (out.margin && *out.margin <= *margin)) continue;
    out.margin = margin;
    out.margin_of = fmt::format("{} {} {}", result.signal, result.metric, limit_text(result));
  }
  return out;
}

/// Whether there is nothing at this place, or a page of this command.
bool may_be_written(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(file, error))) return true;
  const Result<std::string> there = internal::read_text_file(file.string(), kMostIndexBytes);
  return there && there->find(fmt::format(">{}<", kIndexKind)) != std::string::npos;
}

ExitCode index(const IndexArguments& arguments, const std::atomic<bool>&) {
  const fs::path folder(arguments.folder), file = folder / kIndexFile;
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    print({{arguments.folder, 0, 0, "is no folder; name one with run folders in it, such as runs"}});
    return ExitCode::usage;
  }
  SummariesRead read = read_summaries(arguments.folder);
  print(read.errors);
  if (read.runs.empty()) return ExitCode::usage;
  if (!may_be_written(file)) {
    print({{file.string(), 0, 0, "is no page of `evenstep index`, and is left alone; move it away"}});
    return ExitCode::usage;
  }
  if (fs::exists(folder / kSummaryFile, error)) read.runs.front().name.clear();  // the folder is a run itself
  std::vector<IndexedRun> runs;
  for (const RunSummary& run : read.runs) runs.push_back(indexed(run, folder));
  const std::string again = fmt::format("{} index {}", arguments.program, shell_file(arguments.folder));
  if (!write_text(file.string(), index_page(arguments.folder, runs, again))) return ExitCode::run_failed;
  fmt::print("{} runs: {}\n", runs.size(), file.string());
  return read.errors.empty() ? ExitCode::pass : ExitCode::usage;
}

}  // namespace

void add_index(Commands& commands) {
  auto [command, arguments] = commands.add<IndexArguments>(
      "index", "write index.html into a folder of runs: verdicts, worst margins, trends", index);
  arguments.program = commands.program();
  command.operand("folder", arguments.folder, "folder of run folders, at any depth");
}

}  // namespace evenstep::app
