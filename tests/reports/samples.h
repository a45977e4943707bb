#pragma once
/// Results and a record that contain everything that is difficult for text formats.

#include <cmath>

#include "evenstep/reports/verdict.h"
#include "evenstep/reports/writers.h"
#include "synthetic.h"

namespace evenstep::synthetic {

inline constexpr const char* kNastyText =
    "quote \" back\\slash <tag attr='x'> & µ 日本 \x01\x1b[31m <script>alert(1)</script> ]]> \u202eright-to-left\u200f %0A "
    "newline\n100 %";

inline RunRecord nasty_run() {
  RunRecord run = reference_run({1'000'000'000});
  run.scenario = kNastyText;
  run.file = "scenarios/a&b.toml";
  run.seed = 18446744073709551615ULL;
  run.trace_hash = 0xabc;
  run.left_out = {"local stiffness: not asked for", kNastyText};
  run.strategies[1].devices[0].steps.back().position_m[0] = NAN;
  run.strategies[2].solver.name = kNastyText;
  run.strategies[2].underruns = {{200, 0, UnderrunRow::Side::interaction, {1'234'567}, "gate"},
                                 {201, 0, UnderrunRow::Side::force, {1}, "hold"}};
  return run;
}

inline std::vector<ExpectationResult> nasty_results() {
  using Verdict = ExpectationResult::Verdict;
  ExpectationResult pass{"scenarios/a&b.toml", 12,    1,      "left.interaction.direct",
                         "velocity_jump",      4.995, "step", 4.0,
                         std::nullopt,         false, "",     "",
                         Verdict::pass};
  ExpectationResult fail{"scenarios/a&b.toml",
                         20,
                         1,
                         "left.force.µ",
                         "schedule_latency",
                         13.0,
                         "ms",
                         std::nullopt,
                         12.842,
                         false,
                         kNastyText,
                         "",
                         Verdict::fail};
  ExpectationResult none{"scenarios/a&b.toml",
                         31,
                         1,
                         "left.force.paper",
                         "error_at_stop",
                         std::nullopt,
                         "mm",
                         1.0,
                         1.0,
                         false,
                         "",
                         "no sample was judged",
                         Verdict::error};
  ExpectationResult known{"scenarios/a&b.toml", 40, 1, "run", "left_out", 2.0, "", 0.0, 1.0, true, "", "", Verdict::pass};
  std::vector<ExpectationResult> results{pass, fail, none, known};
  for (ExpectationResult& result : results) result.pattern = result.signal;
  return results;
}

inline JunitSuite nasty_suite() {
  const RunRecord run = nasty_run();
  return {run.scenario, run.file,        run.seed, run.clock, run.trace_hash, nasty_results(), JunitSuite::Whole::silent,
          "",           "evenstep run x"};
}

inline std::size_t occurrences(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

}  // namespace evenstep::synthetic
