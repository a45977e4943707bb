#include "evenstep/recordings/motion_csv.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "evenstep/text/csv_rows.h"
#include "evenstep/text/text_file.h"

namespace evenstep::internal {
namespace {

constexpr double kMost_s = 1e6;
constexpr double kMost_m = 1e3;  // more than any hand moves; this finds files that are in mm

/// A finite number within +-most.
bool number(CsvRows& rows, std::size_t index, double most, double& value) {
  const std::string_view text = rows.cell(index);
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec == std::errc{} && result.ptr == text.data() + text.size() && std::abs(value) <= most) return true;
  rows.error(index, fmt::format("'{}' is not a number between -{} and {}", text, most, most));
  return false;
}

/// Computed in double: for 1e6 s its rounding, 2^-53, is 0.1 ns.
RealTime time_of(double t_s) { return {static_cast<std::int64_t>(std::floor(t_s * 1e9 + 0.5))}; }

void read_row(CsvRows& rows, std::vector<std::pair<RealTime, glm::dvec3>>& out) {
  double t_s = 0;
  glm::dvec3 position{0};
  if (!rows.split(4) || !number(rows, 0, kMost_s, t_s)) return;
  for (int axis = 0; axis < 3; ++axis) {
    if (!number(rows, static_cast<std::size_t>(axis) + 1, kMost_m, position[axis])) return;
  }
  const RealTime time = time_of(t_s);
  if (!out.empty() && time <= out.back().first)
    return rows.error(0, fmt::format("{} s is not later than the row before, by 1 ns or more", rows.cell(0)));
  out.emplace_back(time, position);
}

}  // namespace

MotionCsv parse_motion_csv(const std::string& text, const std::string& name) {
  RecordedMotion motion;
  std::vector<Diagnostic> errors;
  CsvRows rows(text, name, errors);
  if (rows.header("t_s,x_m,y_m,z_m")) {
    while (rows.next()) read_row(rows, motion.rows);
    if (motion.rows.empty() && errors.empty()) errors.push_back({name, 1, 1, "no rows"});
  }
  if (!errors.empty()) return Failure(std::move(errors));
  return motion;
}

MotionCsv read_motion_csv(const std::string& path) {
  const Result<std::string> file = read_text_file(path, kMostCsvBytes);
  if (!file) return Failure(std::vector<Diagnostic>{{path, 0, 0, file.error()}});
  return parse_motion_csv(*file, path);
}

}  // namespace evenstep::internal
