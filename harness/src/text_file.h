#pragma once
/// A whole file, or why not.

#include <cstdint>
#include <string>

namespace evenstep::internal {

struct TextFile {
  std::string text;
  std::string error;  ///< empty: ok
};

/// Errors: not there (with the folder that is missing, if that is why), a directory, larger than `most_bytes`, unreadable.
TextFile read_text_file(const std::string& path, std::int64_t most_bytes);

}  // namespace evenstep::internal
