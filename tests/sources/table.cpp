// Prints the tables of docs/choose/sources.md: test_sources "[.table]"
#include <fmt/format.h>

#include <cstdio>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// A metric in units of `scale`; "-" if it has no value, "0" below 1e-6, which is what rounding leaves.
std::string shown(const Metrics& metrics, const std::string& signal, const std::string& metric, double scale,
                  const char* format = "{:.2f}") {
  const auto values = metrics.find(signal);
  if (values == metrics.end() || !values->second.contains(metric)) return "-";
  const double value = values->second.at(metric) / scale;
  return value < 1e-6 ? "0" : fmt::format(fmt::runtime(format), value);
}

void print_table(const std::string& name) {
  RunOptions options;
  options.allow_no_expectations = true;
  const RunOutcome outcome = run_scenario(read("sources/" + name + ".toml"), options);
  INFO(outcome.failure);
  REQUIRE(outcome.failure.empty());
  fmt::print(
      "\n{}\n\n| strategy | latency, ms | velocity jump, mN | largest jump, mN | RMS error, mN | animation error, ms | "
      "late | lost | reordered | dry ticks |\n|---|---|---|---|---|---|---|---|---|---|\n",
      name);
  for (const StrategyRecord& strategy : outcome.record.strategies) {
    if (strategy.reference) continue;
    const std::string force = "left.force." + strategy.name;
    const auto of = [&](const char* metric, double scale, const char* format) {
      return shown(outcome.metrics, force, metric, scale, format);
    };
    fmt::print("| `{}` | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", strategy.name,
               of("total_latency_mean", 1e-3, "{:.1f}"), of("velocity_jump", 1e-3, "{:.3g}"), of("jump_max", 1e-3, "{:.3g}"),
               of("error_rms", 1e-3, "{:.3g}"), of("animation_error", 1e-3, "{:.3g}"), of("late", 1, "{:.0f}"),
               of("source_lost", 1, "{:.0f}"), of("source_reordered", 1, "{:.0f}"), of("ticks_underrun", 1, "{:.0f}"));
  }
}

}  // namespace

TEST_CASE("tables of the sources", "[.table]") {
  for (const char* name : {"slower-clean", "slower", "chunks", "drifting-clock", "wake-catch-up", "wake-absolute-grid",
                           "wake-from-last-update"})
    print_table(name);
  std::fflush(stdout);
}
