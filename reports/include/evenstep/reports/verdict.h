#pragma once
/// The judgement of expectations, ready to print.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace evenstep {

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
  enum class Verdict { pass, fail, error } verdict = Verdict::pass;
};

/// The worst of several verdicts: error > fail > pass.
ExpectationResult::Verdict worst(const std::vector<ExpectationResult>& results);

}  // namespace evenstep
