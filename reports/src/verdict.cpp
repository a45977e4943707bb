#include "evenstep/reports/verdict.h"

namespace evenstep {

ExpectationResult::Verdict worst(const std::vector<ExpectationResult>& results) {
  auto verdict = ExpectationResult::Verdict::pass;
  for (const ExpectationResult& result : results) {
    if (result.verdict > verdict) verdict = result.verdict;  // declared in this order: pass, fail, error
  }
  return verdict;
}

}  // namespace evenstep
