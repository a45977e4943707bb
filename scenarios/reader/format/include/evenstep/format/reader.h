#pragma once
/// The two halves of reading a scenario: from its files to one table, and from the table to a Scenario. A sweep changes the
/// table in between.

#include <string>
#include <string_view>
#include <vector>

#include "evenstep/format/document.h"

namespace evenstep::internal {

/// The table of a scenario with `extends` and --set applied.
Value load_with_overrides(const std::string& path, const ReadOptions& options, Errors& errors);
/// `path` is the scenario's file, for messages. `registry` and `real_time` are those of ReadOptions.
ReadResult read_document(Value document, const std::string& path, const Registry& registry = {}, bool real_time = false);

/// Takes the faults that [run] faults_off names out of the tables: "timing.hitch", "device.left.faults.2". An unknown name
/// is an error. A value that is not a list of names is left for the check to report.
void switch_off_faults(Value& document, Errors& errors);
/// Erases those faults of devices that would begin when a run of this length is over: a scenario that has them is refused.
/// The document was read without errors, and has no times in nominal units.
void erase_faults_after(Value& document, Duration run);

/// Whether the value at this path of a scenario is the name of a file.
bool names_file(std::string_view path);
/// All such values of a document, including those in its [sweep.grid]: data (recorded timing, motions), and plug-ins.
std::vector<Value*> named_files(Value& document);
std::vector<Value*> data_files(Value& document);
std::vector<Value*> library_files(Value& document);
/// The files that the words of [scene] command name, and the folder in which they were looked for; nullptr without one.
struct CommandFiles {
  Value* directory = nullptr;
  std::vector<std::string> files;
};
CommandFiles files_of_command(Value& document);

}  // namespace evenstep::internal
