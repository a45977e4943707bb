#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "evenstep/reports/measures.h"
#include "evenstep/reports/writers.h"

namespace evenstep {
namespace {

std::string growth_of(const BinnedError& error) { return std::string(error.name) + "_growth"; }
std::string least_growth_of(const BinnedError& error) { return growth_of(error) + "_min"; }

/// The curves of a fit depend only on the times of the bins, which most signals of a run have in common.
using GrowthFits = std::map<std::vector<double>, GrowthFit>;

/// A signal goes through some dozens of operations on doubles, each off by up to half a unit in the last place. An error
/// below the sum of these is rounding, whose size says nothing about the run; it counts as this large.
constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();

void add_growths(const std::vector<BinRow>& rows, GrowthFits& fits, std::map<std::string, double>& values) {
  double largest = 0;
  for (const BinRow& row : rows) largest = std::max(largest, row.largest);
  for (const BinnedError& error : kBinnedErrors) {
    std::vector<double> t_s, rms;
    for (const BinRow& row : rows) {
      const std::optional<double> value = error.rms(row);
      if (!value) continue;
      t_s.push_back((row.from_s + row.to_s) / 2);
      rms.push_back(std::max(*value, kRounding * largest));
    }
    if (rms.empty()) continue;
    const auto interval = fits.try_emplace(t_s, t_s).first->second(rms);
    if (!interval) continue;
    values[growth_of(error)] = interval->high;
    values[least_growth_of(error)] = interval->low;
  }
}

}  // namespace

void add_growths(const RunRecord& run, Metrics& metrics) {
  GrowthFits fits;
  for (const auto& [signal, rows] : bins(run)) add_growths(rows, fits, metrics[signal]);
}

bool is_growth(std::string_view metric) {
  return std::any_of(kBinnedErrors.begin(), kBinnedErrors.end(), [&](const BinnedError& error) {
    return metric == growth_of(error) || metric == least_growth_of(error);
  });
}

std::vector<std::pair<std::string_view, GrowthInterval>> growths_of(const Metrics& metrics, const std::string& signal) {
  std::vector<std::pair<std::string_view, GrowthInterval>> growths;
  const auto values = metrics.find(signal);
  if (values == metrics.end()) return growths;
  for (const BinnedError& error : kBinnedErrors) {
    const auto high = values->second.find(growth_of(error));
    const auto low = values->second.find(least_growth_of(error));
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
