#pragma once
/// Loads the files of a scenario into one table, with `extends`, `expect_append` and `--set` applied. Every value keeps the
/// place where it was written.

#include <string>
#include <vector>

#include "evenstep/format/document.h"

namespace evenstep::internal {

inline constexpr std::int64_t kScenarioFormat = 1;
inline constexpr std::int64_t kMostScenarioBytes = 1 << 20;  // the largest of ours has 10 kB
inline constexpr std::size_t kMostExtendsDepth = 16;

/// Base files come first, in the order of `extends`, and a later value replaces an earlier one. Tables are merged key by
/// key; lists are replaced as a whole.
Value load_document(const std::string& path, Errors& errors);

/// Applies an assignment such as "timing.visualization=22.2 ms", "device.0.rate=500 Hz" or "device.left.rate=500 Hz" (by
/// name). The place of the value is the assignment itself.
void apply_override(Value& document, const std::string& assignment, Errors& errors);

/// Sets the value at a path of that form; errors in the path are reported at the place of the value. Returns false, with an
/// error, if there is no such list element.
bool set_value(Value& document, std::string_view path, Value value, Errors& errors);

/// The path that a value names: one written in a scenario is relative to the file that contains it, one given on the command
/// line to the working directory.
std::string path_from(const Value& path);

}  // namespace evenstep::internal
