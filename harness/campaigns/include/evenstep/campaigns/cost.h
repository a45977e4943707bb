#pragma once
/// What each part of a run costs on this machine: for a part that is kept, its share; for a part that the scene leaves out,
/// what it would add.
///
/// Everything is measured in interleaved pairs, with the part and without it, by the CPU time of the whole process: a busy
/// neighbour then widens the interval instead of moving the median. Both sides of a pair must give the same bits.
///   kept       100 (with - without) / with
///   left out   100 (with - without) / without

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"

namespace evenstep {

struct CostOptions {
  int step_pairs = 31;          ///< of a part of the solver: pairs of some steps each
  int run_pairs = 9;            ///< of a part of the run: pairs of runs
  double steps_seconds = 4e-3;  ///< CPU time that one side of a pair of steps takes, about
  double run_seconds = 0.4;     ///< CPU time that one run takes, about; a longer one is cut short
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(const std::string& part)> progress;
};

/// The median of the pairs and an interval that holds the true median with at least 95 % (sign test; fewer than six pairs
/// cannot be that sure: then the least and the largest).
struct Measured {
  double median = 0, low = 0, high = 0;
  bool contains_0() const { return low <= 0 && high >= 0; }
};
Measured measured(std::vector<double> of_pairs);

struct PartCost {
  enum class Bits { not_compared, equal, differ };

  std::string part;     ///< "energy"
  bool is_kept = true;  ///< otherwise the scene leaves it out
  std::string why;      ///< who asks for it, or why it is left out or not measured
  std::string of;       ///< what `percent` is of: "a step", "the run"
  std::optional<Measured> percent;
  std::optional<Measured> cpu_ms, resident_MiB;  ///< of a library: once per process
  Bits bits = Bits::not_compared;
  std::string compared;  ///< "forces and particles of 620 steps"
};

struct CostReport {
  std::string steps, run;  ///< what was measured, in words
  std::vector<PartCost> parts;
  bool same_bits() const;  ///< of all parts
};

/// Measures all parts of a scenario, which must not be a [case]. Throws RunFailure and SolverError for a scenario that
/// cannot run to its end. If it is interrupted, the report ends early.
CostReport measure_costs(const Scenario& scenario, const CostOptions& options);

/// A table for people; a JSON object (docs/reference/metrics.md).
std::string cost_text(const CostReport& report);
std::string cost_json(const CostReport& report);

}  // namespace evenstep
