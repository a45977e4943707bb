#pragma once
/// Writes the file of a part, such as sweep.jsonl: its lines go to "<file>.partial", each as soon as it is known, and the
/// file gets its final name when it is complete. So an incomplete file is never seen under that name.

#include <string>
#include <vector>

namespace evenstep::internal {

class PartFile {
 public:
  /// Opens "<file>.partial". With `resume` its complete lines are kept; otherwise it must have none. Throws
  /// std::runtime_error with the file, the problem and the remedy; it is an error if another process is writing the file, or
  /// has completed it in the meantime.
  PartFile(std::string file, bool resume);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  static std::string partial_of(const std::string& file) { return file + ".partial"; }
  const std::string& partial() const { return partial_; }
  /// The lines that were kept, including the header.
  const std::vector<std::string>& kept() const { return kept_; }
  void append(const std::string& line);
  /// Makes sure that the file is on disk, and gives it its final name.
  void finish();

 private:
  std::string file_, partial_;
  int descriptor_ = -1;
  std::vector<std::string> kept_;
};

/// The file of a merge: its lines go to "<file>.merging", which the next merge overwrites if this one is killed. Throws
/// std::runtime_error with the file and the problem; it is an error if another process is writing the file.
class MergedFile {
 public:
  explicit MergedFile(std::string file);
  /// Removes what was not finished.
  ~MergedFile();
  MergedFile(const MergedFile&) = delete;
  MergedFile& operator=(const MergedFile&) = delete;

  void append(const std::string& line);
  void finish();

 private:
  std::string file_, unfinished_, buffer_;
  int descriptor_ = -1;
};

}  // namespace evenstep::internal
