#include "run_places.h"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "evenstep/harness/run_folder.h"

namespace evenstep::app {
namespace fs = std::filesystem;
namespace {

fs::path identity(const std::string& file) {
  std::error_code endless;
  const fs::path path = fs::weakly_canonical(fs::absolute(file), endless);
  return endless ? fs::absolute(file).lexically_normal() : path;
}

/// The name of a run folder: that of the file, with the names of `levels` folders above it in front.
std::string name_with(const fs::path& file, int levels) {
  std::string name = file.stem().string();
  fs::path above = file.parent_path();
  for (int i = 0; i < levels && above.has_filename(); ++i, above = above.parent_path())
    name = above.filename().string() + '-' + name;
  return name;
}

/// The scenario whose run is in this folder; empty if there is none, or its file is gone.
std::string scenario_in(const fs::path& folder) {
  std::ifstream in(folder / kSummaryFile);
  const nlohmann::json summary = nlohmann::json::parse(in, nullptr, false);
  if (!summary.is_object() || !summary.contains("file") || !summary["file"].is_string()) return {};
  const std::string file = summary["file"].get<std::string>();
  std::error_code error;
  return fs::exists(file, error) ? file : std::string();
}

/// Levels with which no two of these files have the same name, as few as possible.
std::vector<int> different_names(const std::vector<fs::path>& files, std::vector<int> levels) {
  for (bool again = true; again;) {
    again = false;
    std::map<std::string, std::vector<std::size_t>> named;
    for (std::size_t i = 0; i < files.size(); ++i) named[name_with(files[i], levels[i])].push_back(i);
    for (const auto& [name, same] : named) {
      for (const std::size_t i : same) {
        if (same.size() < 2 || name_with(files[i], levels[i] + 1) == name) continue;
        ++levels[i];
        again = true;
      }
    }
  }
  return levels;
}

}  // namespace

std::vector<std::string> run_places(const std::vector<std::string>& files, const std::string& out) {
  if (files.size() == 1 && !out.empty()) return {out};
  const fs::path place = out.empty() ? default_place() : fs::path(out);
  std::vector<fs::path> known;
  for (const std::string& file : files) known.push_back(identity(file));
  std::vector<int> levels = different_names(known, std::vector<int>(files.size(), 0));
  for (bool again = true; again;) {
    again = false;
    for (std::size_t i = 0; i < files.size(); ++i) {
      const std::string name = name_with(known[i], levels[i]), longer = name_with(known[i], levels[i] + 1);
      const std::string held = scenario_in(place / name);
      if (held.empty() || identity(held) == known[i] || longer == name) continue;
      spdlog::info("{} has the run of {}; that of {} goes to {}", (place / name).string(), held, files[i],
                   (place / longer).string());
      ++levels[i];
      again = true;
    }
    if (again) levels = different_names(known, levels);
  }
  std::vector<std::string> places;
  for (std::size_t i = 0; i < files.size(); ++i) places.push_back((place / name_with(known[i], levels[i])).string());
  return places;
}

}  // namespace evenstep::app
