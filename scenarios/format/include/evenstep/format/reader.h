#pragma once
/// The two halves of reading a scenario: files to one table, one table to a scenario. A sweep changes the table in between.

#include <string>
#include <string_view>
#include <vector>

#include "evenstep/format/document.h"

namespace evenstep::internal {

/// `extends` and --set applied.
Value load_with_overrides(const std::string& path, const ReadOptions& options, Errors& errors);
/// `path`: the scenario's file, for messages.
ReadResult read_document(Value document, const std::string& path);

/// The value at this path of a scenario is the name of a file.
bool names_file(std::string_view path);
/// All such values of a document, those of its [sweep.grid] among them.
std::vector<Value*> named_files(Value& document);

}  // namespace evenstep::internal
