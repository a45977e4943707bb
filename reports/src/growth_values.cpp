#include "src/growth_values.h"

#include <fmt/format.h>

#include <set>

#include "evenstep/reports/writers.h"

namespace evenstep {
namespace internal {

std::map<std::string, double> growth_values(const std::vector<BinRow>& rows, GrowthFits& fits) {
  std::map<std::string, double> values;
  for (const BinnedError& error : kBinnedErrors) {
    std::vector<double> t_s, rms;
    for (const BinRow& row : rows) {
      const std::optional<double> value = error.rms(row);
      if (!value) continue;
      t_s.push_back((row.from_s + row.to_s) / 2);
      rms.push_back(*value);
    }
    if (rms.empty()) continue;
    const auto interval = fits.try_emplace(t_s, t_s).first->second(rms);
    if (!interval) continue;
    values[std::string(error.name) + "_growth"] = interval->high;
    values[std::string(error.name) + "_growth_min"] = interval->low;
  }
  return values;
}

}  // namespace internal

std::vector<std::pair<std::string_view, GrowthInterval>> growths_of(const Metrics& metrics, const std::string& signal) {
  std::vector<std::pair<std::string_view, GrowthInterval>> growths;
  const auto values = metrics.find(signal);
  if (values == metrics.end()) return growths;
  for (const BinnedError& error : kBinnedErrors) {
    const auto high = values->second.find(std::string(error.name) + "_growth");
    const auto low = values->second.find(std::string(error.name) + "_growth_min");
    if (high != values->second.end() && low != values->second.end())
      growths.push_back({error.name, {low->second, high->second}});
  }
  return growths;
}

std::string growth_lines(const Metrics& metrics, const std::vector<ExpectationResult>& results) {
  std::set<std::string> asserted;
  for (const ExpectationResult& result : results) asserted.insert(result.signal);
  std::string lines;
  for (const std::string& signal : asserted) {
    std::string line;
    for (const auto& [error, interval] : growths_of(metrics, signal))
      line += fmt::format("{} {} {}", line.empty() ? "" : ",", error, growth_text(interval));
    if (!line.empty()) lines += fmt::format("growth       {}:{}\n", signal, line);
  }
  return lines;
}

}  // namespace evenstep
