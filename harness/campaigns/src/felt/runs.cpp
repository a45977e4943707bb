#include "runs.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/loop/exchange.h"

namespace evenstep::internal {
namespace {

/// An exchange without devices: the hand is where its programmed motion has it. `ideal`: a step reads the motion at exactly
/// the time that it asks for, or now where it asks for the newest sample; otherwise it reads samples of the ticks.
class MotionExchange final : public Exchange {
 public:
  MotionExchange(const std::vector<LinkSpec>& links, std::vector<ProgrammedMotion> motions, const Clock& clock, bool ideal)
      : Exchange(links), links_(links), motions_(std::move(motions)), clock_(clock), ideal_(ideal) {
    for (const LinkSpec& link : links) {
      filters_.push_back(std::nullopt);
      if (link.interaction_filter) filters_.back() = make_filter<glm::dvec3>(*link.interaction_filter, link.step_rate);
    }
  }
  DeviceSpring render(int, const DeviceSpring&) override { return {}; }

  Reading<glm::dvec3> hand(int tool, const Slot& slot) override {
    if (!ideal_) return Exchange::hand(tool, slot);
    const auto device = static_cast<std::size_t>(tool);
    const RealTime now = clock_.now();
    if (slot.kind != SlotKind::mapped) {
      const glm::dvec3 newest = position_m(motions_[device], now);
      return {filters_[device] ? filters_[device]->next(newest) : newest, ReadStatus::inside, now};
    }
    if (slot.read <= now) return {position_m(motions_[device], slot.read), ReadStatus::inside, now};
    return {beyond(device, now, slot.read - now), ReadStatus::underrun, now};
  }

 protected:
  DeviceSample read_device(int tool, const Scheduler&) override {
    const RealTime now = clock_.now();
    return {.read_at = now, .position_m = position_m(motions_[static_cast<std::size_t>(tool)], now), .fresh = true};
  }

 private:
  /// The value at `now` + `ahead` of the line through the positions at `now` and one window before.
  glm::dvec3 beyond(std::size_t device, RealTime now, Duration ahead) const {
    const Extrapolation& line = links_[device].interaction;
    const glm::dvec3 newest = position_m(motions_[device], now);
    if (line.none()) return newest;
    const glm::dvec3 before = position_m(motions_[device], now - line.window);
    return newest + (newest - before) * ratio(std::min(ahead, line.furthest), line.window);
  }

  std::vector<LinkSpec> links_;
  std::vector<ProgrammedMotion> motions_;
  const Clock& clock_;
  bool ideal_;
  std::vector<std::optional<Filter<glm::dvec3>>> filters_;
};

/// A driver that also notes what the motors of its device do after each force.
class FeltDevice final : public HapticDevice {
 public:
  FeltDevice(HapticDevice& driver, SimulatedDevices& devices, std::size_t tool)
      : driver_(driver), devices_(devices), tool_(tool) {}
  DeviceSample read(RealTime now) override { return driver_.read(now); }
  void write(const glm::dvec3& force_N) override {
    driver_.write(force_N);
    felt_N.push_back(devices_.motors_force_N(tool_));
  }
  DeviceSpring write_spring(const DeviceSpring& wanted) override { return driver_.write_spring(wanted); }
  double largest_force_N() const override { return driver_.largest_force_N(); }
  const DeviceCounters& counters() const override { return driver_.counters(); }

  std::vector<glm::dvec3> felt_N;  ///< by tick

 private:
  HapticDevice& driver_;
  SimulatedDevices& devices_;
  std::size_t tool_;
};

/// The scenario up to the end of what is judged, without anything that only a report needs.
Scenario only_forces(const Scenario& scenario, DeviceModel model) {
  Scenario changed = scenario;
  changed.run_duration = judged_span(scenario).end - RealTime{0};
  changed.interrupt = std::nullopt;
  changed.keep_rows = changed.needs_undelayed = false;
  changed.scene.needs_energy = changed.scene.needs_state_digest = false;
  if (model == DeviceModel::scenario) return changed;
  for (DeviceSpec& device : changed.devices) {
    constexpr double kNone = 1e12;  // N, the most that a guard can be told
    device.limits = {kNone, std::numeric_limits<double>::max(), {}};
  }
  return changed;
}

FeltTicks judged_ticks(const StrategyRecord& record, const JudgedSpan& span) {
  FeltTicks ticks;
  for (const DeviceRecord& device : record.devices) {
    std::vector<FeltTick>& judged = ticks.emplace_back();
    for (const TickRow& tick : device.ticks) {
      if (tick.at < span.from || tick.at >= span.end) continue;
      judged.push_back({tick.at, glm::dvec3(tick.force_N[0], tick.force_N[1], tick.force_N[2]), !tick.saturated.none()});
    }
  }
  return ticks;
}

FeltTicks without_device(const Scenario& scenario, const StrategyPlan& plan, bool ideal, const RunControl& control) {
  VirtualClock clock;
  std::vector<LinkSpec> links = links_of(scenario, plan);
  for (LinkSpec& link : links) {
    if (ideal && link.gate) link.ticks = {{1'000'000'000, 1}, {}};  // its sample is there at its very instant
  }
  MotionExchange exchange(links, motions_of(scenario), clock, ideal);
  return judged_ticks(run_lanes(scenario, plan, {clock, exchange, make_timing(scenario.timing), {}}, control),
                      judged_span(scenario));
}

FeltTicks with_device(const Scenario& scenario, const StrategyPlan& plan, const RunControl& control) {
  VirtualClock clock;
  SimulatedDevices devices(scenario, clock);
  std::vector<std::unique_ptr<FeltDevice>> felt;
  std::vector<HapticDevice*> drivers;
  for (HapticDevice* driver : devices.drivers()) {
    felt.push_back(std::make_unique<FeltDevice>(*driver, devices, felt.size()));
    drivers.push_back(felt.back().get());
  }
  StrategyRecord record;
  try {
    DeviceExchange exchange(links_of(scenario, plan), drivers);
    record = run_lanes(scenario, plan, {clock, exchange, make_timing(scenario.timing), drivers}, control);
  } catch (...) {
    devices.stop();
    throw;
  }
  for (std::size_t tool = 0; tool < felt.size(); ++tool) {
    for (std::size_t k = 0; k < felt[tool]->felt_N.size(); ++k)
      record.devices[tool].ticks[k].force_N = to_vec3(felt[tool]->felt_N[k]);
  }
  devices.stop();
  return judged_ticks(record, judged_span(scenario));
}

}  // namespace

JudgedSpan judged_span(const Scenario& scenario) {
  const RealTime from{scenario.warmup.ns}, end{scenario.run_duration.ns};
  return {from, std::min(end, from + scenario.study.duration)};
}

FeltTicks felt_ticks(const Scenario& scenario, const StrategyPlan& plan, DeviceModel model, const RunControl& control) {
  const Scenario changed = only_forces(scenario, model);
  if (model == DeviceModel::scenario) return with_device(changed, plan, control);
  return without_device(changed, plan, model == DeviceModel::ideal, control);
}

std::vector<double> mean_ages_s(const Scenario& scenario, const StrategyPlan& plan, DeviceModel model,
                                const RunControl& control) {
  // k x = t: a spring of 1 N/m whose hand moves at 1 m/s from t = 0 on.
  Scenario telling = scenario;
  telling.solver = SolverKind::cpu_double;
  telling.scene.body = SpringScene{1};
  telling.scene.local_model = LocalModel::none;
  for (DeviceSpec& device : telling.devices) device.motion = {ConstantVelocity{glm::dvec3(1, 0, 0)}, RealTime{0}};
  const bool ideal = model == DeviceModel::ideal;
  const FeltTicks ticks = felt_ticks(telling, plan, ideal ? model : DeviceModel::sampling, control);
  std::vector<double> ages_s;
  for (std::size_t tool = 0; tool < ticks.size(); ++tool) {
    double sum_s = 0;
    for (const FeltTick& tick : ticks[tool]) sum_s += seconds(tick.at) + tick.force_N.x;
    ages_s.push_back(ticks[tool].empty() ? 0 : sum_s / static_cast<double>(ticks[tool].size()));
  }
  return ages_s;
}

EvenForces step_evenly(Solver& solver, const Scenario& scenario, Rate rate, Duration lead, RealTime until,
                       const RunControl& control) {
  EvenForces forces;
  std::array<glm::dvec3, kMaxTools> positions_m{};
  for (std::int64_t n = 0; !control.is_interrupted(); ++n) {
    const RealTime read = tick_time(rate, n) - lead;
    for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool)
      positions_m[tool] = position_m(scenario.devices[tool].motion, read);
    forces.force_N.push_back(solver.step({positions_m.data(), scenario.devices.size()}).force_N);
    forces.read.push_back(read);
    if (read >= until) break;
  }
  return forces;
}

glm::dvec3 played_N(const EvenForces& forces, std::size_t tool, double t_s, Emission emission) {
  const auto after = std::upper_bound(forces.read.begin(), forces.read.end(), t_s,
                                      [](double t, RealTime read) { return t < seconds(read); });
  const auto i = static_cast<std::size_t>(after - forces.read.begin());
  if (i == 0) return forces.force_N.front()[tool];
  if (i == forces.read.size() || emission == Emission::hold) return forces.force_N[i - 1][tool];
  const double from_s = seconds(forces.read[i - 1]), share = (t_s - from_s) / (seconds(forces.read[i]) - from_s);
  return lerp(forces.force_N[i - 1][tool], forces.force_N[i][tool], share);
}

}  // namespace evenstep::internal
