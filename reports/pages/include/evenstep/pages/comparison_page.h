#pragma once
/// What `evenstep compare` found, as a page.

#include <string>

#include "evenstep/reports/comparison_record.h"

namespace evenstep {

/// `command` makes the page again.
std::string comparison_page(const ComparisonRecord& record, const std::string& command);

}  // namespace evenstep
