#pragma once
/// The limits of an expectation in readable form, for the verdict table and JUnit.

#include <string>

#include "evenstep/reports/verdict.h"

namespace evenstep::internal {

/// "5.44 step"; "no sample" if nothing was judged.
std::string value_text(const ExpectationResult& result);
/// The distance to the nearest limit, positive if the limit holds: "0.4".
std::string margin_text(const ExpectationResult& result);
std::string verdict_text(const ExpectationResult& result);

}  // namespace evenstep::internal
