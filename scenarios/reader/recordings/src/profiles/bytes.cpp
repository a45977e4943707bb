#include "bytes.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
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

/// Which byte of two has the upper half of ASCII characters, 0 or 1; empty: it is not UTF-16.
std::optional<int> zero_byte_of(std::string_view first) {
  if (first.starts_with("\xFF\xFE")) return 1;
  if (first.starts_with("\xFE\xFF")) return 0;
  if (first.size() < 4) return std::nullopt;
  for (const int zero : {0, 1}) {
    const auto at = [&](int i) { return first[static_cast<std::size_t>(i)]; };
    if (at(zero) == 0 && at(zero + 2) == 0 && at(1 - zero) != 0 && at(3 - zero) != 0) return zero;
  }
  return std::nullopt;
}

class Utf8OfUtf16 : public Bytes {
 public:
  explicit Utf8OfUtf16(std::unique_ptr<Bytes> utf16) : utf16_(std::move(utf16)) { error_ = utf16_->error(); }
  std::string_view next() override {
    text_.clear();
    while (text_.empty()) {
      const std::string_view piece = utf16_->next();
      error_ = utf16_->error();
      if (piece.empty()) break;
      if (!big_) big_ = zero_byte_of(piece) == 0;
      for (const char c : piece) add(static_cast<unsigned char>(c));
    }
    return text_;
  }

 private:
  void add(unsigned char byte) {
    if (!half_) return void(half_ = byte);
    const unsigned unit = *big_ ? *half_ * 256u + byte : byte * 256u + *half_;
    half_.reset();
    if (std::exchange(first_, false) && unit == 0xFEFF) return;
    const bool low = unit >= 0xDC00 && unit < 0xE000;
    if (high_ != 0 && low) return write(0x10000 + ((std::exchange(high_, 0u) - 0xD800) << 10) + (unit - 0xDC00));
    if (std::exchange(high_, 0u) != 0 || low) write(0xFFFD);
    if (unit >= 0xD800 && unit < 0xDC00)
      high_ = unit;
    else if (!low)
      write(unit);
  }
  void write(unsigned c) {
    const auto tail = [&](unsigned shift) { text_ += static_cast<char>(0x80 | ((c >> shift) & 0x3F)); };
    if (c < 0x80) {
      text_ += static_cast<char>(c);
    } else if (c < 0x800) {
      text_ += static_cast<char>(0xC0 | (c >> 6)), tail(0);
    } else if (c < 0x10000) {
      text_ += static_cast<char>(0xE0 | (c >> 12)), tail(6), tail(0);
    } else {
      text_ += static_cast<char>(0xF0 | (c >> 18)), tail(12), tail(6), tail(0);
    }
  }

  std::unique_ptr<Bytes> utf16_;
  std::optional<bool> big_;
  std::optional<unsigned char> half_;
  unsigned high_ = 0;  ///< the first half of a character of two units
  bool first_ = true;
  std::string text_;
};

}  // namespace

bool is_utf16(std::string_view first_bytes) { return zero_byte_of(first_bytes).has_value(); }
std::unique_ptr<Bytes> utf8_of_utf16(std::unique_ptr<Bytes> utf16) {
  return std::make_unique<Utf8OfUtf16>(std::move(utf16));
}
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
