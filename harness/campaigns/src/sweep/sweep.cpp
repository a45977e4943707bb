#include "evenstep/campaigns/sweep.h"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "lines.h"
#include "points.h"
#include "src/shards/format.h"

namespace evenstep {
namespace {

/// Of a part of the points: only all together can find the smallest or largest value, or judge the states.
void without_the_whole(SweepSummary& summary) {
  summary.find.reset();
  summary.complete = false;
}

}  // namespace

std::vector<Diagnostic> check_sweep(const std::string& path, const ReadOptions& options) {
  std::vector<Diagnostic> errors;
  const internal::SweepPoints points(path, options, errors);
  return errors.empty() ? points.check() : errors;
}

SweepOutcome run_sweep(const std::string& path, const SweepOptions& options) {
  SweepOutcome outcome;
  internal::SweepPoints points(path, {options.set, std::nullopt, options.registry}, outcome.errors);
  if (outcome.errors.empty() && options.stop_after) {
    if (points.header().find)
      outcome.errors.push_back({"--stop-after", 0, 0, "does not go with [sweep.find], which must know every point"});
    points.header().stop_after = options.stop_after;
  }
  if (outcome.errors.empty()) outcome.errors = points.without_effect(options.set);
  if (outcome.errors.empty()) outcome.errors = points.check();
  if (!outcome.errors.empty()) {
    outcome.exit = ExitCode::usage;
    return outcome;
  }
  internal::SweepParts sweep(points.header());
  internal::run_part(
      sweep, [&](std::int64_t point) { return points.run(point, options.interrupted); }, "sweep", options, outcome);
  outcome.header = sweep.header();
  outcome.summary = sweep.summary();
  if (outcome.exit == ExitCode::interrupted) without_the_whole(outcome.summary);
  if (outcome.exit != ExitCode::pass) return outcome;
  if (options.shard.of > 1 && outcome.summary.find)
    outcome.summary.find.reset();  // a shard knows only its own points; only the merge can tell what is found
  else
    outcome.exit = internal::exit_of(outcome.summary);
  return outcome;
}

SweepOutcome merge_sweep(const std::vector<std::string>& parts, const std::string& out) {
  SweepOutcome outcome;
  std::unique_ptr<internal::PartFormat> format;
  static_cast<PartOutcome&>(outcome) = internal::merge_into(parts, out, format);
  const auto* const sweep = dynamic_cast<const internal::SweepParts*>(format.get());
  if (sweep == nullptr) return outcome;  // there was an error
  outcome.header = sweep->header();
  outcome.summary = sweep->summary();
  if (outcome.exit == ExitCode::pass) outcome.exit = internal::exit_of(outcome.summary);
  return outcome;
}

Result<SweepStatus> sweep_status(const std::string& folder) {
  SweepStatus result;
  std::unique_ptr<internal::PartFormat> format;
  try {
    internal::read_status(folder, "sweep", result, format);
  } catch (const std::exception& error) {
    return Failure(std::string(error.what()));
  }
  const auto* const sweep = dynamic_cast<const internal::SweepParts*>(format.get());
  if (sweep == nullptr) return Failure(fmt::format("'{}' has parts of something else than a sweep", folder));
  result.header = sweep->header();
  result.summary = sweep->summary();
  without_the_whole(result.summary);
  return result;
}

}  // namespace evenstep
