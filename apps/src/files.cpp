#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "commands.h"

namespace evenstep::app {
namespace fs = std::filesystem;

std::optional<std::vector<std::string>> scenario_files(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);  // if something is wrong with it, the reader will say so
      continue;
    }
    std::vector<std::string> found;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path)) {
      if (entry.is_regular_file() && entry.path().extension() == ".toml") found.push_back(entry.path().string());
    }
    if (found.empty()) {
      spdlog::error("{}: error: no scenario (*.toml) in this folder", path);
      return std::nullopt;
    }
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

fs::path default_place() {
  if (::access(".", W_OK | X_OK) == 0) return "runs";
  return fs::temp_directory_path() / fmt::format("evenstep-runs-{}", ::getuid());
}

void print(const std::vector<Diagnostic>& errors) {
  for (const Diagnostic& error : errors) spdlog::error("{}", text(error));
}

}  // namespace evenstep::app
