#include "file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "evenstep/text/text_file.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kMostBytes = std::int64_t{1} << 40;

[[noreturn]] void fail(const std::string& doing, const std::string& path) {
  throw std::runtime_error(fmt::format("cannot {} '{}': {}", doing, path, std::strerror(errno)));
}

/// All of the text. `path` is for the error.
void write_all(int descriptor, std::string_view text, const std::string& path) {
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t count = ::write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("write", path);
    written += static_cast<std::size_t>(count);
  }
}

/// Makes the folder that a file is to be in.
void make_folder_of(const std::string& file) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
}

/// Opens a file that no other process writes. `remedy` is for one that another process has ended meanwhile: its lock is
/// free then, but what was opened has its final name by now.
int open_alone(const std::string& path, const char* remedy) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) fail("write", path);
  const bool alone = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  struct stat opened {
  }, named{};
  if (alone && ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino)
    return descriptor;
  ::close(descriptor);
  if (!alone) throw std::runtime_error(fmt::format("'{}' is being written by another process", path));
  throw std::runtime_error(fmt::format("'{}' was ended by another process in the meantime; {}", path, remedy));
}

/// Makes sure that the file is on disk, and gives it its final name.
void end_file(int descriptor, const std::string& path, const std::string& name) {
  if (::fsync(descriptor) != 0) fail("write", path);
  if (std::rename(path.c_str(), name.c_str()) != 0) fail("rename to its own name", path);
}

/// The complete lines of a file, without their line ends. What comes after the last end is left out.
std::vector<std::string> complete_lines(const std::string& path) {
  const Result<std::string> file = read_text_file(path, kMostBytes);
  if (!file) throw std::runtime_error(fmt::format("'{}' {}", path, file.error()));
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end; (end = file->find('\n', begin)) != std::string::npos; begin = end + 1)
    lines.push_back(file->substr(begin, end - begin));
  return lines;
}

}  // namespace

PartFile::PartFile(std::string file, bool resume) : file_(std::move(file)), partial_(partial_of(file_)) {
  make_folder_of(file_);
  descriptor_ = open_alone(partial_, "--resume takes over its file");
  if (!resume && ::lseek(descriptor_, 0, SEEK_END) > 0) {
    ::close(descriptor_);
    throw std::runtime_error(
        fmt::format("'{}' is there, from a process that did not end; --resume goes on with it, or remove it", partial_));
  }
  kept_ = complete_lines(partial_);
  off_t whole = 0;
  for (const std::string& line : kept_) whole += static_cast<off_t>(line.size()) + 1;
  if (::ftruncate(descriptor_, whole) != 0 || ::lseek(descriptor_, whole, SEEK_SET) != whole) fail("write", partial_);
}

PartFile::~PartFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void PartFile::append(const std::string& line) { write_all(descriptor_, line + '\n', partial_); }

void PartFile::finish() { end_file(descriptor_, partial_, file_); }

MergedFile::MergedFile(std::string file) : file_(std::move(file)), unfinished_(file_ + ".merging") {
  make_folder_of(file_);
  descriptor_ = open_alone(unfinished_, "merge again");
  if (::ftruncate(descriptor_, 0) != 0) fail("write", unfinished_);
}

MergedFile::~MergedFile() {
  if (!unfinished_.empty()) ::unlink(unfinished_.c_str());
  ::close(descriptor_);
}

void MergedFile::append(const std::string& line) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  buffer_ += line;
  buffer_ += '\n';
  if (buffer_.size() < kPiece) return;
  write_all(descriptor_, buffer_, unfinished_);
  buffer_.clear();
}

void MergedFile::finish() {
  write_all(descriptor_, buffer_, unfinished_);
  end_file(descriptor_, unfinished_, file_);
  unfinished_.clear();
}

}  // namespace evenstep::internal
