#pragma once
/// The expectations of a run as a table, each with a bar that shows how near to its limit it is.

#include <span>

#include "evenstep/pages/html.h"
#include "evenstep/reports/verdict.h"

namespace evenstep::internal {

/// Lines of `file` are named by their number alone, lines of other files with the file's name.
Html expectations_table(std::span<const ExpectationResult> results, const std::string& file);

/// The limit is at the same place in every bar, and values that hold are on its shaded side. A value is a dot if it holds,
/// and a cross if not; a value that is off the scale is at the end of the bar.
Html margin_bar(const ExpectationResult& result);

/// The link to a line of a file that is shown on the page.
std::string line_id(const std::string& file, std::int64_t line);

}  // namespace evenstep::internal
