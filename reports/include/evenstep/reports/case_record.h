#pragma once
/// The results of a case of the catalogue: a row of cells for each method and solver, with a cell for each value of the
/// sweep. A method that fails is a result too: the cell says what happened, and the strip shows it.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/measures.h"

namespace evenstep {

enum class CellStatus {
  ok,           ///< ran to its end, within the tolerances of its kind
  damped,       ///< lost energy that physics would keep; CaseCell::shown is the share that is left
  drifting,     ///< differs from the exact answer by more than its kind tolerates; CaseCell::shown is by how much
  refused,      ///< the solver refused to run it; CaseCell::detail says why
  diverged,     ///< not finite, or grown beyond all bounds; CaseCell::steps is the first bad step
  unavailable,  ///< this solver does not have this method, or its device is not there
  interrupted   ///< not run, or not to its end, because the case was stopped; the rest of the cell has no meaning
};
const char* name_of(CellStatus status);

struct CaseCell {
  double value = 0;  ///< the value of the sweep
  CellStatus status = CellStatus::interrupted;
  std::optional<double> shown;
  std::string detail;                     ///< refused, unavailable: the message of the solver
  std::int64_t steps = 0;                 ///< steps run; diverged: the first bad step
  std::uint64_t digest = 0;               ///< chained over the states and forces of the even schedule
  bool schedule_differs = false;          ///< the irregular schedule gave a different digest
  std::map<std::string, double> metrics;  ///< those of its kind (docs/reference/metrics.md)
};

struct CaseRow {
  std::string method, solver;
  std::vector<CaseCell> cells;
};

struct CaseRecord {
  std::string kind;
  std::string value_name, value_unit;  ///< "stiffness", "N/m"; the unit may be empty
  std::vector<CaseRow> rows;
};

/// A range that includes both of its ends.
struct ValueRange {
  double least = 0, most = 0;
};

/// One signal "case.<method>.<solver>" per row, over its cells in the range `at` (default: all): how often each status and
/// `schedule_difference` occur, and the largest value of each metric of the kind (the least if its name ends with `_min`). A
/// row without cells in the range has no metrics.
Metrics measure(const CaseRecord& record, const std::optional<ValueRange>& at = std::nullopt);

/// method,solver,value,status,shown,steps,digest,schedule_differs, one column per metric, detail.
std::string cells_csv(const CaseRecord& record);
/// The decade strip as text: a line per method and solver, a column per value.
std::string case_table(const CaseRecord& record);
/// The decade strip as a picture.
std::string case_strip_svg(const CaseRecord& record, const std::string& title);

}  // namespace evenstep
