#include "evenstep/campaigns/shrink.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <filesystem>

#include "evenstep/apps/shell.h"
#include "src/commands.h"
#include "src/progress.h"

namespace evenstep::app {
namespace {

struct ShrinkArguments {
  std::string program;
  std::string file;
  std::vector<std::string> set;
  std::optional<std::uint64_t> seed;
  std::optional<std::int64_t> expect;
  std::int64_t max_runs = 2000;
  std::string out;
};

constexpr std::size_t kMostShown = 20;

std::string number(const ExpectationResult& result) {
  return fmt::format("{:.6g}{}{}", result.value.value_or(0), result.unit.empty() ? "" : " ", result.unit);
}

void print_shrunk(const ShrinkOutcome& outcome, const ShrinkArguments& arguments) {
  fmt::print("{} {} fails: {} before, {} now\n", outcome.before.signal, outcome.before.metric, number(outcome.before),
             number(outcome.after));
  fmt::print("{} of {} lengths are not nominal, {:.6g} s of {:.6g} s; {} runs\n", outcome.perturbations.size(),
             outcome.perturbations_before, seconds(outcome.duration), seconds(outcome.duration_before), outcome.runs);
  for (std::size_t i = 0; i < std::min(outcome.perturbations.size(), kMostShown); ++i)
    fmt::print("  {}\n", text(outcome.perturbations[i]));
  if (outcome.perturbations.size() > kMostShown) fmt::print("  and {} more\n", outcome.perturbations.size() - kMostShown);
  if (!outcome.minimal)
    fmt::print("not the smallest: the search ended after {} runs; --max-runs allows more\n", arguments.max_runs);
  fmt::print("again: {} run {}\n", arguments.program, shell_file(outcome.file));
}

ExitCode shrink(const ShrinkArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  ShrinkOptions options;
  options.set = arguments.set;
  options.registry = registry;
  options.seed = arguments.seed;
  options.expect_line = arguments.expect;
  options.max_runs = arguments.max_runs;
  options.folder = arguments.out.empty() ? (default_place() / "shrunk").string() : arguments.out;
  options.interrupted = &interrupted;
  ShrinkOutcome outcome;
  {
    CountProgress progress(isatty(STDERR_FILENO));
    options.progress = [&](std::int64_t runs, std::size_t left) {
      progress.update(runs, 0, fmt::format("{} lengths are left", left));
    };
    outcome = shrink_scenario(arguments.file, options);
  }
  if (outcome.exit == ExitCode::interrupted) spdlog::error("interrupted; nothing was written");
  print(outcome.errors);
  if (!outcome.failure.empty()) spdlog::error("{}: error: {}", arguments.file, outcome.failure);
  if (outcome.exit == ExitCode::pass) print_shrunk(outcome, arguments);
  return outcome.exit;
}

}  // namespace

void add_shrink(Commands& commands) {
  auto [command, arguments] =
      commands.add<ShrinkArguments>("shrink", "from a scenario that fails to the smallest timing that still fails", shrink);
  arguments.program = commands.program();
  command.operand("scenario", arguments.file, "a scenario file that fails");
  command.repeated("--set", arguments.set, "path=value, overrides the file");
  command.option("--seed", arguments.seed, "instead of [run] seed");
  command.option("--expect", arguments.expect, "the line of the expectation; default: the first that fails");
  command.option("--max-runs", arguments.max_runs, Range{1, 1'000'000'000}, "runs to spend; default 2000");
  command.option("--out,-o", arguments.out, "folder for <name>-shrunk.toml and .csv; default runs/shrunk");
}

}  // namespace evenstep::app
