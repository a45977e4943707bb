#pragma once
/// The points of a sweep as scenarios.

#include <string>
#include <vector>

#include "evenstep/format/document.h"
#include "evenstep/reports/sweep_record.h"

namespace evenstep::internal {

class SweepPoints {
 public:
  /// Reads the scenario, but not its points. If there are errors, they are in `errors` and nothing else may be called.
  SweepPoints(const std::string& path, const ReadOptions& options, std::vector<Diagnostic>& errors);

  const SweepHeader& header() const { return header_; }
  SweepHeader& header() { return header_; }
  /// An error for each --set that every point sets itself, so that it has no effect.
  std::vector<Diagnostic> without_effect(const std::vector<std::string>& set) const;
  /// The errors of all combinations, each once.
  std::vector<Diagnostic> check() const;
  ReadResult read(std::int64_t point) const;
  /// The same with these faults of a swarm, instead of those that its seed leaves on.
  ReadResult read(std::int64_t point, const std::vector<std::string>& on) const;
  /// Runs a point and returns its line, without the line end; empty if it was interrupted.
  std::string run(std::int64_t point, const std::atomic<bool>* interrupted) const;

 private:
  std::string path_;
  Registry registry_;
  Value document_;  // without [sweep]
  SweepHeader header_;
  std::vector<Place> axis_places_;
  std::vector<std::string> set_by_points_;  // the keys that each point sets, as indexed_path() writes them
};

}  // namespace evenstep::internal
