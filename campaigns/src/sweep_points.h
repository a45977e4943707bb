#pragma once
/// The points of a sweep as scenarios.

#include <string>
#include <vector>

#include "evenstep/format/document.h"
#include "evenstep/reports/sweep_record.h"

namespace evenstep::internal {

class SweepPoints {
 public:
  /// Reads the scenario without its points; errors are in `errors`, and then nothing else may be asked.
  SweepPoints(const std::string& path, const std::vector<std::string>& set, std::vector<Diagnostic>& errors);

  const SweepHeader& header() const { return header_; }
  SweepHeader& header() { return header_; }
  /// Errors of every combination, each once.
  std::vector<Diagnostic> check() const;
  ReadResult read(std::int64_t point) const;
  /// The line of a run of it, without its end; empty if it was interrupted.
  std::string run(std::int64_t point, const std::atomic<bool>* interrupted) const;

 private:
  std::string path_;
  Value document_;  // without [sweep]
  SweepHeader header_;
  std::vector<Place> axis_places_;
};

}  // namespace evenstep::internal
