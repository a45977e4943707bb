#pragma once
/// `evenstep shrink`: finds the smallest timing with which a failing scenario still fails. A timing is a list of lengths
/// (each visualization, each step, the gaps before them, the number of steps of a segment). A nominal timing has one length
/// of each kind; every length that differs from it is a perturbation. The search is first for the fewest perturbations, then
/// for the smallest.
///
///   fewest    First each one alone, the largest first, until half of the runs are spent. If none fails alone, ddmin (Zeller
///             and Hildebrandt, IEEE Trans. Softw. Eng. 28, 2002): a set that fails and of which no single perturbation can
///             be left out. There may be a smaller one that it does not find.
///   smallest  each one in turn by bisection between nominal (passes) and what it was (fails), to 1 ns or one step. That is
///             its least size, provided that a larger perturbation fails as well.
///
/// Every candidate is judged as the scenario that would be written for it: with a recording to replay as its only timing.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/harness/run.h"

namespace evenstep {

struct ShrinkOptions {
  std::vector<std::string> set;
  std::optional<std::uint64_t> seed;
  Registry registry;                        ///< the parts that the program brings along
  std::optional<std::int64_t> expect_line;  ///< the expectation that begins there; default: the first that fails
  std::int64_t max_runs = 2000;
  std::string folder;  ///< for <name>-shrunk.toml, its .csv and other files that the scenario names
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(std::int64_t runs, std::size_t perturbations)> progress;
};

/// A length that differs from the nominal one, or simulated time that the loop dropped before a step.
struct Perturbation {
  enum class Kind { count, visualization, visualization_gap, step, step_gap, dropped } kind = Kind::step;
  std::size_t segment = 0;     ///< 0 for a step of a concurrent timing, whose steps are numbered over the whole run
  std::size_t step = 0;        ///< number within its segment
  std::int64_t nominal = 0;    ///< ns; for `count` and `dropped`, a number of steps
  std::int64_t deviation = 0;  ///< in the same unit; never 0
};
/// "step 3 of segment 12: 5482222 ns instead of 1482222 ns"
std::string text(const Perturbation& perturbation);

struct ShrinkOutcome {
  ExitCode exit = ExitCode::pass;
  std::vector<Diagnostic> errors;  ///< errors of the scenario, or why there is nothing to shrink
  std::string failure;             ///< the run failed, but not when replayed; or files could not be written
  ExpectationResult before, after;
  std::size_t perturbations_before = 0;
  std::vector<Perturbation> perturbations;
  Duration duration_before, duration;
  std::int64_t runs = 0;
  bool minimal = true;  ///< false: --max-runs ended the search
  std::string file;     ///< the scenario that was written
};
/// Deterministic. Writes nothing unless it succeeds.
ShrinkOutcome shrink_scenario(const std::string& path, const ShrinkOptions& options);

}  // namespace evenstep
