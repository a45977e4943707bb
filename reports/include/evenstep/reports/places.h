#pragma once
/// Where in a run a metric gets its value: the steps or ticks that it counts, or among which it finds the largest or the
/// least. Metrics to which all samples contribute (a mean, an RMS, a fit) have no such place.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep {

struct MetricSample {
  std::int64_t index = 0;  ///< of the step or the tick, over the whole run
  RealTime at;             ///< when the step began, or the tick was due
  double amount = 0;  ///< count: by how much it is late or too early, in s. Otherwise the value, in the metric's base unit
};
/// A lead c and a latency L.
struct LeadAndLatency {
  Duration lead, latency;
};
struct MetricSamples {
  enum class Kind { count, largest, least } kind = Kind::largest;
  const char* of = "step";                    ///< or "tick"
  const char* word = "";                      ///< for a count: what these samples are, "late"
  Rows<MetricSample> samples;                 ///< in order; for a count only those that count
  LeadAndLatency now = {};                    ///< for underruns: those of the run
  std::optional<LeadAndLatency> enough = {};  ///< for underruns: those with which the count would be 0, if known
};
/// Late forces, the latest by `most`: L must be longer by that. F(n) = R(n) + L, and R(n) does not depend on L, so this is
/// exact as long as the same steps run at the same times.
void late_by(MetricSamples& late, Duration most);
/// Missing samples, the worst by `most`: c must be longer by that, and L with it, so that F(n) stays where it is.
void missing_by(MetricSamples& missing, Duration most);
/// Missing samples and late forces together, by step.
MetricSamples joined(MetricSamples missing, const MetricSamples& late);

/// Empty if the metric has no place, or if the run has no such signal.
std::optional<MetricSamples> samples_of(const RunRecord& run, const std::string& signal, const std::string& metric);

/// Fills in `first`, `worst` and `where` of a result that has failed. `base_per_unit` is the size of the result's unit in
/// the metric's base unit; `base_limit` is the limit in that unit, rounded once, so that a sample that equals it is within.
/// Without it the limit is its number times `base_per_unit`.
void locate(ExpectationResult& result, const MetricSamples& samples, double base_per_unit,
            std::optional<double> base_limit = std::nullopt);

}  // namespace evenstep
