// Ten minutes and more: what is measured at the end is as exact as at the start.
#include <cmath>

#include "catch.h"
#include "evenstep/reports/measures.h"
#include "synthetic.h"

using namespace evenstep;
using synthetic::kSlot_s;
using synthetic::kStep_m;

namespace {

/// The deviation, in steps, that is found for the exact line n * step over n * slot, in two seconds from step `first` on.
double deviation_steps(std::int64_t first, double slot_s, double step_m) {
  std::vector<double> t_s;
  std::vector<Vec3> x;
  for (std::int64_t n = first; n < first + 900; ++n) {
    t_s.push_back(static_cast<double>(n) * slot_s);
    x.push_back({static_cast<double>(n) * step_m, 0, 0});
  }
  return deviation(t_s, x, 0.25).max / step_m;
}

}  // namespace

TEST_CASE("an exact line over ten million steps: the fit itself adds nothing, only the rounding of its numbers shows") {
  for (std::int64_t first = 1; first <= 10'000'000; first *= 10) {
    CAPTURE(first);
    // With powers of two every n * slot and n * step is exact, so only the arithmetic of the fit is left. It works on at
    // most 900 steps of travel: 900 * 2^-53 = 1e-13 step per operation.
    CHECK(deviation_steps(first, 0x1p-9, 0x1p-12) < 1e-12);
    // Other numbers are rounded to 2^-53 of n steps, both in position and in time: 2.2e-16 n.
    CHECK(deviation_steps(first, kSlot_s, kStep_m) < 2.3e-16 * static_cast<double>(first + 900));
  }
}

TEST_CASE("ten minutes of an exact line: the last bin is below 1e-9 step like the first, interaction and force", "[sweep]") {
  RunRecord run;
  run.clock = "virtual";
  run.nominal = synthetic::nominal({600'000'000'000});
  run.strategies.push_back(synthetic::strategy("paper", run.nominal.end, synthetic::kLead, synthetic::kLatency));
  StrategyRecord& strategy = run.strategies[0];
  DeviceRecord& device = strategy.devices[0];
  for (std::size_t n = 0; n < device.steps.size(); ++n)
    device.steps[n].position_m = {static_cast<double>(n) * kStep_m, 0, 0};
  for (TickRow& tick : device.ticks) tick.force_N = {-20 * static_cast<double>(tick.at.ns) / 1e9, 0, 0};  // k v t
  REQUIRE(device.steps.size() == 270'000);
  REQUIRE(device.ticks.size() == 600'000);
  const double step_N = 200 * kStep_m;
  Metrics metrics = measure(run);
  CHECK(metrics.at("left.interaction.paper").at("deviation_max") / kStep_m < 1e-9);
  CHECK(metrics.at("left.interaction.paper").at("velocity_jump") / kStep_m < 1e-9);
  CHECK(metrics.at("left.force.paper").at("deviation_max") / step_N < 1e-9);
  CHECK(metrics.at("solver.paper").at("segment_mean") == Approx(1.0 / 30).epsilon(1e-12));
  const auto all = bins(run);
  for (const auto& [signal, step] : {std::pair{"left.interaction.paper", kStep_m}, {"left.force.paper", step_N}}) {
    const std::vector<BinRow>& rows = all.at(signal);
    REQUIRE(rows.size() == 60);
    for (const BinRow& row : rows) CHECK(row.deviation_max / step < 1e-9);
    CHECK(rows.back().from_s == Approx(59 * 299.0 / 30 + 8.0 / 30).margin(1e-5));
  }
  device.steps[269'900].position_m[1] = kStep_m;  // a fault of one step in the last bin is seen in full
  CHECK(bins(run).at("left.interaction.paper").back().velocity_jump / kStep_m == Approx(2).epsilon(1e-9));
}
