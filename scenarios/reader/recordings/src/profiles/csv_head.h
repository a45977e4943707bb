#pragma once
/// How a CSV is written: which of its lines is the header, what separates cells, and how numbers are written.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/recordings/profile.h"

namespace evenstep::internal {

struct CsvHead {
  std::int64_t line = 0;  ///< of the header, from 1; 0: there is none
  char separator = ',';
  char decimal = '.';              ///< the other one of . and , may stand between thousands
  std::vector<std::string> cells;  ///< of the header
  std::string why;                 ///< why this line was taken: "its columns are known"
};

/// Looks at the first 64 KiB. Tools' lines may come before the header: comments (//, #), notices, tables of another kind.
/// It is the line that `options` name or whose columns they name, else the first one whose columns are known, else the first
/// one that has as many cells as the line after it.
CsvHead find_csv_head(std::string_view first_bytes, const ProfileOptions& options);

/// Splits a line at its separators. "" within quotes is a quote. False if a quote is still open at the end.
bool split_quoted(std::string_view line, char separator, std::vector<std::string>& cells);

/// A number as decimal_time_ns takes it: without blanks, apostrophes and separators between thousands, with a decimal point.
std::string plain_number(std::string_view text, char decimal);

}  // namespace evenstep::internal
