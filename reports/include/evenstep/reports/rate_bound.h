#pragma once
/// How large a rate can still be after so many runs.

#include <cstdint>

namespace evenstep {

/// Upper end of the one-sided interval of Clopper and Pearson (Biometrika 26, 1934) for a probability, after `hits` in `runs`
/// independent runs: the p with P(at most `hits`) = 1 - confidence, a quantile of Beta(hits + 1, runs - hits). 1 for
/// hits = runs, and without runs. 0 <= hits <= runs, confidence in (0, 1).
double rate_at_most(std::int64_t hits, std::int64_t runs, double confidence = 0.95);

}  // namespace evenstep
