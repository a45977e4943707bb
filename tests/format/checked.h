#pragma once
/// Functions for tests of the format that also check. (Those of support.h do not, as the fuzz target uses them, too.)

#include <string>

#include "evenstep/format/scenario.h"

namespace evenstep::test {

/// The scenario in `text`. A check fails if it is not a scenario.
Scenario good(const std::string& text, const ReadOptions& options = {});
/// Checks that what is stored as resolved.toml is the same scenario.
void check_round_trip(const Scenario& scenario);
/// `base` with the first `from` replaced by `to`.
std::string changed(std::string base, const std::string& from, const std::string& to);

}  // namespace evenstep::test
