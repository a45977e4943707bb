#include "write_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "evenstep/harness/run_folder.h"

namespace evenstep {
namespace fs = std::filesystem;
namespace {

constexpr const char* kOld = "old";

/// Whether the folder may be replaced: it does not exist, is empty, or is one of ours.
bool replaceable(const fs::path& folder, const std::string& its_file) {
  return !fs::exists(folder) || (fs::is_directory(folder) && (fs::is_empty(folder) || fs::exists(folder / its_file)));
}

[[noreturn]] void fail(const fs::path& path) {
  throw std::runtime_error(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
}

void fill(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  std::ofstream out(path, std::ios::binary);
  out.exceptions(std::ios::badbit | std::ios::failbit);  // a full disk ends the writing at once
  try {
    if (!out.is_open()) fail(path);
    write(out);
    out.close();
  } catch (const std::ios::failure&) {
    fail(path);
  }
}

/// A folder beside `place`, in which what will stand there is made. It is locked as long as this process lives: one without
/// a lock was left by a process that was killed.
class Workshop {
 public:
  explicit Workshop(const fs::path& place) : path_(place.parent_path() / fmt::format("{}{}", prefix(place), ::getpid())) {
    remove_left_ones(place);
    fs::create_directories(path_);
    lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ < 0 || ::flock(lock_, LOCK_EX | LOCK_NB) != 0) fail(path_);
  }
  ~Workshop() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    if (lock_ >= 0) ::close(lock_);
  }
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;
  fs::path made() const { return path_ / "new"; }

 private:
  static std::string prefix(const fs::path& place) { return fmt::format(".{}.writing-", place.filename().string()); }

  static void remove_left_ones(const fs::path& place) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(place.parent_path(), ignored)) {
      if (!entry.path().filename().string().starts_with(prefix(place))) continue;
      const int left = ::open(entry.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      if (left < 0) continue;
      if (::flock(left, LOCK_EX | LOCK_NB) == 0) {
        if (!fs::exists(place)) fs::rename(entry.path() / kOld, place, ignored);
        fs::remove_all(entry.path(), ignored);
      }
      ::close(left);
    }
  }

  fs::path path_;
  int lock_ = -1;
};

/// Puts `made` at `place`; an older folder there is then at `made`. Where the file system cannot swap them (not every
/// network file system can), the older one is for a moment at neither place, but where the next writer finds it.
void change_places(const fs::path& made, const fs::path& place) {
  if (!fs::exists(place)) return fs::rename(made, place);
  if (::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, place.c_str(), RENAME_EXCHANGE) == 0) return;
  if (errno != EINVAL && errno != ENOSYS) fail(place);
  fs::rename(place, made.parent_path() / kOld);
  fs::rename(made, place);
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
    if (::access(path.parent_path().c_str(), W_OK | X_OK) != 0) {
      return fmt::format("cannot write into '{}': {}; give a writable place with --out", path.parent_path().string(),
                         std::strerror(errno));
    }
    return {};
  } catch (const fs::filesystem_error& error) {
    return fmt::format("cannot use '{}' as run folder: {}; give a writable place with --out", folder,
                       error.code().message());
  }
}

std::string write_folder(const std::string& folder, const std::vector<FolderFile>& files) {
  const fs::path path = internal::absolute_folder(folder);
  try {
    fs::create_directories(path.parent_path());
    const Workshop workshop(path);
    fs::create_directory(workshop.made());
    for (const FolderFile& file : files) fill(workshop.made() / file.name, file.write);
    if (!replaceable(path, files.front().name))
      throw std::runtime_error(fmt::format("'{}' is not a run folder and is left alone", path.string()));
    change_places(workshop.made(), path);
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace evenstep
