#include "text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace evenstep::internal {

TextFile read_text_file(const std::string& path, std::int64_t most_bytes) {
  namespace fs = std::filesystem;
  std::error_code status_error;
  const fs::file_status status = fs::status(path, status_error);
  if (!fs::exists(status)) {
    const fs::path folder = fs::path(path).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !fs::exists(folder, ignored))
      return {{}, fmt::format("no such file: there is no folder '{}'", folder.string())};
    return {{}, "no such file"};
  }
  if (fs::is_directory(status)) return {{}, "is a directory, not a file"};
  if (!fs::is_regular_file(status)) return {{}, "is not a regular file"};

  std::ifstream stream(path, std::ios::binary);
  if (!stream) return {{}, "cannot be opened; may you read it?"};
  TextFile file;
  const std::uintmax_t size = fs::file_size(path, status_error);
  if (!status_error) file.text.reserve(std::min(size, static_cast<std::uintmax_t>(most_bytes)));
  char chunk[64 * 1024];
  while (stream.read(chunk, sizeof chunk) || stream.gcount() > 0) {
    file.text.append(chunk, static_cast<std::size_t>(stream.gcount()));
    if (static_cast<std::int64_t>(file.text.size()) > most_bytes) {
      return {{}, fmt::format("is larger than {} bytes, the limit for such a file", most_bytes)};
    }
  }
  if (stream.bad()) return {{}, "cannot be read"};
  return file;
}

}  // namespace evenstep::internal
