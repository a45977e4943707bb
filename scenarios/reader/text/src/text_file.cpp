#include "evenstep/text/text_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "evenstep/text/workshop.h"

namespace evenstep::internal {

namespace {

/// Opens a file. Returns why it cannot be read; empty if it is open.
std::string open_file(const std::string& path, std::ifstream& stream) {
  namespace fs = std::filesystem;
  std::error_code status_error;
  const fs::file_status status = fs::status(path, status_error);
  if (!fs::exists(status)) {
    const fs::path folder = fs::path(path).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !fs::exists(folder, ignored))
      return fmt::format("no such file: there is no folder '{}'", folder.string());
    return "no such file";
  }
  if (fs::is_directory(status)) return "is a directory, not a file";
  if (!fs::is_regular_file(status)) return "is not a regular file";
  stream.open(path, std::ios::binary);
  return stream ? "" : "cannot be opened; may you read it?";
}

}  // namespace

Result<std::string> read_text_file(const std::string& path, std::int64_t most_bytes) {
  std::string text;
  TextPieces pieces(path, most_bytes);
  std::error_code size_error;
  const std::uintmax_t size = pieces.error().empty() ? std::filesystem::file_size(path, size_error) : 0;
  if (!size_error) text.reserve(std::min(size, static_cast<std::uintmax_t>(most_bytes)));
  for (std::string_view piece = pieces.next(); !piece.empty(); piece = pieces.next()) text += piece;
  if (!pieces.error().empty()) return Failure(pieces.error());
  return text;
}

namespace {

/// A pipe or a device, which nothing can be renamed to.
bool is_special(const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error);
}

}  // namespace

std::string write_objection(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::is_directory(path, error)) return "is a directory, not a file; name a file in it";
  if (is_special(path)) return {};
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    return fmt::format("cannot be written: there is no folder '{}'; make it, or name another one", folder.string());
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    return fmt::format("cannot be written: the folder '{}': {}; name another one", folder.string(), std::strerror(errno));
  return {};
}

std::string write_text_file(const std::string& path, std::string_view text) {
  return write_text_file(path,
                         [&](std::ostream& out) { out.write(text.data(), static_cast<std::streamsize>(text.size())); });
}

std::string write_text_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
  if (std::string objection = write_objection(path); !objection.empty()) return objection;
  try {
    if (is_special(path)) {
      write_file(path, write);
      return {};
    }
    Workshop workshop(path);
    write_file(workshop.made(), write);
    workshop.put();
    return {};
  } catch (const std::system_error& error) {
    return fmt::format("cannot be written: {}", error.code().message());
  }
}

std::string portable_path(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path here = fs::current_path(error);
  fs::path below = fs::path(path).lexically_normal();
  // A path through symbolic links counts as below it, too, if either its own form or the resolved one is.
  if (below.is_absolute()) {
    below = below.lexically_relative(here);
    if (below.empty() || *below.begin() == "..") below = fs::weakly_canonical(path, error).lexically_relative(here);
  }
  if (error || below.empty() || *below.begin() == "..") return fs::path(path).filename().string();
  return below.string();
}

TextPieces::TextPieces(const std::string& path, std::int64_t most_bytes) : most_bytes_(most_bytes), left_bytes_(most_bytes) {
  error_ = open_file(path, stream_);
  if (error_.empty()) buffer_.resize(64 * 1024);
}

std::string_view TextPieces::next() {
  while (error_.empty()) {
    // The line is longer than the buffer, so the buffer is doubled.
    if (kept_ == buffer_.size()) buffer_.resize(2 * buffer_.size());
    std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(kept_from_), kept_, buffer_.begin());
    kept_from_ = 0;
    stream_.read(buffer_.data() + kept_, static_cast<std::streamsize>(buffer_.size() - kept_));
    const std::size_t filled = kept_ + static_cast<std::size_t>(stream_.gcount());
    left_bytes_ -= stream_.gcount();
    if (left_bytes_ < 0) error_ = fmt::format("is larger than {} bytes, the limit for such a file", most_bytes_);
    if (stream_.bad()) error_ = "cannot be read";
    if (!error_.empty()) break;
    const bool end = filled < buffer_.size();
    const std::size_t line_end = std::string_view(buffer_).substr(0, filled).rfind('\n');
    const std::size_t whole = end ? filled : line_end == std::string_view::npos ? 0 : line_end + 1;
    kept_from_ = whole;
    kept_ = filled - whole;
    if (whole > 0 || end) return std::string_view(buffer_).substr(0, whole);
  }
  return {};
}

}  // namespace evenstep::internal
