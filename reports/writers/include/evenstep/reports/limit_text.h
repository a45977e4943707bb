#pragma once
/// The limits of an expectation in readable form, for tables, pages and JUnit.

#include <string>

#include "evenstep/reports/verdict.h"

namespace evenstep {

/// "<= 1e-06 step", ">= 4 step", "= 0", "1 .. 2 ms"
std::string limit_text(const ExpectationResult& result);
/// "5.44 step"; "no sample" if nothing was judged.
std::string value_text(const ExpectationResult& result);
/// The distance to the nearest limit, positive if the limit holds: "0.4".
std::string margin_text(const ExpectationResult& result);
std::string verdict_text(const ExpectationResult& result);

}  // namespace evenstep
