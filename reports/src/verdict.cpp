#include "evenstep/reports/verdict.h"

namespace evenstep {

ExpectationResult::Verdict worst(const std::vector<ExpectationResult>& results) {
  auto verdict = ExpectationResult::Verdict::pass;
  for (const ExpectationResult& result : results) {
    if (result.verdict > verdict) verdict = result.verdict;  // the enum is declared in the order pass, fail, error
  }
  return verdict;
}

}  // namespace evenstep
