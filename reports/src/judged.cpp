#include "src/judged.h"

#include <algorithm>

namespace evenstep::internal {

Rows<std::size_t> judged_steps(const StrategyRecord& strategy, const Nominal& nominal) {
  // If the run failed during a step, its row may be there without the samples of all devices.
  std::size_t complete = strategy.steps.size();
  for (const DeviceRecord& device : strategy.devices) complete = std::min(complete, device.steps.size());
  Rows<std::size_t> steps(strategy.steps.get_allocator());
  for (std::size_t n = 0; n < complete; ++n) {
    if (strategy.steps[n].begin >= nominal.judged_from && !strategy.steps[n].acquiring) steps.push_back(n);
  }
  return steps;
}

Rows<std::size_t> judged_ticks(const DeviceRecord& device, const Nominal& nominal) {
  Rows<std::size_t> ticks(device.ticks.get_allocator());
  for (std::size_t k = 0; k < device.ticks.size(); ++k) {
    const TickRow& tick = device.ticks[k];
    if (tick.at >= nominal.judged_from && tick.at < nominal.end && tick.started) ticks.push_back(k);
  }
  return ticks;
}

double simulation_time_s(const StrategyRecord& strategy, std::size_t n, double slot_s) {
  return strategy.variable_step ? seconds(strategy.steps.at(n).simulated) : static_cast<double>(n) * slot_s;
}

Series interaction_series(const StrategyRecord& strategy, const DeviceRecord& device, const Rows<std::size_t>& steps,
                          double slot_s) {
  Series series{Rows<double>(device.steps.get_allocator()), Rows<Vec3>(device.steps.get_allocator())};
  for (const std::size_t n : steps) {
    series.t_s.push_back(strategy.variable_step
                             ? seconds(strategy.steps[n].simulated) - seconds(strategy.steps[steps.front()].simulated)
                             : static_cast<double>(n - steps.front()) * slot_s);
    series.value.push_back(device.steps.at(n).position_m);
  }
  return series;
}

Series force_series(const DeviceRecord& device, const Rows<std::size_t>& ticks, RealTime origin) {
  Series series{Rows<double>(device.ticks.get_allocator()), Rows<Vec3>(device.ticks.get_allocator())};
  for (const std::size_t k : ticks) {
    series.t_s.push_back(seconds(sent_at(device.ticks[k]) - origin));
    series.value.push_back(device.ticks[k].force_N);
  }
  return series;
}

const Nominal::Device* nominal_device(const Nominal& nominal, const std::string& name) {
  for (const Nominal::Device& device : nominal.devices) {
    if (device.name == name) return &device;
  }
  return nullptr;
}

}  // namespace evenstep::internal
