#include "evenstep/harness/direct_shadow.h"

#include <algorithm>
#include <span>

namespace evenstep {
namespace {

/// A sample that a step may still ask for is not older than this many ticks: a quarter of a second at 4 kHz.
constexpr std::size_t kSamples = 1024;

RealTime ran_at(const SeenTick& tick) { return tick.scheduled + tick.lateness; }

std::unique_ptr<Solver> cheap_solver(const Scenario& scenario) {
  if (!costs_little(scenario.scene)) return nullptr;
  Scene scene = scenario.scene;
  scene.local_model = LocalModel::none;
  scene.variable_step = scene.needs_energy = scene.needs_state_digest = false;
  try {
    return make_solver(SolverKind::cpu_double, scene);
  } catch (const SolverError&) {
    return nullptr;  // the run itself stops for the same reason, and says it
  }
}

}  // namespace

DirectShadow::DirectShadow(const Scenario& scenario)
    : live_is_direct_(scenario.live == StrategyKind::direct), solver_(cheap_solver(scenario)) {
  for (const DeviceSpec& device : scenario.devices)
    tools_.push_back({ForceGuard(device.limits), std::holds_alternative<ForceRender>(device.render), {}});
}

std::string DirectShadow::no_force(std::size_t tool) const {
  if (live_is_direct_) return "direct itself is what runs";
  if (!solver_) return "direct's force would need a second solver of this scene; report.html has it after the run";
  if (!tools_[tool].plays_scheduled)
    return "the device answers the hand between two steps by a model; report.html has direct's force after the run";
  return "";
}

void DirectShadow::add(const SeenTick& tick) {
  std::deque<DeviceSample>& samples = tools_[tick.tool].samples;
  samples.push_back(tick.sample);
  if (samples.size() > kSamples) samples.pop_front();
  ticks_.push_back(tick);
}

void DirectShadow::add(const SeenStep& step) { steps_.push_back(step); }

std::optional<DirectShadow::Row> DirectShadow::earliest(RealTime until) const {
  const bool step = !steps_.empty() && steps_.front().end < until;
  const bool tick = !ticks_.empty() && ran_at(ticks_.front()) < until;
  if (step && tick) return steps_.front().end <= ran_at(ticks_.front()) ? Row::step : Row::tick;
  if (!step && !tick) return std::nullopt;
  return step ? Row::step : Row::tick;
}

ShadowedTick DirectShadow::shadow(const SeenTick& tick) {
  Tool& tool = tools_[tick.tool];
  ShadowedTick shadowed{tick, std::nullopt};
  if (no_force(tick.tool).empty())
    shadowed.direct_N = tool.guard.pass(ran_at(tick), force_N_[tick.tool], {tick.sample, due_});
  return shadowed;
}

ShadowedStep DirectShadow::shadow(const SeenStep& step) {
  ShadowedStep shadowed{step, {}};
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    const std::deque<DeviceSample>& samples = tools_[i].samples;
    if (!step.tools[i].sampled || samples.empty()) continue;  // direct would have had no sample, either
    const auto after = std::upper_bound(samples.begin(), samples.end(), step.tools[i].newest,
                                        [](RealTime at, const DeviceSample& sample) { return at < sample.read_at; });
    // Where the sample that the step saw is kept no longer, the oldest one is the nearest to it.
    shadowed.direct_m[i] = (after == samples.begin() ? *after : *(after - 1)).position_m;
  }
  if (!solver_) return shadowed;
  try {
    force_N_ = solver_->step(std::span(shadowed.direct_m.data(), tools_.size())).force_N;
    due_ = step.end;
  } catch (const SolverError&) {
    solver_.reset();  // a hand that no solver takes: the shadow ends
  }
  return shadowed;
}

}  // namespace evenstep
