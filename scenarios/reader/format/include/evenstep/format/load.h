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
/// key; lists are replaced as a whole, and a note says so if they hold tables. What `expect_append` adds in any of the files
/// stays, behind `expect`.
Value load_document(const std::string& path, Errors& errors);

/// Applies assignments such as "timing.visualization=22.2 ms", "device.0.rate=500 Hz" or "device.left.rate=500 Hz" (by
/// name), one after the other. The place of a value is its assignment. The same path may come twice, and the later value
/// counts; it is an error if an assignment takes the effect of another one that names the key differently (by index and by
/// name, or a key within it).
void apply_overrides(Value& document, const std::vector<std::string>& assignments, Errors& errors);

/// The path with every element of a list by its index: "device.left.rate" becomes "device.0.rate". From the first part on
/// that the document does not have, it is left as it is.
std::string indexed_path(const Value& document, std::string_view path);
/// Whether a path, as indexed_path() returns it, is `around` or a key within it.
bool is_within(std::string_view path, std::string_view around);

/// Sets the value at a path of that form; errors in the path are reported at the place of the value. Returns false, with an
/// error, if there is no such list element.
bool set_value(Value& document, std::string_view path, Value value, Errors& errors);

/// The path that a value names: one written in a scenario is relative to the file that contains it, one given on the command
/// line to the working directory.
std::string path_from(const Value& path);

}  // namespace evenstep::internal
