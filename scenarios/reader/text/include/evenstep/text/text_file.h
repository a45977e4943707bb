#pragma once
/// Reads a text file, whole or in pieces, and writes one.

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

#include "evenstep/time/result.h"

namespace evenstep::internal {

/// Errors: the file does not exist (the error names its folder if that is missing), is a directory, is larger than
/// `most_bytes`, or cannot be read.
Result<std::string> read_text_file(const std::string& path, std::int64_t most_bytes);

/// The text without the byte order mark of UTF-8 that some editors and spreadsheets write at the beginning of a file.
inline std::string_view without_byte_order_mark(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

/// Writes to another name in the same folder and then renames, so that the file is either complete or as it was before; a
/// pipe or a device is written to directly. Returns what went wrong; empty: ok.
std::string write_text_file(const std::string& path, std::string_view text);
/// The same for a text that `write` puts into the stream piece by piece, so that it need not be in memory as a whole.
std::string write_text_file(const std::string& path, const std::function<void(std::ostream&)>& write);
/// Why write_text_file cannot write to `path`, as far as this can be known in advance; empty if it can.
std::string write_objection(const std::string& path);

/// The path in a form that another machine may know: relative to the working directory if it lies below that, else only the
/// file's name.
std::string portable_path(const std::string& path);

/// Reads a file in pieces of whole lines, one at a time, so that a recording of ten million rows need not be in memory.
class TextPieces {
 public:
  TextPieces(const std::string& path, std::int64_t most_bytes);
  /// The next lines; empty at the end and after an error. The last line of the file may lack its line end.
  std::string_view next();
  /// What went wrong; empty: ok.
  const std::string& error() const { return error_; }

 private:
  std::ifstream stream_;
  std::string buffer_, error_;
  std::size_t kept_ = 0, kept_from_ = 0;  // the beginning of a line whose rest has not been read yet
  std::int64_t most_bytes_, left_bytes_;
};

}  // namespace evenstep::internal
