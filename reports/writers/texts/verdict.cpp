#include "evenstep/reports/verdict.h"

namespace evenstep {

ExpectationResult::Verdict worst(const std::vector<ExpectationResult>& results) {
  auto verdict = ExpectationResult::Verdict::skipped;
  for (const ExpectationResult& result : results) {
    if (result.verdict > verdict) verdict = result.verdict;  // the enum is declared from the best to the worst
  }
  return verdict;
}

}  // namespace evenstep
