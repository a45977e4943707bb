#include "lines.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace evenstep::internal {
namespace {

/// Where a folder was given for a file: the files of parts in it.
std::string files_in(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code gone;
  for (std::filesystem::directory_iterator at(folder, gone), end; !gone && at != end; at.increment(gone))
    if (at->path().extension() == ".jsonl") files.push_back(at->path().string());
  std::sort(files.begin(), files.end());
  if (files.empty()) return "it is a folder, and none of its files ends with .jsonl";
  return fmt::format("it is a folder; give the files of the parts in it: {}", fmt::join(files, " "));
}

}  // namespace

bool PartLines::read_piece() {
  buffer_.erase(0, begin_);
  begin_ = 0;
  const std::size_t kept = buffer_.size();
  const int file = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw std::runtime_error(fmt::format("cannot be read: {}", std::strerror(errno)));
  buffer_.resize(kept + piece_);
  ssize_t count = 0;
  do count = ::pread(file, buffer_.data() + kept, piece_, offset_);
  while (count < 0 && errno == EINTR);
  const int error = errno;
  ::close(file);
  if (count < 0) throw std::runtime_error("cannot be read: " + (error == EISDIR ? files_in(path_) : std::strerror(error)));
  buffer_.resize(kept + static_cast<std::size_t>(count));
  offset_ += count;
  return count > 0;
}

bool PartLines::next() {
  ++number_;
  std::size_t end = buffer_.find('\n', begin_);
  while (end == std::string::npos) {
    const std::size_t searched = buffer_.size() - begin_;
    if (read_piece()) {
      end = buffer_.find('\n', searched);
      continue;
    }
    if (buffer_.empty() && number_ > 1) return false;
    throw std::runtime_error("has no end: the file was cut off, or its shard has not ended; --resume ends it");
  }
  line_.assign(buffer_, begin_, end - begin_);
  begin_ = end + 1;
  return true;
}

}  // namespace evenstep::internal
