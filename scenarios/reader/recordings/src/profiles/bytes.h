#pragma once
/// The bytes of a file or of memory, in pieces, unpacked where they are gzipped; and their lines.

#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace evenstep::internal {

inline constexpr std::int64_t kMostProfileBytes = std::int64_t{16} << 30;  // unpacked
inline constexpr std::size_t kLongestProfileLine = std::size_t{1} << 20;

/// A stream of bytes. It cannot go back.
class Bytes {
 public:
  virtual ~Bytes() = default;
  /// The next piece; empty at the end and after an error.
  virtual std::string_view next() = 0;
  /// What went wrong; empty: ok.
  const std::string& error() const { return error_; }

 protected:
  std::string error_;
};

/// `bytes` must outlive what is returned.
std::unique_ptr<Bytes> bytes_of_memory(std::string_view bytes);
std::unique_ptr<Bytes> bytes_of_file(const std::string& path);
bool is_gzip(std::string_view first_bytes);
/// Errors: zlib is not there, what it says of damaged bytes, more than kMostProfileBytes.
std::unique_ptr<Bytes> unpacked(std::unique_ptr<Bytes> packed);

/// Whether they begin with the byte order mark of UTF-16, or with two ASCII characters in it.
bool is_utf16(std::string_view first_bytes);
/// What is no character of UTF-16 becomes U+FFFD.
std::unique_ptr<Bytes> utf8_of_utf16(std::unique_ptr<Bytes> utf16);

/// The lines of a stream, without their ends. A line longer than kLongestProfileLine is an error.
class Lines {
 public:
  explicit Lines(Bytes& bytes) : bytes_(bytes) {}
  /// False at the end and after an error. The line holds till the next call.
  bool next(std::string_view& line);
  std::int64_t number() const { return number_; }  ///< of the line, from 1
  const std::string& error() const { return error_.empty() ? bytes_.error() : error_; }

 private:
  Bytes& bytes_;
  std::string_view piece_;
  std::string line_, error_;
  std::int64_t number_ = 0;
};

}  // namespace evenstep::internal
