#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "evenstep/reports/writers.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

constexpr std::size_t kFigures = 7;
using FiguresOfStrategy = std::array<std::string, kFigures>;

FiguresOfStrategy figures_of(const StrategyRecord& strategy, const Metrics& metrics) {
  double latency_s = 0, hand_m = 0, force_N = 0, late = 0, missing = 0, judged = 0, saturated = 0;
  for (const DeviceRecord& device : strategy.devices) {
    const auto signal = [&](const char* what) { return device.name + what + strategy.name; };
    const auto value = [&](const char* what, const char* metric) { return value_or_0(metrics, signal(what), metric); };
    latency_s = std::max(latency_s, value(".buffers.", "latency"));
    hand_m = std::max(hand_m, value(".interaction.", "velocity_jump"));
    force_N = std::max(force_N, value(".force.", "jump_max"));
    late += value(".force.", "underruns");
    missing += value(".interaction.", "underruns");
    judged += value(".interaction.", "judged");
    saturated += value(".force.", "saturated") + value(".interaction.", "saturated");
  }
  const auto of = [&](double count) { return count > 0 ? fmt::format("{} of {}", count, judged) : std::string("0"); };
  return {strategy.name,
          fmt::format("{:.2f} ms", 1e3 * latency_s),
          fmt::format("{:.2f} um", 1e6 * hand_m),
          fmt::format("{:.2f} mN", 1e3 * force_N),
          of(late),
          of(missing),
          fmt::format("{}", saturated)};
}

}  // namespace

std::string strategy_table(const RunRecord& run, const Metrics& metrics) {
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
