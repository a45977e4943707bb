#pragma once
/// What the tests of the format do and check at once. (support.h has no checks: the fuzz target uses it, too.)

#include <string>

#include "evenstep/format/scenario.h"

namespace evenstep::test {

/// The scenario that `text` is; a failed check if it is none.
Scenario good(const std::string& text, const ReadOptions& options = {});
/// What is stored as resolved.toml must be the same scenario.
void check_round_trip(const Scenario& scenario);
/// `base` with the first `from` replaced by `to`.
std::string changed(std::string base, const std::string& from, const std::string& to);

}  // namespace evenstep::test
