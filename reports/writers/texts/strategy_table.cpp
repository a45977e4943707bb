#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "evenstep/reports/writers.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

constexpr std::size_t kFigures = 7;
using FiguresOfStrategy = std::array<std::string, kFigures>;

FiguresOfStrategy figures_of(const StrategyRecord& strategy, const Metrics& metrics) {
  const auto value = [&](const DeviceRecord& device, const char* what, const char* metric) {
    return value_or_0(metrics, device.name + what + strategy.name, metric);
  };
  // Of the devices that have this value: what was not measured is no 0.
  const auto largest = [&](const char* what, const char* metric, double scale, const char* unit) {
    std::string text = "-";
    double most = 0;
    for (const DeviceRecord& device : strategy.devices) {
      const auto values = metrics.find(device.name + what + strategy.name);
      if (values == metrics.end()) continue;
      const auto found = values->second.find(metric);
      if (found == values->second.end() || !std::isfinite(found->second)) continue;
      most = std::max(most, found->second);
      text = fmt::format("{:.2f} {}", scale * most, unit);
    }
    return text;
  };
  // Forces that are played as they come have no latency, but an age.
  const std::string age = largest(".buffers.", "played_age", 1e3, "ms");
  double late = 0, missing = 0, judged = 0, saturated = 0;
  for (const DeviceRecord& device : strategy.devices) {
    late += value(device, ".force.", "underruns");
    missing += value(device, ".interaction.", "underruns");
    judged += value(device, ".interaction.", "judged");
    saturated += value(device, ".force.", "saturated") + value(device, ".interaction.", "saturated");
  }
  const auto of = [&](double count) { return count > 0 ? fmt::format("{} of {}", count, judged) : std::string("0"); };
  return {strategy.name,
          age == "-" ? largest(".buffers.", "latency", 1e3, "ms") : "~" + age,
          largest(".interaction.", "velocity_jump", 1e6, "um"),
          largest(".force.", "jump_max", 1e3, "mN"),
          of(late),
          of(missing),
          fmt::format("{}", saturated)};
}

}  // namespace

std::string strategy_table(const RunRecord& run, const Metrics& metrics) {
  if (metrics.empty()) return "";
  std::vector<FiguresOfStrategy> rows{
      {"strategy", "latency", "jump of hand", "jump of force", "late forces", "missing samples", "saturated"}};
  for (const StrategyRecord& strategy : run.strategies) rows.push_back(figures_of(strategy, metrics));
  std::array<std::size_t, kFigures> widths{};
  for (const FiguresOfStrategy& row : rows) {
    for (std::size_t c = 0; c < kFigures; ++c) widths[c] = std::max(widths[c], internal::display_width(row[c]));
  }
  std::string table;
  for (const FiguresOfStrategy& row : rows) {
    table += row[0] + std::string(widths[0] - internal::display_width(row[0]), ' ');
    for (std::size_t c = 1; c < kFigures; ++c) table += fmt::format("  {:>{}}", row[c], widths[c]);
    table += '\n';
  }
  return table;
}

}  // namespace evenstep
