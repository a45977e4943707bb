#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "evenstep/reports/run_failure.h"
#include "evenstep/scheduler/parallel_for.h"
#include "file.h"
#include "format.h"
#include "json.h"
#include "lines.h"

namespace evenstep::internal {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;

/// The part of a campaign that this process does, from the lines kept in the file to its end.
class Part {
 public:
  Part(PartFormat& format, Shard shard) : format_(format), shard_(shard) {}

  std::int64_t count() const { return (format_.items() - shard_.index + shard_.of) / shard_.of; }
  std::int64_t item(std::int64_t n) const { return n * shard_.of + shard_.index - 1; }
  std::int64_t done() const { return done_; }
  std::int64_t failures() const { return failures_; }
  bool complete() const { return done_ == count() || (format_.stop_after() && failures_ >= *format_.stop_after()); }

  /// Adds a line. Throws if it is not the next one.
  void add(const std::string& line) {
    const std::unique_ptr<PartItem> next = format_.read(line);
    if (next->index != item(done_))
      throw std::runtime_error(fmt::format("is of point {}, where {} is due", next->index, item(done_)));
    ++done_;
    failures_ += next->failed ? 1 : 0;
    format_.take(*next);
  }

  /// Takes over the next line of an earlier process; `number` counts from 1. Throws, with the line, if it is wrong; `remedy`
  /// says what to do about a file of other work.
  void keep(const std::string& line, std::int64_t number, const std::string& file, const char* remedy) {
    if (number == 1) {
      if (is_ours(line, file)) return;
      throw std::runtime_error(
          fmt::format("{}:1: error: is of another {}: the scenario, its overrides, the shard or this program differ; {}",
                      file, read_part_header(format_.header_line(shard_)).kind, remedy));
    }
    try {
      if (complete()) throw std::runtime_error("comes after the last point");
      add(line);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{}:{}: error: the line {}; remove the file", file, number, error.what()));
    }
  }
  /// The same for all lines of a file that is complete, a piece of it at a time.
  void keep_all(const std::string& file, const char* remedy) {
    PartLines lines(file, kPiece);
    const auto next = [&] {
      try {
        return lines.next();
      } catch (const std::runtime_error& error) {
        throw std::runtime_error(fmt::format("{}:{}: error: the line {}", file, lines.number(), error.what()));
      }
    };
    while (next()) keep(lines.line(), lines.number(), file, remedy);
    if (!complete()) throw std::runtime_error(fmt::format("'{}' is not complete; remove it", file));
  }

 private:
  /// Whether the first line of a file is that of this part. Throws if the line is damaged.
  bool is_ours(const std::string& line, const std::string& file) const {
    try {
      const Shard there = read_part_header(line).shard;
      return same_campaign(line, format_.header_line(shard_)) && there.index == shard_.index && there.of == shard_.of;
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{}:1: error: the line {}; remove the file", file, error.what()));
    }
  }

  PartFormat& format_;
  Shard shard_;
  std::int64_t done_ = 0, failures_ = 0;
};

/// Returns false if it was interrupted.
bool run_rest(const RunItem& run, const PartOptions& options, Part& part, PartFile& file) {
  const std::int64_t first = part.done();
  bool interrupted = false;
  const auto show = [&] {
    if (options.progress) options.progress(part.done(), part.count(), part.failures());
  };
  show();
  ordered_for(
      static_cast<std::size_t>(part.count() - first), options.threads,
      [&](std::size_t n) { return run(part.item(first + static_cast<std::int64_t>(n))); },
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

std::string file_of(std::string_view kind, const PartOptions& options) {
  const Shard shard = options.shard;
  const std::string name =
      shard.of == 1 ? fmt::format("{}.jsonl", kind) : fmt::format("{}-{}-of-{}.jsonl", kind, shard.index, shard.of);
  return (std::filesystem::path(options.folder) / name).string();
}

/// Whether a finished file has all points. One that has not (somebody has cut it off afterwards, or it stopped early) gets
/// the name of an unfinished one, if it is of this campaign, so that it is gone on with. Throws std::runtime_error.
bool has_all_points(Part& part, const std::string& file, const char* remedy) {
  std::ifstream lines(file, std::ios::binary);
  std::string header;
  std::getline(lines, header);
  if (std::count(std::istreambuf_iterator<char>(lines), {}, '\n') >= part.count()) return true;
  part.keep(header, 1, file, remedy);
  std::filesystem::rename(file, PartFile::partial_of(file));
  return false;
}

/// Throws std::runtime_error.
void run_or_keep(PartFormat& format, const RunItem& run, const PartOptions& options, PartOutcome& outcome) {
  Part part(format, options.shard);
  outcome.items = part.count();
  constexpr const char* kElsewhere = "remove it, or give another place with --out";
  if (!options.complete_file.empty()) {
    outcome.file = options.complete_file;
    part.keep_all(outcome.file, "its results need all of these as they were for the shards");
  } else if (options.resume && !std::filesystem::exists(PartFile::partial_of(outcome.file)) &&
             std::filesystem::exists(outcome.file) && has_all_points(part, outcome.file, kElsewhere)) {
    part.keep_all(outcome.file, kElsewhere);
  } else {
    PartFile file(outcome.file, options.resume);
    std::int64_t number = 0;
    for (const std::string& line : file.kept()) part.keep(line, ++number, file.partial(), kElsewhere);
    if (file.kept().empty()) file.append(format.header_line(options.shard));
    if (!part.complete() && !run_rest(run, options, part, file)) {
      outcome.exit = ExitCode::interrupted;
      outcome.file = file.partial();
    } else {
      file.finish();
    }
  }
  outcome.done = part.done();
}

}  // namespace

void run_part(PartFormat& format, const RunItem& run, std::string_view kind, const PartOptions& options,
              PartOutcome& outcome) {
  outcome.file = file_of(kind, options);
  if (options.shard.of > format.items()) {
    outcome.errors.push_back({"--shard", 0, 0, fmt::format("there are only {} points to share", format.items())});
    outcome.exit = ExitCode::usage;
    return;
  }
  try {
    run_or_keep(format, run, options, outcome);
  } catch (const RunFailure& failure) {
    outcome.failure = fmt::format("{}; {}", failure.what(), failure.remedy);
    outcome.exit = ExitCode::run_failed;
  } catch (const std::exception& error) {
    outcome.failure = error.what();
    outcome.exit = ExitCode::run_failed;
  }
}

}  // namespace evenstep::internal
