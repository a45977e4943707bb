#include "writers/texts/study_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace evenstep::internal {

std::string aligned(const std::vector<StudyRow>& rows) {
  std::array<std::size_t, std::tuple_size_v<StudyRow>> widths{};
  for (const StudyRow& row : rows) {
    const bool reason = row[5].empty();
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (c != 4 || !reason) widths[c] = std::max(widths[c], row[c].size());
    }
  }
  std::string out;
  for (const StudyRow& row : rows) {
    std::string line = "  ";
    for (std::size_t c = 0; c < row.size(); ++c)
      line += row[c] + std::string(row[c].size() < widths[c] ? widths[c] - row[c].size() + 2 : 2, ' ');
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  return out;
}

std::string step_text(double seconds) {
  return seconds >= 0.9995e-3 ? fmt::format("{:.4g} ms", seconds * 1e3) : fmt::format("{:.4g} us", seconds * 1e6);
}

std::string cost_text(const StudyCost& cost, const std::vector<std::string>& machines, const std::string& own) {
  const std::string text = fmt::format("{:.3g} ({:.3g} .. {:.3g})", cost.median, cost.min, cost.max);
  const auto at = std::find(machines.begin(), machines.end(), own);
  return at == machines.end() ? text : fmt::format("{} #{}", text, at - machines.begin() + 1);
}

std::string machine_text(const std::string& machine, std::int64_t cpus) {
  return cpus == 0 ? machine : fmt::format("{}, {} processors", machine, cpus);
}

Json json_of(const StudyCost& cost) {
  return {{"min", json_number(cost.min)}, {"median", json_number(cost.median)}, {"max", json_number(cost.max)}};
}

}  // namespace evenstep::internal
