#include "sweep_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
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

}  // namespace

std::vector<std::string> read_lines(const std::string& path, bool torn_end_allowed) {
  const Result<std::string> file = read_text_file(path, kMostBytes);
  if (!file) throw std::runtime_error(fmt::format("'{}' {}", path, file.error()));
  const std::string& text = *file;
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
    lines.push_back(text.substr(begin, end - begin));
  if (begin < text.size() && !torn_end_allowed)
    throw std::runtime_error(fmt::format("{}:{}: error: the line has no end; the file was cut off", path, lines.size() + 1));
  return lines;
}

SweepFile::SweepFile(std::string file, bool resume) : file_(std::move(file)), partial_(file_ + ".partial") {
  const std::filesystem::path folder = std::filesystem::path(file_).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
  if (!resume && std::filesystem::exists(partial_, error)) {
    throw std::runtime_error(
        fmt::format("'{}' is there, from a sweep that did not end; --resume goes on with it, or remove it", partial_));
  }
  descriptor_ = ::open(partial_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("write", partial_);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    ::close(descriptor_);
    throw std::runtime_error(fmt::format("'{}' is being written by another process", partial_));
  }
  kept_ = read_lines(partial_, true);
  off_t whole = 0;
  for (const std::string& line : kept_) whole += static_cast<off_t>(line.size()) + 1;
  if (::ftruncate(descriptor_, whole) != 0 || ::lseek(descriptor_, whole, SEEK_SET) != whole) fail("write", partial_);
}

SweepFile::~SweepFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void SweepFile::append(const std::string& line) {
  const std::string text = line + '\n';
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t count = ::write(descriptor_, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("write", partial_);
    written += static_cast<std::size_t>(count);
  }
}

void SweepFile::finish() {
  if (::fsync(descriptor_) != 0) fail("write", partial_);
  if (std::rename(partial_.c_str(), file_.c_str()) != 0) fail("rename to its own name", partial_);
}

}  // namespace evenstep::internal
