#pragma once
/// What a case of the catalogue left behind: a row of cells for each method and solver, a cell for each value of the sweep.
/// The failures of a method are its results: a cell says what happened, and the strip shows it.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/measures.h"

namespace evenstep {

enum class CellStatus {
  ok,          ///< ran to its end, and within the tolerances of its kind
  damped,      ///< lost energy that physics keeps; CaseCell::shown is what is left of it
  drifting,    ///< off the exact answer by more than the kind's tolerance; CaseCell::shown is by how much
  refused,     ///< the solver said no, and why: CaseCell::detail
  diverged,    ///< not finite, or grown beyond all bounds; CaseCell::steps is the first bad step
  unavailable, ///< this solver does not have this method, or there is no such device here
  interrupted  ///< not run, or not to its end: somebody stopped the case. Of such a cell nothing else is known
};
const char* name_of(CellStatus status);

struct CaseCell {
  double value = 0;                       ///< of the sweep
  CellStatus status = CellStatus::interrupted;
  std::optional<double> shown;
  std::string detail;                     ///< refused, unavailable: the solver's words
  std::int64_t steps = 0;                 ///< run; diverged: the first bad one
  std::uint64_t digest = 0;               ///< chained over the states and forces of the even schedule
  bool schedule_differs = false;          ///< the irregular schedule gave another digest
  std::map<std::string, double> metrics;  ///< of the kind: docs/metrics.md
};

struct CaseRow {
  std::string method, solver;
  std::vector<CaseCell> cells;
};

struct CaseRecord {
  std::string kind;
  std::string value_name, value_unit;     ///< "stiffness", "N/m"; the unit may be empty
  std::vector<CaseRow> rows;
};

/// Closed at both ends.
struct ValueRange {
  double least = 0, most = 0;
};

/// One signal "case.<method>.<solver>" per row: counts of the statuses and of `schedule_difference` over the cells in `at`,
/// and of the kind's metrics the largest (the least where the name ends with `_min`). A row without cells there has none.
Metrics measure(const CaseRecord& record, const std::optional<ValueRange>& at = std::nullopt);

/// method,solver,value,status,shown,steps,digest,schedule_differs, one column per metric, detail.
std::string cells_csv(const CaseRecord& record);
/// The decade strip as text: a line per method and solver, a column per value.
std::string case_table(const CaseRecord& record);
/// The same as a picture.
std::string case_strip_svg(const CaseRecord& record, const std::string& title);

}  // namespace evenstep
