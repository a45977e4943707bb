#pragma once
/// `evenstep shrink`: from a scenario that fails to the smallest timing that still fails. A timing is a list of lengths
/// (each visualization, each step, the gaps before them, the number of steps of a segment); a nominal timing has one length
/// of each kind; what differs is a perturbation. First the fewest perturbations are looked for, then the smallest ones.
///
///   fewest    ddmin (Zeller and Hildebrandt, IEEE Trans. Softw. Eng. 28, 2002): a set that fails and of which no single
///             perturbation can be left out. There may be a smaller one that it does not find.
///   smallest  each one in turn by bisection between nominal (passes) and what it was (fails), to 1 ns or one step. That is
///   its
///             least size if what fails goes on failing when it grows.
///
/// Every candidate is judged as the scenario that would be written for it: a recording to replay, nothing else about time.

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
  std::optional<std::int64_t> expect_line;  ///< the expectation that begins there; default: the first that fails
  std::int64_t max_runs = 2000;
  std::string folder;  ///< for <name>-shrunk.toml, .csv and what else the scenario names
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(std::int64_t runs, std::size_t perturbations)> progress;
};

/// A length that is not nominal.
struct Perturbation {
  enum class Kind { count, visualization, visualization_gap, step, step_gap } kind = Kind::step;
  std::size_t segment = 0;     ///< 0 for a step beside which a visualization may run: then steps are counted through
  std::size_t step = 0;        ///< in its segment
  std::int64_t nominal = 0;    ///< ns; of `count`, steps
  std::int64_t deviation = 0;  ///< the same; never 0
};
/// "step 3 of segment 12: 5482222 ns instead of 1482222 ns"
std::string text(const Perturbation& perturbation);

struct ShrinkOutcome {
  ExitCode exit = ExitCode::pass;
  std::vector<Diagnostic> errors;  ///< of the scenario, or why there is nothing to shrink
  std::string failure;             ///< it failed, but not when replayed; or files could not be written
  ExpectationResult before, after;
  std::size_t perturbations_before = 0;
  std::vector<Perturbation> perturbations;
  Duration duration_before, duration;
  std::int64_t runs = 0;
  bool minimal = true;  ///< false: --max-runs ended the search
  std::string file;     ///< the scenario
};
/// Deterministic. Writes nothing unless it succeeds.
ShrinkOutcome shrink_scenario(const std::string& path, const ShrinkOptions& options);

}  // namespace evenstep
