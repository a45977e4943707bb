#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "evenstep/reports/case_record.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

bool is_least(const std::string& metric) { return metric.ends_with("_min"); }

/// Combines two values of a metric; counts are added. A NaN must not be hidden by a number.
double joined(const std::string& metric, double a, double b) {
  if (metric == "device_difference") return a + b;
  if (std::isnan(a) || std::isnan(b)) return NAN;
  return is_least(metric) ? std::min(a, b) : std::max(a, b);
}

constexpr std::array kStatuses{CellStatus::ok,       CellStatus::damped,      CellStatus::drifting,   CellStatus::refused,
                               CellStatus::diverged, CellStatus::unavailable, CellStatus::interrupted};

std::map<std::string, double> measure_row(const CaseRow& row, const std::optional<ValueRange>& at) {
  std::map<std::string, double> values;
  for (const CaseCell& cell : row.cells) {
    if (at && (cell.value < at->least || cell.value > at->most)) continue;
    for (const CellStatus status : kStatuses) values[name_of(status)] += cell.status == status;
    values["cells"] += 1;
    const bool ran = cell.status != CellStatus::refused && cell.status != CellStatus::unavailable;
    if (ran) values["schedule_difference"] += cell.schedule_differs;
    for (const auto& [metric, value] : cell.metrics) {
      const auto [entry, first] = values.try_emplace(metric, value);
      if (!first) entry->second = joined(metric, entry->second, value);
    }
  }
  // Where no cell is there, "none diverged" would hold without a single step.
  const auto missing = values.find("unavailable");
  if (missing != values.end() && missing->second == values["cells"])
    return {{"cells", missing->second}, {"unavailable", missing->second}};
  return values;
}

}  // namespace

const char* name_of(CellStatus status) {
  switch (status) {
    case CellStatus::ok:
      return "ok";
    case CellStatus::damped:
      return "damped";
    case CellStatus::drifting:
      return "drifting";
    case CellStatus::refused:
      return "refused";
    case CellStatus::diverged:
      return "diverged";
    case CellStatus::unavailable:
      return "unavailable";
    case CellStatus::interrupted:
      return "interrupted";
  }
  return "";
}

Metrics measure(const CaseRecord& record, const std::optional<ValueRange>& at) {
  Metrics metrics;
  for (const CaseRow& row : record.rows) {
    std::map<std::string, double> values = measure_row(row, at);
    if (!values.empty()) metrics[fmt::format("case.{}.{}", row.method, row.solver)] = std::move(values);
  }
  return metrics;
}

std::string cells_csv(const CaseRecord& record) {
  std::set<std::string> names;
  for (const CaseRow& row : record.rows) {
    for (const CaseCell& cell : row.cells) {
      for (const auto& [metric, value] : cell.metrics) names.insert(metric);
    }
  }
  std::string csv = "method,solver,value,status,shown,steps,digest,schedule_differs";
  for (const std::string& name : names) csv += ',' + name;
  csv += ",detail\n";
  for (const CaseRow& row : record.rows) {
    for (const CaseCell& cell : row.cells) {
      csv += fmt::format("{},{},{},{},{},{},{:016x},{}", row.method, row.solver, cell.value, name_of(cell.status),
                         cell.shown ? fmt::format("{}", *cell.shown) : "", cell.steps, cell.digest,
                         cell.schedule_differs ? 1 : 0);
      for (const std::string& name : names) {
        const auto value = cell.metrics.find(name);
        csv += value == cell.metrics.end() ? "," : fmt::format(",{}", value->second);
      }
      csv += ',' + internal::csv_field(cell.detail) + '\n';
    }
  }
  return csv;
}

}  // namespace evenstep
