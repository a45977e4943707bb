#pragma once
/// What `evenstep compare --fail-if` says: a change that is too much.
///
///   threshold := [where] metric change { "and" change } | "verdict" | "missing" | "trace"
///   change    := "> +" number [unit] | "< -" number [unit]
///   where     := a strategy, or a signal in which * stands for any part: "*.force.phase_locked"
///
/// `metric` is one of docs/reference/metrics.md, `margin` (of expectations, as a share of their limits), or `worse`: any
/// metric, in the direction in which it gets worse. A change in % is relative to A, one in any other unit is absolute; where
/// several changes are given, all must be exceeded. `verdict` is exceeded where a verdict got worse, `missing` where
/// something of A is not there in B, `trace` where the events differ.

#include <string>
#include <vector>

#include "evenstep/text/diagnostic.h"
#include "evenstep/time/result.h"

namespace evenstep {

struct Threshold {
  std::string text;  ///< as it was given
  enum class Kind : std::uint8_t { change, worse, verdict, missing, trace } kind = Kind::change;
  std::string where, metric;  ///< `where` is empty: everywhere
  bool grows = true;          ///< "> +": exceeded by what grows more; "< -": by what shrinks more
  struct Change {
    double number = 0;  ///< >= 0
    std::string unit;   ///< "%": relative; empty: a bare number
  };
  std::vector<Change> changes;

  /// Whether the threshold applies to this figure at all. `figure_metric` is a metric, "margin", "verdict" or "trace".
  bool covers(const std::string& signal, const std::string& figure_metric) const;
  /// Whether going from `a` to `b` (in the base unit of the metric) is too much. Only for kinds `change` and `worse`.
  /// `falls_worse`, for kind `worse`: more of this metric is better.
  bool exceeded(const std::string& signal, const std::string& figure_metric, double a, double b, bool falls_worse) const;
};

/// Errors have the column in the text, what was expected, and the nearest word that is known; their file is "--fail-if".
Result<Threshold, Diagnostic> parse_threshold(const std::string& text);

/// The unit in which a figure of `evenstep compare` is measured: that of the metric, "1" for a margin.
std::string figure_unit(const std::string& signal, const std::string& metric);

}  // namespace evenstep
