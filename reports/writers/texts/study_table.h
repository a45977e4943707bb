#pragma once
/// What the tables of both studies have in common.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "evenstep/reports/json.h"
#include "evenstep/reports/study_record.h"

namespace evenstep::internal {

/// A row. The numbers begin in column 4. If a cell was not measured, column 4 has the reason and column 5 is empty.
using StudyRow = std::array<std::string, 9>;

/// The rows below each other, columns as wide as their widest text. A reason may extend over the columns after it.
std::string aligned(const std::vector<StudyRow>& rows);

std::string step_text(double seconds);  ///< "2.222 ms", "69.44 us"
/// "0.28 (0.27 .. 0.31)"; with several machines also the number of the own one, "#2".
std::string cost_text(const StudyCost& cost, const std::vector<std::string>& machines, const std::string& own);
Json json_of(const StudyCost& cost);  ///< min, median, max
/// "AMD EPYC, 4 processors"; the text of several machines (no processors) stays as it is.
std::string machine_text(const std::string& machine, std::int64_t cpus);

}  // namespace evenstep::internal
