#pragma once
/// The lines of a part, one at a time, so that ten thousand parts can be read side by side: the file is open only
/// while a piece of it is read, and only that piece is in memory.

#include <cstddef>
#include <cstdint>
#include <string>

namespace evenstep::internal {

class PartLines {
 public:
  /// `piece` is how many bytes are read at once; a longer line is read nevertheless.
  PartLines(std::string path, std::size_t piece) : path_(std::move(path)), piece_(piece) {}

  /// Moves on to the next line; false at the end of the file. Throws std::runtime_error if the file cannot be read, or if
  /// its last line has no end.
  bool next();
  const std::string& path() const { return path_; }
  /// The line without its end, and its number, which counts from 1. After next() has thrown: the line at which it did.
  const std::string& line() const { return line_; }
  std::int64_t number() const { return number_; }

 private:
  bool read_piece();

  std::string path_, line_, buffer_;
  std::size_t piece_, begin_ = 0;  // of what has not been handed out
  std::int64_t number_ = 0, offset_ = 0;
};

}  // namespace evenstep::internal
