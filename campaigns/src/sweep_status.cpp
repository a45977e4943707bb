#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>

#include "evenstep/campaigns/sweep.h"
#include "part_lines.h"
#include "sweep_lines.h"

namespace evenstep {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;
constexpr std::string_view kPartial = ".partial";

/// The files of a sweep in a folder: its shards, or the one file of a sweep without shards. An ended one hides a partial
/// one.
std::vector<std::string> part_files(const std::string& folder) {
  std::map<std::string, std::string> shards, whole;  // by the name that they have at the end
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string path = entry.path().string();
    std::string name = entry.path().filename().string();
    const bool partial = name.ends_with(kPartial);
    if (partial) name.resize(name.size() - kPartial.size());
    if (!name.ends_with(".jsonl") || !name.starts_with("sweep")) continue;
    std::string& place = (name == "sweep.jsonl" ? whole : shards)[name];
    if (place.empty() || !partial) place = path;
  }
  std::vector<std::string> files;
  for (const auto& [name, path] : shards.empty() ? whole : shards) files.push_back(path);
  return files;
}

/// When a file was made and last written, in seconds; 0 where the file system does not know.
struct FileTimes {
  double made = 0, written = 0;
};
FileTimes times_of(const std::string& path) {
  struct statx file {};
  if (::statx(AT_FDCWD, path.c_str(), 0, STATX_BTIME | STATX_MTIME, &file) != 0 || (file.stx_mask & STATX_BTIME) == 0)
    return {};
  const auto seconds = [](const statx_timestamp& time) { return static_cast<double>(time.tv_sec) + 1e-9 * time.tv_nsec; };
  return {seconds(file.stx_btime), seconds(file.stx_mtime)};
}

class Status {
 public:
  explicit Status(SweepStatus& status) : status_(status) {}

  /// Throws std::runtime_error with the place.
  void read(const std::string& path);
  void end();

 private:
  void read_header(const std::string& line);
  bool next(internal::PartLines& lines, bool partial) const;

  SweepStatus& status_;
  std::optional<SweepSummarizer> summarizer_;
  std::string common_;
  double begin_ = std::numeric_limits<double>::infinity(), end_ = 0;
};

void Status::read_header(const std::string& line) {
  const internal::PartHeader header = internal::read_part_header(line);
  if (!summarizer_) {
    status_.header = internal::read_header_line(line).header;
    summarizer_.emplace(status_.header);
    common_ = header.common;
  }
  if (header.common != common_) throw std::runtime_error("is of another sweep than the files before it; remove it");
  status_.parts.push_back({header.shard, 0, 0, 0, false});
}

/// What is being written may end within a line.
bool Status::next(internal::PartLines& lines, bool partial) const {
  try {
    return lines.next();
  } catch (const std::runtime_error&) {
    if (partial) return false;
    throw;
  }
}

void Status::read(const std::string& path) {
  const bool partial = path.ends_with(kPartial);
  internal::PartLines lines(path, kPiece);
  try {
    if (!next(lines, partial)) return;
    read_header(lines.line());
    SweepStatus::Part& part = status_.parts.back();
    part.ended = !partial;
    part.points = (status_.header.points() - part.shard.index + part.shard.of) / part.shard.of;
    while (next(lines, partial)) {
      const SweepPoint point = internal::read_point_line(status_.header, lines.line());
      summarizer_->add(point);
      ++part.done;
      part.failed += internal::failed(point) ? 1 : 0;
    }
    const FileTimes times = times_of(path);
    begin_ = std::min(begin_, times.made);
    end_ = std::max(end_, times.written);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}:{}:1: error: the line {}", path, lines.number(), error.what()));
  }
}

void Status::end() {
  status_.summary = summarizer_->summary();
  status_.summary.find.reset();  // which takes all points
  std::sort(status_.parts.begin(), status_.parts.end(),
            [](const SweepStatus::Part& a, const SweepStatus::Part& b) { return a.shard.index < b.shard.index; });
  if (begin_ > 0 && end_ > begin_) status_.seconds = end_ - begin_;
}

}  // namespace

Result<SweepStatus> sweep_status(const std::string& folder) {
  SweepStatus result;
  try {
    Status status(result);
    for (const std::string& path : part_files(folder)) status.read(path);
    if (result.parts.empty())
      return Failure(fmt::format("'{}' has no part of a sweep, sweep-I-of-N.jsonl; give the folder of --out", folder));
    status.end();
  } catch (const std::exception& error) {
    return Failure(std::string(error.what()));
  }
  return result;
}

}  // namespace evenstep
