#pragma once
/// sweep.jsonl on its way: its lines go to "<file>.partial", one at a time and each at once, and that file takes the name
/// when it is complete. Nobody ever sees half of one under its own name.

#include <string>
#include <vector>

namespace evenstep::internal {

/// Whole lines of a file, without their ends; a last line without an end is dropped where `torn_end_allowed`, and otherwise
/// an error. Throws std::runtime_error.
std::vector<std::string> read_lines(const std::string& path, bool torn_end_allowed);

class SweepFile {
 public:
  /// Opens "<file>.partial". `resume`: keeps its whole lines; not so: there must be none. Throws std::runtime_error that
  /// names the file, what is wrong and the remedy; another process that writes it is such an error.
  SweepFile(std::string file, bool resume);
  ~SweepFile();
  SweepFile(const SweepFile&) = delete;
  SweepFile& operator=(const SweepFile&) = delete;

  const std::string& partial() const { return partial_; }
  /// What was there, the header among them.
  const std::vector<std::string>& kept() const { return kept_; }
  void append(const std::string& line);
  /// On disk and under its name.
  void finish();

 private:
  std::string file_, partial_;
  int descriptor_ = -1;
  std::vector<std::string> kept_;
};

}  // namespace evenstep::internal
