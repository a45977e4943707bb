#pragma once
/// What an expectation asks for, as people read it. Shared by the verdict table and JUnit.

#include <string>

#include "evenstep/reports/verdict.h"

namespace evenstep::internal {

/// "<= 1e-06 step", ">= 4 step", "= 0", "1 .. 2 ms"
std::string limit_text(const ExpectationResult& result);
/// "5.44 step"; "no sample" where nothing was judged.
std::string value_text(const ExpectationResult& result);
/// Distance to the nearest limit, positive inside: "0.4".
std::string margin_text(const ExpectationResult& result);
std::string verdict_text(const ExpectationResult& result);

}  // namespace evenstep::internal
