#pragma once
/// The judgement of expectations, ready to print.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

/// A step or a device tick at which an expectation fails.
struct FailurePlace {
  std::int64_t index = 0;
  RealTime at;  ///< when the step began, or the tick was due
};

struct ExpectationResult {
  std::string file;
  std::int64_t line = 0, column = 0;
  std::string signal, metric;
  std::optional<double> value;     ///< in `unit`; empty: no sample was judged (the verdict is error)
  std::string unit;                ///< as written in the scenario ("step", "ms", "")
  std::optional<double> min, max;  ///< in `unit`
  bool expect_fail = false;
  std::string because;
  std::string detail;  ///< for errors
  /// skipped: the expectation is for the other clock. degraded: it is about how well the machine kept real time
  /// (clock = "wall") and does not hold: this run is no evidence against what was tested, nor enough evidence for it.
  enum class Verdict { skipped, pass, degraded, fail, error } verdict = Verdict::pass;
  /// For a failure of a metric that single samples decide (places.h): the first and the worst of those that break the limit,
  /// and the same in words, with what would help if that is known: "late first at step 960, 2.000 s, by 6.66 ms; ...".
  std::optional<FailurePlace> first = {}, worst = {};
  std::string where = {};
  /// The signal as written. Where it has a `*`, `signal` is the worst of those that it matches, which may be another one in
  /// the next run.
  std::string pattern = {};
};

/// The worst of several verdicts: error > fail > degraded > pass > skipped. `skipped` if nothing was judged.
ExpectationResult::Verdict worst(const std::vector<ExpectationResult>& results);

}  // namespace evenstep
