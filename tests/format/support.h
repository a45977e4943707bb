#pragma once
#include <string>

#include "evenstep/format/scenario.h"

namespace evenstep::test {

/// A folder of its own, gone at the end of the test.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  /// Writes a file (and the folders it needs); its path.
  std::string write(const std::string& name, const std::string& text) const;
  std::string path(const std::string& name) const;

 private:
  std::string root_;
};

/// Reads `text` as scenario.toml of a folder of its own.
ReadResult read_text(const std::string& text, const ReadOptions& options = {});
/// All errors, one per line, with file names cut to their last part.
std::string errors_of(const ReadResult& result);
/// Every value of a scenario but its file name and places, one per line: two scenarios are the same if this is.
std::string describe(const Scenario& scenario);

extern const char* const kSpring;  ///< a good scenario of each kind
extern const char* const kTissue;
extern const char* const kPid;

}  // namespace evenstep::test
