#pragma once
/// What `evenstep merge` makes of merged lines: the results that the command of these lines gives with --resume, in a folder
/// beside the file. Nothing is run again.

#include <atomic>
#include <optional>
#include <string>

#include "evenstep/campaigns/parts.h"
#include "evenstep/format/reader.h"

namespace evenstep::app {

struct Merged {
  std::string program;
  std::string file;    ///< of the merged lines
  std::string folder;  ///< for the results: beside the file, with its name but no extension
  PartSubject subject;
  bool json = false;
  const std::atomic<bool>& interrupted;
  const Registry& registry;
};
/// Each prints its results, writes them and returns the exit code of its command. The scenarios must be where the shards had
/// them and unchanged, and the program must be the same. Otherwise there are no results, and the reason is printed.
std::optional<ExitCode> study_results(const Merged& merged);
std::optional<ExitCode> size_results(const Merged& merged);
std::optional<ExitCode> catalogue_results(const Merged& merged);

}  // namespace evenstep::app
