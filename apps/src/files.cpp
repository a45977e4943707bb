#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "commands.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/text/text_file.h"
#include "evenstep/text/workshop.h"
#include "output.h"

namespace evenstep::app {
namespace fs = std::filesystem;

namespace {

/// Whether a run or a study has written this file: no scenario of the user's.
bool is_of_a_run(const fs::path& file) {
  const fs::path folder = file.parent_path();
  return file.filename() == "resolved.toml" && (fs::exists(folder / kSummaryFile) || fs::exists(folder / kStudyFile));
}

/// Also those behind links. A link that leads nowhere is found, too, so that the reader says what is wrong with it.
std::vector<std::string> scenarios_below(const std::string& folder) {
  std::vector<std::string> found;
  std::set<fs::path> entered{fs::canonical(folder)};  // links can lead in circles
  const auto follow = fs::directory_options::follow_directory_symlink;
  for (auto at = fs::recursive_directory_iterator(folder, follow); at != fs::recursive_directory_iterator(); ++at) {
    const fs::path& path = at->path();
    if (at->is_directory()) {
      const bool once = entered.insert(fs::canonical(path)).second;
      if (!once || internal::Workshop::is_name(path.filename().string())) at.disable_recursion_pending();
    } else if (path.extension() == ".toml" && !is_of_a_run(path)) {
      found.push_back(path.string());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::optional<std::vector<std::string>> scenario_files(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  std::set<fs::path> seen;
  const auto add = [&](const std::string& file) {
    std::error_code endless;
    const fs::path known = fs::weakly_canonical(file, endless);
    if (seen.insert(endless ? fs::path(file) : known).second) files.push_back(file);
  };
  for (const std::string& path : paths) {
    if (path.empty()) {
      spdlog::error("error: a scenario's name is empty; name a file or a folder");
      return std::nullopt;
    }
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      add(path);  // if something is wrong with it, the reader will say so
      continue;
    }
    const std::vector<std::string> found = scenarios_below(path);
    if (found.empty()) {
      spdlog::error("{}: error: no scenario (*.toml) in this folder", path);
      return std::nullopt;
    }
    for (const std::string& file : found) add(file);
  }
  return files;
}

std::string here_or_installed(const std::string& path) {
  std::error_code error;
  if (path.empty() || fs::path(path).is_absolute() || fs::exists(path, error)) return path;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = (program.parent_path().parent_path() / "share/evenstep" / path).lexically_normal();
  return !error && fs::exists(installed, error) ? installed.string() : path;
}

bool write_text(const std::string& path, const std::string& text) {
  return write_text(path, [&](std::ostream& out) { out << text; });
}

bool write_text(const std::string& path, const std::function<void(std::ostream&)>& write) {
  const std::string error = internal::write_text_file(path, write);
  if (error.empty()) return true;
  print({{path, 0, 0, error}});
  return false;
}

fs::path default_place() {
  if (::access(".", W_OK | X_OK) == 0) return "runs";
  return fs::temp_directory_path() / fmt::format("evenstep-runs-{}", ::getuid());
}

void print(const std::vector<Diagnostic>& errors) {
  for (const Diagnostic& error : errors) {
    if (on_github())
      annotate(AnnotationLevel::error, {error.file, error.line, error.column}, "evenstep", text(error));
    else
      spdlog::error("{}", text(error));
  }
}

}  // namespace evenstep::app
