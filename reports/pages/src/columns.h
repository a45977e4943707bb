#pragma once
/// Columns of numbers for a page, made small: each is rounded to a quantum of its own, its first or second differences are
/// kept as 32 bits, all bytes of one significance together, and zlib packs the whole. Times in ns stay exact.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evenstep/reports/json.h"

namespace evenstep::internal {

class Columns {
 public:
  /// Both give the number of the column in the page; equal columns have the same number.
  int add(std::span<const std::int64_t> values);
  /// Values that are not finite become null in the page. The quantum is 2^-40 of the values' range, or 2^-29 of the largest
  /// difference of neighbours if that is more.
  int add(std::span<const double> values);

  /// {"list": [{"count", "first", "order", "quantum", "gaps"}], "bytes": base64, "packed": whether zlib packed them}
  Json json() const;

 private:
  int put(const std::vector<std::int64_t>& values, double quantum, std::vector<std::size_t> gaps);
  Json list_ = Json::array();
  std::string bytes_;
  std::vector<std::string> stored_;  ///< what is in `bytes_`, by column
};

std::string base64(std::string_view bytes);

}  // namespace evenstep::internal
