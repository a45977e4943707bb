#pragma once
/// How large a failure rate can still be after a given number of runs.

#include <cstdint>

namespace evenstep {

/// The upper end of the one-sided Clopper-Pearson interval (Biometrika 26, 1934) for a probability after `hits` in `runs`
/// independent runs: the p with P(at most `hits`) = 1 - confidence, a quantile of Beta(hits + 1, runs - hits). It is 1 if
/// hits = runs, also if both are 0. 0 <= hits <= runs, confidence in (0, 1).
double rate_at_most(std::int64_t hits, std::int64_t runs, double confidence = 0.95);

}  // namespace evenstep
