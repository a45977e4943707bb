#include "src/growth_values.h"

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

std::vector<std::pair<const char*, GrowthInterval>> growths_of(const Metrics& metrics, const std::string& signal) {
  std::vector<std::pair<const char*, GrowthInterval>> growths;
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

}  // namespace evenstep
