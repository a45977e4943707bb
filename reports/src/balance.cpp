#include "evenstep/reports/balance.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/judged.h"

namespace evenstep {
namespace {

/// Collects the laws that do not hold.
class Ledger {
 public:
  Ledger(std::vector<std::string>& broken, std::string who) : broken_(broken), who_(std::move(who)) {}
  void equal(std::int64_t a, const char* what_a, std::int64_t b, const char* what_b) {
    if (a != b) broken_.push_back(fmt::format("{}: {} {}, {} {}", who_, a, what_a, b, what_b));
  }
  void at_most(std::int64_t a, const char* what_a, std::int64_t b, const char* what_b) {
    if (a > b) equal(a, what_a, b, what_b);
  }

 private:
  std::vector<std::string>& broken_;
  std::string who_;
};

std::int64_t counter(const DeviceRecord& device, const char* name) {
  const auto found = device.counters.find(name);
  constexpr double kMost = 9e15;  // a foreign driver may count anything
  return found == device.counters.end() ? 0 : static_cast<std::int64_t>(std::clamp(found->second, 0.0, kMost));
}

/// Ticks of the device's grid before `end`.
std::int64_t grid_ticks(const Nominal::Device& device, RealTime end) {
  return first_tick_at_or_after(device.rate, end, device.first_tick);
}

void check_ticks(const RunRecord& run, const StrategyRecord& strategy, const DeviceRecord& device,
                 const Nominal::Device& nominal, Ledger& ledger) {
  const DeviceFlow& flow = *device.flow;
  const std::int64_t ticks = std::ssize(device.ticks);
  if (ticks > 0) {
    ledger.equal(grid_ticks(nominal, device.ticks.back().at + Duration{1}), "ticks were due up to the last that ran",
                 ticks + flow.ticks_skipped, "ran or were skipped");
  }
  if (run.clock == "virtual") {
    ledger.equal(flow.ticks_skipped, "ticks were skipped", 0, "can be on the virtual clock");
    if (!strategy.interrupted) ledger.equal(grid_ticks(nominal, run.nominal.end), "ticks were due", ticks, "ran");
  }
  ledger.equal(flow.ticks_on_time + flow.ticks_underrun + flow.ticks_overrun + flow.ticks_unforced,
               "ticks asked for their force", ticks, "ran");
  ledger.equal(flow.samples + flow.samples_repeated, "samples are in the ring, or were already", ticks, "ticks ran");
  const std::int64_t reports = counter(device, "reports"), stale = counter(device, "stale");
  if (reports == 0) return;  // the driver does not count reports, or none came
  ledger.at_most(stale, "samples were stale", ticks, "ticks ran");
  ledger.at_most(ticks - stale, "ticks had a new report", reports, "reports came");
}

void check_forces(const StrategyRecord& strategy, const DeviceRecord& device, Ledger& ledger) {
  const DeviceFlow& flow = *device.flow;
  const std::int64_t steps = std::ssize(strategy.steps);
  ledger.equal(std::ssize(device.steps), "of its steps are on record", steps, "steps ended");
  ledger.equal(flow.forces, "forces are in the ring", steps, "steps ended");
  ledger.equal(flow.forces_sent + flow.forces_overtaken + flow.forces_dropped + flow.forces_pending,
               "forces were sent, overtaken, dropped or pending", flow.forces, "are in the ring");
}

void check_steps(const RunRecord& run, const StrategyRecord& strategy, Ledger& ledger) {
  const std::int64_t steps = std::ssize(strategy.steps);
  ledger.at_most(steps, "steps ended", strategy.steps_begun, "began");
  ledger.at_most(strategy.steps_begun, "steps began", steps + 1, "can have, with the one that the end cut off");
  if (strategy.steps_due) ledger.at_most(strategy.steps_begun, "steps began", *strategy.steps_due, "were due");
  std::int64_t ticks = 0, underruns = 0;  // underruns: in steps that ended
  for (const DeviceRecord& device : strategy.devices) {
    ticks += std::ssize(device.ticks);
    underruns += std::count_if(device.steps.begin(), device.steps.end(), [](const StepSample& sample) {
      return sample.read == StepRead::underrun || sample.read == StepRead::gated;
    });
    underruns += std::count_if(strategy.steps.begin(), strategy.steps.end(),
                               [&](const StepRow& step) { return is_late(step, device); });
  }
  const auto rows = std::count_if(strategy.underruns.begin(), strategy.underruns.end(),
                                  [&](const UnderrunRow& row) { return row.step < steps; });
  ledger.equal(underruns, "reads and forces were late", rows, "are on the list of underruns");
  if (!run.keep_rows) return;  // then no events are kept either
  const auto events = [&](const char* name) {
    const auto found = strategy.event_counts.find(name);
    return found == strategy.event_counts.end() ? 0 : found->second;
  };
  ledger.equal(events("device.tick"), "events 'tick'", ticks, "ticks ran");
  ledger.equal(events("completion.step"), "events 'step'", steps, "steps ended");
  ledger.at_most(strategy.steps_begun, "steps began", events("launch.launch"), "events 'launch'");
  ledger.at_most(events("launch.launch"), "events 'launch'", strategy.steps_begun + 1, "can be, with a step that waits");
}

}  // namespace

std::vector<std::string> imbalances(const RunRecord& run) {
  std::vector<std::string> broken;
  for (const StrategyRecord& strategy : run.strategies) {
    const bool made_by_lanes = std::all_of(strategy.devices.begin(), strategy.devices.end(),
                                           [](const DeviceRecord& device) { return device.flow.has_value(); });
    if (!made_by_lanes) continue;
    Ledger of_strategy(broken, strategy.name);
    check_steps(run, strategy, of_strategy);
    for (std::size_t d = 0; d < strategy.devices.size(); ++d) {
      const DeviceRecord& device = strategy.devices[d];
      Ledger of_device(broken, fmt::format("{}, {}", device.name, strategy.name));
      check_ticks(run, strategy, device, run.nominal.devices[d], of_device);
      check_forces(strategy, device, of_device);
    }
  }
  return broken;
}

}  // namespace evenstep
