#include "evenstep/reports/limit_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace evenstep {
namespace {

std::string with_unit(std::string number, const std::string& unit) { return unit.empty() ? number : number + ' ' + unit; }

}  // namespace

std::string limit_text(const ExpectationResult& result) {
  if (result.min && result.max && *result.min == *result.max)
    return with_unit(fmt::format("= {}", *result.min), result.unit);
  if (result.min && result.max) return with_unit(fmt::format("{} .. {}", *result.min, *result.max), result.unit);
  if (result.min) return with_unit(fmt::format(">= {}", *result.min), result.unit);
  if (result.max) return with_unit(fmt::format("<= {}", *result.max), result.unit);
  return "";
}

std::string value_text(const ExpectationResult& result) {
  return result.value ? with_unit(fmt::format("{:.6g}", *result.value), result.unit) : "no sample";
}

std::string margin_text(const ExpectationResult& result) {
  if (!result.value || (!result.min && !result.max)) return "";
  double margin = std::numeric_limits<double>::infinity();
  if (result.min) margin = std::min(*result.value - *result.min, margin);  // NaN first: min keeps it
  if (result.max) margin = std::min(*result.max - *result.value, margin);
  // What holds in the base unit may miss the limit by a rounding in this one.
  if (result.verdict == ExpectationResult::Verdict::pass && !result.expect_fail) margin = std::max(margin, 0.0);
  return fmt::format("{:.3g}", margin);
}

std::string verdict_text(const ExpectationResult& result) {
  switch (result.verdict) {
    case ExpectationResult::Verdict::skipped:
      return "not judged";
    case ExpectationResult::Verdict::degraded:
      return "DEGRADED";
    case ExpectationResult::Verdict::pass:
      return result.expect_fail ? "pass (fails as expected)" : "pass";
    case ExpectationResult::Verdict::fail:
      return result.expect_fail ? "FAIL (was expected to fail)" : "FAIL";
    case ExpectationResult::Verdict::error:
      return "ERROR";
  }
  return "ERROR";
}

}  // namespace evenstep
