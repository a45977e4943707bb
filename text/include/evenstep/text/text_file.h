#pragma once
/// A whole file, or why not.

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

namespace evenstep::internal {

struct TextFile {
  std::string text;
  std::string error;  ///< empty: ok
};

/// Errors: not there (with the folder that is missing, if that is why), a directory, larger than `most_bytes`, unreadable.
TextFile read_text_file(const std::string& path, std::int64_t most_bytes);

/// The same in pieces of whole lines, one at a time: a recording of ten million rows need not be in memory.
class TextPieces {
 public:
  TextPieces(const std::string& path, std::int64_t most_bytes);
  /// The next lines; empty at the end and after an error. The last line may have no end.
  std::string_view next();
  /// Empty: ok.
  const std::string& error() const { return error_; }

 private:
  std::ifstream stream_;
  std::string buffer_, error_;
  std::size_t kept_ = 0, kept_from_ = 0;   // the begin of a line that the last piece could not give
  std::int64_t most_bytes_, left_bytes_;
};

}  // namespace evenstep::internal
