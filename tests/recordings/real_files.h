#pragma once
/// Recordings of other projects, which evenstep may not ship. They are in the folder that EVENSTEP_RECORDINGS names, or in
/// shared/recordings beside the repository.

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "catch.h"

namespace evenstep::test {

/// The path of a file of our own, made after the columns that a profiler's public source writes.
inline std::string made_file(const std::string& name) {
  return std::string(EVENSTEP_SOURCE_DIR) + "/tests/recordings/made/" + name;
}

/// The path of a file. If it is missing, the test says so and ends.
inline std::optional<std::string> real_file(const std::string& name) {
  namespace fs = std::filesystem;
  const char* const folder = std::getenv("EVENSTEP_RECORDINGS");
  const fs::path path =
      folder != nullptr ? fs::path(folder) / name : fs::path(EVENSTEP_SOURCE_DIR) / "../shared/recordings" / name;
  if (fs::exists(path)) return path.string();
  WARN("skipped: there is no " << path.string() << "; set EVENSTEP_RECORDINGS to the folder that has it");
  return std::nullopt;
}

}  // namespace evenstep::test
