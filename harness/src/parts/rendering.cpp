#include "evenstep/harness/rendering.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <variant>

namespace evenstep {
namespace {

/// A step of which the force is played from its end on. `sampled`: when the sample that it answers was taken. `stamp`: from
/// then on an engine moves from the force before to this one (Resampling::interpolated).
struct ForceTimes {
  RealTime sampled, ended, stamp;
};

/// How long, in seconds until `at`, this force would have counted whole, if it counted (t - stamp) / period at t, 1 at most:
/// the integral of that.
double counted_s(const ForceTimes& force, Duration period, RealTime at) {
  const double t_s = seconds(at - force.stamp), period_s = seconds(period);
  if (t_s <= 0) return 0;
  return t_s < period_s ? t_s * t_s / (2 * period_s) : t_s - period_s / 2;
}

/// The mean age, while forces are played, of the sample that the force answers. The force of step n is played from its end
/// to the end of the next step; between the last two forces (`interpolated`) the sample lies between their samples.
double mean_age_s(const Scenario& scenario, StrategyKind kind, const DeviceSpec& device) {
  const bool between = kind == StrategyKind::interpolated;
  const Duration period{sim_time(scenario.scene.step_rate, 1).ns};
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  const RealTime end{scenario.run_duration.ns}, first_tick{device.phase.ns};
  double age_times_s = 0, played_s = 0;
  std::optional<ForceTimes> before, last;
  SegmentTiming segment;
  while (timing->next(segment) && segment.begin < end) {
    for (const Interval& step : segment.steps) {
      if (last) {
        const double from_s = seconds(last->ended - last->sampled), to_s = seconds(step.end - last->sampled);
        age_times_s += (to_s - from_s) * (to_s + from_s) / 2;
        played_s += to_s - from_s;
        if (between && before) {
          const double whole_s = counted_s(*last, period, step.end) - counted_s(*last, period, last->ended);
          age_times_s += seconds(last->sampled - before->sampled) * (to_s - from_s - whole_s);
        }
      }
      const std::int64_t tick = first_tick_at_or_after(device.rate, step.begin + Duration{1}, first_tick) - 1;
      const std::optional<SimTime> own = segment.simulated_at(step);
      before = last;
      last = {tick_time(device.rate, tick, first_tick), step.end, own ? RealTime{own->ns} + period : step.begin};
    }
  }
  return played_s > 0 ? age_times_s / played_s : 0;
}

/// Whether the age of what is played is that of samples: a filter adds its own delay, and what continues a line or a chunk
/// plays what it expects at the tick.
bool plays_a_sample(StrategyKind kind) {
  const StrategyTraits& traits = traits_of(kind);
  return traits.plays_as_it_comes && !traits.filters && (!traits.continues || kind == StrategyKind::interpolated);
}

/// The hand that feels the force, if there is one.
std::optional<Plant> plant_of(const DeviceSpec& device) {
  if (!device.hand) return std::nullopt;
  return Plant{device.hand->total_mass_kg(), device.hand->total_damping_N_s_per_m()};
}

/// The contact's law with which a device renders; nullptr if it renders otherwise.
const LocalRender* local_of(const DeviceSpec& device) { return std::get_if<LocalRender>(&device.render); }

/// The alpha of a device; 0 if the scheduled force is played as it is.
double alpha_or_none(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device) {
  return local_of(device) ? alpha_of(scenario, plan, device) : 0;
}

double own_cap(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device) {
  using Cap = LocalRender::Cap;
  const Cap cap = std::get<LocalRender>(device.render).cap;
  if (cap.kind == Cap::Kind::fixed) return cap.fixed_N_per_m;
  const std::optional<Plant> plant = plant_of(device);
  if (cap.kind == Cap::Kind::none || !plant) return std::numeric_limits<double>::infinity();
  // What is measured lies between 0.2 % below the law and 80 % above it.
  constexpr double kMargin = 0.9;
  return kMargin * largest_stiffness_N_per_m(alpha_of(scenario, plan, device), loop_delays(scenario, plan, device), *plant);
}

bool play_their_coupling(const Scenario& scenario) {
  return scenario.devices.size() == 2 &&
         std::all_of(scenario.devices.begin(), scenario.devices.end(),
                     [](const DeviceSpec& device) { return local_of(device) && local_of(device)->coupled; });
}

}  // namespace

LoopDelays loop_delays(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device) {
  LoopDelays loop;
  loop.period_s = period_s(device.rate);
  const double hold_s = device.emission == Emission::hold ? period_s(scenario.scene.step_rate) / 2 : 0;
  const double latency_s =
      traits_of(plan.kind).plays_as_it_comes ? mean_age_s(scenario, plan.kind, device) : seconds(plan.latency) + hold_s;
  loop.device_s = seconds(device.force_delay);
  loop.scheduled_s = latency_s + loop.period_s / 2;
  if (const LocalRender* local = local_of(device); !local || !local->by_device) return loop;
  const OwnSprings springs = *own_springs(device.driver);  // the reader refuses drivers without springs or newtons
  loop.own_N_per_m = *springs.steepest_N_per_m;
  loop.own_period_s = period_s(springs.firmware_rate);
  return loop;
}

double alpha_of(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device) {
  if (const std::optional<double>& alpha = std::get<LocalRender>(device.render).alpha) return *alpha;
  return automatic_alpha(loop_delays(scenario, plan, device), plant_of(device));
}

double cap_of(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device) {
  if (!play_their_coupling(scenario)) return own_cap(scenario, plan, device);
  return std::min(own_cap(scenario, plan, scenario.devices[0]), own_cap(scenario, plan, scenario.devices[1]));
}

bool capped_together(const Scenario& scenario, const StrategyPlan& plan) {
  return play_their_coupling(scenario) && std::isfinite(cap_of(scenario, plan, scenario.devices[0]));
}

LoopRecord loop_record(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device) {
  const LoopDelays loop = loop_delays(scenario, plan, device);
  LoopRecord record{loop.scheduled_s + loop.device_s, felt_stiffness_N_per_m(scenario.scene)};
  if (plays_a_sample(plan.kind)) record.played_age_s = loop.scheduled_s - loop.period_s / 2;
  if (std::holds_alternative<SmithRender>(device.render)) return record;  // the laws hold for a spring only
  const double alpha = alpha_or_none(scenario, plan, device);
  LoopDelays of_host = loop;
  of_host.own_N_per_m = 0;
  record.damping_per_stiffness_s = rendered_damping(1, alpha, of_host);
  record.own_N_per_m = loop.own_N_per_m;
  record.own_gain_s = (loop.period_s - loop.own_period_s) / 2;
  if (const std::optional<Plant> plant = plant_of(device))
    record.stiffness_limit_N_per_m = largest_stiffness_N_per_m(alpha, loop, *plant);
  if (!local_of(device)) return record;
  record.alpha = alpha;
  record.alpha_star = alpha_star(loop);
  record.cap_N_per_m = cap_of(scenario, plan, device);
  return record;
}

std::string rendering_line(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device) {
  const LoopDelays loop = loop_delays(scenario, plan, device);
  const bool local = local_of(device) != nullptr;
  const double alpha = alpha_or_none(scenario, plan, device);
  std::string line = fmt::format("the force answers the hand after {:.3f} ms (L_e)", 1e3 * loop.scheduled_s);
  if (const std::optional<double> star = alpha_star(loop); local && star)
    line += fmt::format(", alpha {:.4g} (alpha* {:.4g})", alpha, *star);
  const double stiffness = felt_stiffness_N_per_m(scenario.scene).value_or(100);  // 100 N/m as an example
  line += fmt::format(", so {:.6g} N/m feel damped by {:+.3g} N s/m", stiffness, rendered_damping(stiffness, alpha, loop));
  if (const std::optional<Plant> plant = plant_of(device))
    line += fmt::format(", a spring of {:.4g} N/m at most", largest_stiffness_N_per_m(alpha, loop, *plant));
  if (!local) return line;
  if (const double cap = cap_of(scenario, plan, device); std::isfinite(cap))
    line += fmt::format(", contacts above {:.4g} N/m played as that", cap);
  return line;
}

}  // namespace evenstep
