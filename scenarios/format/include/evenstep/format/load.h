#pragma once
/// The files of a scenario as one table: `extends`, `expect_append` and `--set` applied, every value with the place where
/// it was written.

#include <string>
#include <vector>

#include "evenstep/format/document.h"

namespace evenstep::internal {

inline constexpr std::int64_t kScenarioFormat = 1;
inline constexpr std::int64_t kMostScenarioBytes = 1 << 20;  // the largest of ours has 10 kB
inline constexpr std::size_t kMostExtendsDepth = 16;

/// Base tables first, in the order of `extends`; a later one wins. Tables merge key by key, lists replace.
Value load_document(const std::string& path, Errors& errors);

/// "timing.visualization=22.2 ms", "device.0.rate=500 Hz", "device.left.rate=500 Hz" (by name). The place of the value is
/// the assignment itself.
void apply_override(Value& document, const std::string& assignment, Errors& errors);

/// Puts a value at such a path; its place stands for the path's. False with an error where there is no such list element.
bool set_value(Value& document, std::string_view path, Value value, Errors& errors);

/// A path in a scenario counts from the file that names it, one on the command line from the working directory.
std::string path_from(const Value& path);

}  // namespace evenstep::internal
