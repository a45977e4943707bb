#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>

#include "format.h"
#include "json.h"
#include "lines.h"

namespace evenstep {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;
constexpr std::string_view kPartial = ".partial";

/// The files of one kind in a folder: its shards, or the single file of what has no shards. A finished one hides a partial
/// one.
std::vector<std::string> part_files(const std::string& folder, std::string_view kind) {
  if (!std::filesystem::is_directory(folder))
    throw std::runtime_error(fmt::format("there is no folder '{}'; give that of --out", folder));
  std::map<std::string, std::string> shards, whole;  // by the name that they have at the end
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string path = entry.path().string();
    std::string name = entry.path().filename().string();
    const bool partial = name.ends_with(kPartial);
    if (partial) name.resize(name.size() - kPartial.size());
    if (!name.ends_with(".jsonl") || !name.starts_with(kind)) continue;
    std::string& place = (name == fmt::format("{}.jsonl", kind) ? whole : shards)[name];
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
  Status(PartsStatus& status, std::unique_ptr<internal::PartFormat>& format) : status_(status), format_(format) {}

  /// Throws std::runtime_error with the place.
  void read(const std::string& path);
  void end();

 private:
  void read_header(const std::string& line);
  bool next(internal::PartLines& lines, bool partial) const;

  PartsStatus& status_;
  std::unique_ptr<internal::PartFormat>& format_;
  std::string common_;
  double begin_ = std::numeric_limits<double>::infinity(), end_ = 0;
};

void Status::read_header(const std::string& line) {
  const internal::PartHeader header = internal::read_part_header(line);
  if (!format_) {
    format_ = internal::format_of(line);
    status_.items = format_->items();
    common_ = header.common;
  }
  if (header.common != common_)
    throw std::runtime_error(fmt::format("is of another {} than the files before it; remove it", header.kind));
  if (!status_.parts.empty() && status_.parts.front().shard.of != header.shard.of)
    throw std::runtime_error(
        fmt::format("is of {} shards, but the files before it are of {}; remove those of one of the two", header.shard.of,
                    status_.parts.front().shard.of));
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
    PartsStatus::Part& part = status_.parts.back();
    part.ended = !partial;
    part.items = (status_.items - part.shard.index + part.shard.of) / part.shard.of;
    while (next(lines, partial)) {
      const std::unique_ptr<internal::PartItem> item = format_->read(lines.line());
      format_->take(*item);
      ++part.done;
      ++status_.done;
      part.failed += item->failed ? 1 : 0;
    }
    const FileTimes times = times_of(path);
    begin_ = std::min(begin_, times.made);
    end_ = std::max(end_, times.written);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}:{}:1: error: the line {}", path, lines.number(), error.what()));
  }
}

void Status::end() {
  std::sort(status_.parts.begin(), status_.parts.end(),
            [](const PartsStatus::Part& a, const PartsStatus::Part& b) { return a.shard.index < b.shard.index; });
  if (begin_ > 0 && end_ > begin_) status_.seconds = end_ - begin_;
}

}  // namespace

void internal::read_status(const std::string& folder, std::string_view kind, PartsStatus& result,
                           std::unique_ptr<PartFormat>& format) {
  Status status(result, format);
  for (const std::string& path : part_files(folder, kind)) status.read(path);
  if (result.parts.empty())
    throw std::runtime_error(
        fmt::format("'{0}' has no part of a {1}, {1}-I-of-N.jsonl; give the folder of --out", folder, kind));
  status.end();
}

Result<PartsStatus> parts_status(const std::string& folder, std::string_view kind) {
  PartsStatus result;
  std::unique_ptr<internal::PartFormat> format;
  try {
    internal::read_status(folder, kind, result, format);
  } catch (const std::exception& error) {
    return Failure(std::string(error.what()));
  }
  return result;
}

}  // namespace evenstep
