#pragma once
/// The names of folders.

#include <filesystem>
#include <string>

namespace evenstep::internal {

/// "runs/x/" means "runs/x".
std::filesystem::path absolute_folder(const std::string& folder);

}  // namespace evenstep::internal
