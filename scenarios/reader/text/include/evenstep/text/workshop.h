#pragma once
/// Where a file or a folder is made before it stands at its place.

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

namespace evenstep::internal {

/// A folder beside `place`, in which what will stand there is made, so that the older or the new one is there, and whole,
/// whatever happens meanwhile (a full disk, a killed process). Any number of processes may make something for the same place
/// at once: the last one that puts it there wins. What a killed process has left is removed by the next one.
class Workshop {
 public:
  /// The folder of `place` must exist. Throws std::system_error, as do the others here.
  explicit Workshop(const std::filesystem::path& place);
  /// Removes the workshop, and with it what was not put in its place.
  ~Workshop();
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;

  /// Where the file or the folder is to be made; nothing is there yet.
  std::filesystem::path made() const { return path_ / "new"; }
  /// Puts what was made in its place; what was there is gone.
  void put();

  /// Whether a file name is that of a workshop, whatever its place.
  static bool is_name(const std::string& name);

 private:
  void put_folder();

  std::filesystem::path place_, path_;
  int lock_ = -1;
};

/// Writes a file that nobody else looks at yet. Throws std::system_error as soon as something cannot be written.
void write_file(const std::filesystem::path& path, const std::function<void(std::ostream&)>& write);

}  // namespace evenstep::internal
