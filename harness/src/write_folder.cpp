#include "write_folder.h"

#include <fmt/format.h>

#include <stdexcept>
#include <system_error>

#include "evenstep/harness/run_folder.h"
#include "evenstep/text/workshop.h"

namespace evenstep {
namespace fs = std::filesystem;
namespace {

/// Whether the folder may be replaced: it does not exist, is empty, or is one of ours. The answer is the same while another
/// process replaces it, also where it is absent for a moment (Workshop::put).
bool replaceable(const fs::path& folder, const std::string& its_file) {
  std::error_code error;
  const auto is_ours = [&] { return fs::exists(folder / its_file, error); };
  if (is_ours() || !fs::exists(folder, error)) return true;
  const bool empty = fs::is_directory(folder, error) && fs::is_empty(folder, error);
  return (empty && !error) || !fs::exists(folder, error) || is_ours();
}

/// Not the error's own text, which names the hidden folder that is renamed to this one at the end.
std::string cannot_make(const std::string& folder, const std::system_error& error) {
  return fmt::format("cannot make the run folder '{}': {}; give a writable place with --out", folder,
                     error.code().message());
}

}  // namespace

namespace internal {

fs::path absolute_folder(const std::string& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace internal

std::string run_folder_objection(const std::string& folder, const std::string& its_file) {
  try {
    const fs::path path = internal::absolute_folder(folder);
    if (!replaceable(path, its_file)) {
      return fmt::format("'{}' exists and is not a run folder (no {} in it); give another place with --out", folder,
                         its_file);
    }
    fs::create_directories(path.parent_path());
    // What is allowed is not always possible: in /proc nobody can make a folder. So one is made, as the run will do.
    const internal::Workshop tried(path);
    return {};
  } catch (const std::system_error& error) {
    return cannot_make(folder, error);
  }
}

std::string write_folder(const std::string& folder, const std::vector<FolderFile>& files) {
  const fs::path path = internal::absolute_folder(folder);
  try {
    fs::create_directories(path.parent_path());
    internal::Workshop workshop(path);
    fs::create_directory(workshop.made());
    for (const FolderFile& file : files) internal::write_file(workshop.made() / file.name, file.write);
    if (!replaceable(path, files.front().name))
      throw std::runtime_error(fmt::format("'{}' is not a run folder and is left alone", path.string()));
    workshop.put();
    return {};
  } catch (const fs::filesystem_error& error) {
    return cannot_make(folder, error);
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace evenstep
