#include "bytes.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "evenstep/text/text_file.h"

namespace evenstep::internal {
namespace {

class MemoryBytes : public Bytes {
 public:
  explicit MemoryBytes(std::string_view bytes) : bytes_(bytes) {}
  std::string_view next() override { return std::exchange(bytes_, {}); }

 private:
  std::string_view bytes_;
};

class FileBytes : public Bytes {
 public:
  explicit FileBytes(const std::string& path) : buffer_(std::size_t{64} << 10, '\0') {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) {
      error_ = "no such file";
    } else if (!fs::is_regular_file(status)) {
      error_ = fs::is_directory(status) ? "is a directory, not a file" : "is not a regular file";
    } else {
      stream_.open(path, std::ios::binary);
      if (!stream_) error_ = "cannot be opened; may you read it?";
    }
  }
  std::string_view next() override {
    if (!error_.empty()) return {};
    stream_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    if (stream_.bad()) error_ = "cannot be read";
    const auto count = static_cast<std::size_t>(stream_.gcount());
    left_ -= stream_.gcount();
    if (left_ < 0) error_ = fmt::format("is larger than {} bytes, the limit for such a file", kMostProfileBytes);
    return error_.empty() ? std::string_view(buffer_).substr(0, count) : std::string_view();
  }

 private:
  std::ifstream stream_;
  std::string buffer_;
  std::int64_t left_ = kMostProfileBytes;
};

}  // namespace

std::unique_ptr<Bytes> bytes_of_memory(std::string_view bytes) { return std::make_unique<MemoryBytes>(bytes); }
std::unique_ptr<Bytes> bytes_of_file(const std::string& path) { return std::make_unique<FileBytes>(path); }
bool is_gzip(std::string_view first_bytes) { return first_bytes.starts_with("\x1f\x8b"); }

bool Lines::next(std::string_view& line) {
  line_.clear();
  bool any = false;
  for (;;) {
    if (piece_.empty()) piece_ = bytes_.next();
    if (!error().empty()) return false;
    if (piece_.empty()) break;
    any = true;
    const std::size_t end = piece_.find('\n');
    line_ += piece_.substr(0, end);
    if (line_.size() > kLongestProfileLine) {
      error_ = fmt::format("line {} is longer than {} bytes", number_ + 1, kLongestProfileLine);
      return false;
    }
    piece_.remove_prefix(end == std::string_view::npos ? piece_.size() : end + 1);
    if (end != std::string_view::npos) break;
  }
  if (!any) return false;
  if (line_.ends_with('\r')) line_.pop_back();
  line = ++number_ == 1 ? without_byte_order_mark(line_) : line_;
  return true;
}

}  // namespace evenstep::internal
