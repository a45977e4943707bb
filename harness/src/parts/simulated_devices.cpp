#include "evenstep/harness/simulated_devices.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <utility>

#include "evenstep/device/device_clock.h"
#include "evenstep/harness/rendering.h"
#include "evenstep/reports/run_failure.h"
#include "make_driver.h"
#include "src/plan/source_plan.h"
#include "src/plan/strategies.h"

namespace evenstep {
namespace {

std::variant<RenderForce, RenderLocal, RenderSmith> render_of(const Scenario& scenario, const StrategyPlan& plan,
                                                              const DeviceSpec& device) {
  if (const auto* local = std::get_if<LocalRender>(&device.render)) {
    return RenderLocal{.alpha = alpha_of(scenario, plan, device),
                       .knows_gap = local->knows_gap,
                       .part = local->part,
                       .coupled = local->coupled,
                       .by_device = local->by_device,
                       .most_N_per_m = cap_of(scenario, plan, device),
                       .capped_together = capped_together(scenario, plan)};
  }
  if (const auto* smith = std::get_if<SmithRender>(&device.render)) {
    // A record was read at most the latency before it is played, or at most a segment before if it is played as it comes;
    // the next record is at most two slots later; and a record is held until it has faded.
    const Duration slots{2 * scenario.nominal.slot.ns};
    return RenderSmith{*smith_mode(scenario.scene, *smith),
                       plan.latency + scenario.nominal.segment + slots + kFadeAfter + kFadeFor};
  }
  return RenderForce{};
}

}  // namespace

namespace {

/// A hand may diverge between the last tick and the end, but that is not part of the run.
MotorState motors_at_end(SimulatedMotors& device) {
  try {
    return device.motors();
  } catch (const HandDiverged&) {
    return device.motors();
  }
}

}  // namespace

void stop_simulated(const std::string& name, HapticDevice* driver, SimulatedMotors& device) {
  motors_at_end(device);
  if (driver) driver->stop();
  const MotorState left = motors_at_end(device);
  const bool any_effect = left.effects_playing > 0 || left.effects_allocated > 0;
  const bool is_at_rest = left.force_N == glm::dvec3(0) && !any_effect && !left.actuators_enabled;
  if (is_at_rest || left.by_itself) return;
  throw RunFailure(kStillDriving,
                   fmt::format("{}: the device still drives after its driver has stopped: {:.6g} N, {} effects play, {} are "
                               "allocated, actuators {}",
                               name, glm::length(left.force_N), left.effects_playing, left.effects_allocated,
                               left.actuators_enabled ? "on" : "off"),
                   "what the driver said last was lost or refused (a fault that lasts to the end?), or it said nothing");
}

std::map<std::string, double> motor_counters(SimulatedMotors& device) {
  const MotorState motors = motors_at_end(device);
  std::map<std::string, double> counters{{"motors_max", motors.largest_N},
                                         {"motors_max_x", motors.largest_along_N.x},
                                         {"motors_max_y", motors.largest_along_N.y},
                                         {"motors_max_z", motors.largest_along_N.z},
                                         {"motors_left", glm::length(motors.force_N)},
                                         {"motors_unrenewed", seconds(motors.unrenewed)},
                                         {"effects_ended", static_cast<double>(motors.effects_ended)}};
  if (motors.asked_away_N) counters["motors_away"] = *motors.asked_away_N;
  return counters;
}

SimulatedDevices::SimulatedDevices(const Scenario& scenario, const Clock& clock) {
  for (const DeviceSpec& device : scenario.devices) {
    try {
      internal::SimulatedParts parts = internal::make_simulated(device, clock);
      names_.push_back(device.name);
      devices_.push_back(std::move(parts.device));
      drivers_.push_back(std::move(parts.driver));
      drivers_.back()->start();
    } catch (const DeviceError& error) {
      stop();
      throw RunFailure("device", error.what(), "change the [[device]]");
    }
  }
}

void SimulatedDevices::stop() {
  for (std::size_t tool = 0; tool < devices_.size(); ++tool)
    stop_simulated(names_[tool], drivers_[tool].get(), *devices_[tool]);
}

std::vector<HapticDevice*> SimulatedDevices::drivers() {
  std::vector<HapticDevice*> drivers;
  for (const std::unique_ptr<HapticDevice>& driver : drivers_) drivers.push_back(driver.get());
  return drivers;
}

std::vector<LinkSpec> links_of(const Scenario& scenario, const StrategyPlan& plan) {
  LinkSpec common;
  common.samples = plan.interaction_capacity;
  common.forces = plan.force_capacity;
  if (plan.needed) {
    // An entry may be written while another one is read. On the virtual clock none is, so rings that somebody else has sized
    // lack the one that it would overwrite.
    --common.samples;
    --common.forces;
  }
  common.step_rate = scenario.scene.step_rate;

  std::vector<LinkSpec> links(scenario.devices.size(), common);
  const std::vector<SamplingGrid> grids = sampling_grids(scenario);
  for (std::size_t tool = 0; tool < links.size(); ++tool) {
    links[tool].emission = scenario.devices[tool].emission;
    links[tool].render = render_of(scenario, plan, scenario.devices[tool]);
    links[tool].ticks = grids[tool];
    links[tool].source = internal::source_forces(scenario, plan, links[tool].emission);
    internal::strategy_of(plan.kind).link(scenario.remap, links[tool]);
  }
  return links;
}

std::vector<ProgrammedMotion> motions_of(const Scenario& scenario) {
  std::vector<ProgrammedMotion> motions;
  for (const DeviceSpec& device : scenario.devices) motions.push_back(device.motion);
  return motions;
}

std::vector<DeviceLane> device_lanes(const Scenario& scenario, const std::vector<HapticDevice*>& devices) {
  std::vector<DeviceLane> lanes;
  for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool) {
    const DeviceSpec& device = scenario.devices[tool];
    lanes.push_back({static_cast<int>(tool), device.rate, RealTime{device.phase.ns},
                     devices.empty() ? nullptr : devices[tool], ForceGuard(device.limits)});
  }
  return lanes;
}

namespace {

void put_ages(const SampleAges& ages, std::map<std::string, double>& counters) {
  counters["sample_age_p50"] = seconds(ages.ages.quantile(500));
  counters["sample_age_p99"] = seconds(ages.ages.quantile(990));
  counters["sample_age_max"] = seconds(ages.ages.largest());
  counters["ages_capped"] = static_cast<double>(ages.capped);
  if (ages.clock_rate_error || ages.ahead > 0) {
    counters["clock_ahead"] = static_cast<double>(ages.ahead);
    counters["clock_ahead_max"] = seconds(ages.ahead_max);
  }
  if (!ages.clock_rate_error) return;
  counters["clock_rate_error"] = *ages.clock_rate_error;
  counters["clock_residual"] = seconds(ages.residual);
  counters["clock_restarts"] = static_cast<double>(ages.restarts);
}

}  // namespace

std::map<std::string, double> counters_of(const DeviceLane& lane) {
  const ForceGuardCounters& guarded = lane.guard.counters();
  std::map<std::string, double> counters{{"clamped", static_cast<double>(guarded.clamped)},
                                         {"slewed", static_cast<double>(guarded.slewed)},
                                         {"non_finite", static_cast<double>(guarded.non_finite)},
                                         {"cuts_device", static_cast<double>(guarded.cuts_device)},
                                         {"cuts_stale_hand", static_cast<double>(guarded.cuts_stale_hand)},
                                         {"cuts_stale_force", static_cast<double>(guarded.cuts_stale_force)},
                                         {"cuts_speed", static_cast<double>(guarded.cuts_speed)}};
  if (!lane.device) return counters;
  const DeviceCounters& driver = lane.device->counters();
  counters["reports"] = static_cast<double>(driver.reports);
  counters["lost"] = static_cast<double>(driver.lost);
  counters["malformed"] = static_cast<double>(driver.malformed);
  counters["stale"] = static_cast<double>(driver.stale);
  counters["write_failures"] = static_cast<double>(driver.write_failures);
  for (const auto& [name, count] : lane.device->own_counters()) counters[name] = static_cast<double>(count);
  if (const SampleAges* const ages = lane.device->ages(); ages && ages->ages.count() > 0) put_ages(*ages, counters);
  return counters;
}

}  // namespace evenstep
