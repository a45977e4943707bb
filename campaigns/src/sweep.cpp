#include "evenstep/campaigns/sweep.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <stdexcept>

#include "evenstep/format/reader.h"
#include "evenstep/scheduler/parallel_for.h"
#include "sweep_file.h"
#include "sweep_lines.h"
#include "sweep_points.h"

namespace evenstep {
namespace {

using internal::SweepFile;
using internal::SweepPoints;

/// The part of a sweep that this process runs, from the lines kept in the file to its end.
class Part {
 public:
  Part(const SweepHeader& header, SweepShard shard) : header_(header), shard_(shard), summarizer_(header) {}

  std::int64_t count() const { return (header_.points() - shard_.index + shard_.of) / shard_.of; }
  std::int64_t point(std::int64_t n) const { return n * shard_.of + shard_.index - 1; }
  std::int64_t done() const { return done_; }
  std::int64_t failures() const { return failures_; }
  SweepSummary summary() const { return summarizer_.summary(); }
  bool complete() const { return done() == count() || (header_.stop_after && failures_ >= *header_.stop_after); }

  /// Adds the next line. Throws if it is not that.
  void add(const std::string& line) {
    const SweepPoint next = internal::read_point_line(header_, line);
    if (next.index != point(done_))
      throw std::runtime_error(fmt::format("is of point {}, where {} is due", next.index, point(done_)));
    ++done_;
    failures_ += internal::failed(next) ? 1 : 0;
    summarizer_.add(next);
  }

  /// Whether the first line of a file is that of this part. Throws if the line is damaged.
  bool is_ours(const std::string& line, const std::string& file) const {
    try {
      const internal::HeaderLine there = internal::read_header_line(line);
      return internal::same_sweep(there.header, header_) && there.shard.index == shard_.index && there.shard.of == shard_.of;
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{}:1: error: the line {}; remove the file", file, error.what()));
    }
  }

  /// Takes over the lines of an earlier process. Throws, with the line, if one is wrong.
  void keep(const std::vector<std::string>& lines, const std::string& file) {
    if (lines.empty()) return;
    if (!is_ours(lines.front(), file)) {
      throw std::runtime_error(
          fmt::format("{}:1: error: is of another sweep: the scenario, its overrides, the shard or this program "
                      "differ; remove it, or give another place with --out",
                      file));
    }
    for (std::size_t i = 1; i < lines.size(); ++i) {
      try {
        if (complete()) throw std::runtime_error("comes after the last point");
        add(lines[i]);
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(fmt::format("{}:{}: error: the line {}; remove the file", file, i + 1, error.what()));
      }
    }
  }

 private:
  const SweepHeader& header_;
  SweepShard shard_;
  SweepSummarizer summarizer_;
  std::int64_t done_ = 0, failures_ = 0;
};

std::string file_of(const SweepOptions& options) {
  const std::string name =
      options.shard.of == 1 ? "sweep.jsonl" : fmt::format("sweep-{}-of-{}.jsonl", options.shard.index, options.shard.of);
  return (std::filesystem::path(options.folder) / name).string();
}

/// Returns false if it was interrupted.
bool run_rest(const SweepPoints& points, const SweepOptions& options, Part& part, SweepFile& file) {
  const std::int64_t first = part.done();
  bool interrupted = false;
  const auto show = [&] {
    if (options.progress) options.progress(part.done(), part.count(), part.failures());
  };
  show();
  ordered_for(
      static_cast<std::size_t>(part.count() - first), options.threads,
      [&](std::size_t n) { return points.run(part.point(first + static_cast<std::int64_t>(n)), options.interrupted); },
      [&](std::size_t, const std::string& line) {
        interrupted = line.empty();
        if (interrupted) return false;
        file.append(line);
        part.add(line);
        show();
        return !part.complete();
      });
  return !interrupted;
}

/// Throws std::runtime_error.
void run_part(const SweepPoints& points, const SweepOptions& options, SweepOutcome& outcome) {
  outcome.header = points.header();
  Part part(outcome.header, options.shard);
  const bool ended =
      options.resume && !std::filesystem::exists(outcome.file + ".partial") && std::filesystem::exists(outcome.file);
  if (ended) {
    part.keep(internal::read_lines(outcome.file, false), outcome.file);
    if (!part.complete()) throw std::runtime_error(fmt::format("'{}' is not complete; remove it", outcome.file));
  } else {
    SweepFile file(outcome.file, options.resume);
    part.keep(file.kept(), file.partial());
    if (file.kept().empty()) file.append(internal::header_line(points.header(), options.shard));
    if (!part.complete() && !run_rest(points, options, part, file)) {
      outcome.exit = ExitCode::interrupted;
      outcome.file = file.partial();
    } else {
      file.finish();
    }
  }
  outcome.summary = part.summary();
  if (outcome.exit == ExitCode::interrupted) return;
  if (options.shard.of > 1 && outcome.summary.find) {
    outcome.summary.find
        .reset();  // a shard knows only its own points; only the merge can tell what is found and whether that passes
    return;
  }
  outcome.exit = internal::exit_of(outcome.summary);
}

}  // namespace

std::vector<Diagnostic> check_sweep(const std::string& path, const ReadOptions& options) {
  std::vector<Diagnostic> errors;
  const SweepPoints points(path, options, errors);
  return errors.empty() ? points.check() : errors;
}

SweepOutcome run_sweep(const std::string& path, const SweepOptions& options) {
  SweepOutcome outcome;
  outcome.file = file_of(options);
  SweepPoints points(path, {options.set, std::nullopt, options.registry}, outcome.errors);
  if (outcome.errors.empty() && options.stop_after) {
    if (points.header().find)
      outcome.errors.push_back({"--stop-after", 0, 0, "does not go with [sweep.find], which must know every point"});
    points.header().stop_after = options.stop_after;
  }
  if (outcome.errors.empty()) outcome.errors = points.check();
  if (outcome.errors.empty() && options.shard.of > points.header().points())
    outcome.errors.push_back({"--shard", 0, 0, fmt::format("there are only {} points to share", points.header().points())});
  if (!outcome.errors.empty()) {
    outcome.exit = ExitCode::usage;
    return outcome;
  }
  try {
    run_part(points, options, outcome);
  } catch (const std::exception& error) {
    outcome.failure = error.what();
    outcome.exit = ExitCode::run_failed;
  }
  return outcome;
}

}  // namespace evenstep
