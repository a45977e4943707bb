#include "evenstep/text/workshop.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <system_error>

namespace evenstep::internal {
namespace fs = std::filesystem;
namespace {

constexpr const char* kMark = ".writing-";

[[noreturn]] void fail(const fs::path& path) {
  throw std::system_error(errno, std::generic_category(), "cannot write " + path.string());
}

fs::path folder_of(const fs::path& place) { return place.has_parent_path() ? place.parent_path() : fs::path("."); }

std::string prefix(const fs::path& place) { return fmt::format(".{}{}", place.filename().string(), kMark); }

fs::path old_in(const fs::path& workshop) { return workshop / "old"; }

/// Opens and locks a workshop, and waits for the lock if `wait`. -1 if another process has it, or has removed it.
int locked(const fs::path& path, bool wait) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0 && errno != ENOENT) fail(path);
  if (folder < 0) return -1;
  while (::flock(folder, LOCK_EX | (wait ? 0 : LOCK_NB)) != 0) {
    if (errno == EINTR) continue;
    if (!wait) return ::close(folder), -1;
    break;  // a file system without locks; nobody removes a workshop there, either
  }
  // The lock is that of the folder that was opened. Meanwhile it may have been removed, and another one made.
  struct stat opened {
  }, named{};
  const bool same = ::fstat(folder, &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino;
  if (same) return folder;
  ::close(folder);
  return -1;
}

/// Removes the workshops of processes that no longer live.
void remove_left_ones(const fs::path& place) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_of(place), ignored)) {
    if (!entry.path().filename().string().starts_with(prefix(place))) continue;
    const int lock = locked(entry.path(), false);
    if (lock < 0) continue;
    if (!fs::exists(place)) fs::rename(old_in(entry.path()), place, ignored);
    fs::remove_all(entry.path(), ignored);
    ::close(lock);
  }
}

}  // namespace

Workshop::Workshop(const fs::path& place)
    : place_(place), path_(folder_of(place) / fmt::format("{}{}", prefix(place), ::getpid())) {
  remove_left_ones(place);
  // Until it is locked, another process may take it for one that was left, and remove it.
  while (lock_ < 0) {
    fs::create_directory(path_);
    lock_ = locked(path_, true);
  }
}

Workshop::~Workshop() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(lock_);
}

void Workshop::put() {
  if (fs::is_directory(made()))
    put_folder();
  else
    fs::rename(made(), place_);
}

/// A folder cannot be renamed to the name of another one, so the two change places. Where the file system cannot swap them
/// (not every network file system can), the older one is for a moment at neither place, but where the next writer finds it.
void Workshop::put_folder() {
  for (;;) {
    if (::renameat2(AT_FDCWD, made().c_str(), AT_FDCWD, place_.c_str(), RENAME_EXCHANGE) == 0) return;
    const bool swaps = errno != EINVAL && errno != ENOSYS;
    if (swaps && errno != ENOENT) fail(place_);
    std::error_code none, error;
    const fs::path old = old_in(path_);
    if (!swaps) {
      fs::remove_all(old);
      fs::rename(place_, old, none);
    }
    fs::rename(made(), place_, error);
    if (!error) return;
    if (error == std::errc::directory_not_empty || error == std::errc::file_exists) continue;  // another process was faster
    if (!swaps && !none) fs::rename(old, place_, none);
    throw fs::filesystem_error("cannot write", place_, error);
  }
}

void write_file(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  std::ofstream out(path, std::ios::binary);
  try {
    if (!out.is_open()) fail(path);
    out.exceptions(std::ios::badbit | std::ios::failbit);  // a full disk ends the writing at once
    write(out);
    out.close();
  } catch (const std::ios::failure&) {
    fail(path);
  }
}

bool Workshop::is_name(const std::string& name) { return name.starts_with('.') && name.find(kMark) != std::string::npos; }

}  // namespace evenstep::internal
