#include "evenstep/harness/saturation_forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "evenstep/loop/recorder.h"
#include "src/judge.h"
#include "src/parts/undelayed_solver.h"

namespace evenstep {
namespace {

constexpr std::int64_t kMostForetold = 10'000'000;  // ticks of a device: almost three hours at 1 kHz, a second of work
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What the reports of a device can carry, along each axis in both directions.
struct ReportRange {
  glm::dvec3 position_m{kInfinity};
  double force_N = kInfinity;
};
template <class Spec>
ReportRange range_of(const Spec&) {
  return {};
}
ReportRange range_of(const ReferenceSpec&) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  return {glm::dvec3(kMost / 1e9), kMost / 1e6};
}
template <class Spec>
requires requires(const Spec& spec) { spec.options.travel_m; }
ReportRange range_of(const Spec& spec) {
  ReportRange range{glm::dvec3(kInfinity), spec.options.full_scale_N.value_or(kInfinity) * spec.options.gain};
  for (int axis = 0; axis < 3; ++axis) {
    if (spec.options.travel_m[axis] > 0) range.position_m[axis] = spec.options.travel_m[axis] / 2;
  }
  return range;
}

glm::dvec3 to_dvec3(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// The ticks of a device whose hand moves as programmed, one at a time: a long run has more than memory has room for.
class ReportedTicks {
 public:
  ReportedTicks(const DeviceSpec& device, RealTime end)
      : device_(device),
        range_(std::visit([](const auto& spec) { return range_of(spec); }, device.driver)),
        count_(std::min(first_tick_at_or_after(device.rate, end, first()), kMostForetold)) {}
  std::int64_t count() const { return count_; }
  const ReportRange& range() const { return range_; }
  RealTime time(std::int64_t k) const { return tick_time(device_.rate, k, first()); }
  /// The position as the device reports it.
  glm::dvec3 position(std::int64_t k) const {
    return glm::clamp(position_m(device_.motion, time(k)), -range_.position_m, range_.position_m);
  }
  /// Interpolated between its ticks, as put_undelayed() does it.
  glm::dvec3 position_at(RealTime at) const {
    if (count_ == 0) return glm::dvec3(0);
    const std::int64_t after = first_tick_at_or_after(device_.rate, at, first());
    if (after >= count_) return position(count_ - 1);
    if (after <= 0 || time(after) == at) return position(std::max<std::int64_t>(after, 0));
    const RealTime before = time(after - 1);
    const double w = static_cast<double>((at - before).ns) / static_cast<double>((time(after) - before).ns);
    return position(after - 1) + (position(after) - position(after - 1)) * w;
  }

 private:
  RealTime first() const { return RealTime{device_.phase.ns}; }

  const DeviceSpec& device_;
  ReportRange range_;
  std::int64_t count_;
};

/// Notes the first tick that meets each limit.
class Watch {
 public:
  Watch(const DeviceSpec& device, std::vector<ForetoldSaturation>& found) : device_(device), found_(found) {}
  void at(RealTime at, SaturationCause cause, bool is_met, double limit) {
    if (!is_met) return;
    const auto same = [&](const ForetoldSaturation& one) { return one.device == device_.name && one.cause == cause; };
    if (std::any_of(found_.begin(), found_.end(), same)) return;
    found_.push_back({device_.name, cause, at, limit, device_.expects_saturation});
  }

 private:
  const DeviceSpec& device_;
  std::vector<ForetoldSaturation>& found_;
};

void watch_tick(const DeviceSpec& device, const ReportRange& range, const TickRow& before, const TickRow& tick,
                Watch& watch) {
  const double period_s = seconds(tick.at - before.at);
  const glm::dvec3 position = to_dvec3(tick.position_m);
  const double speed_m_per_s = glm::length(position - to_dvec3(before.position_m)) / period_s;
  const double most_m_per_s = device.limits.cut.max_speed_m_per_s;
  // A billionth for the rounding of a hand that is exactly as fast as allowed.
  watch.at(tick.at, SaturationCause::cut, speed_m_per_s > most_m_per_s * (1 + 1e-9), most_m_per_s);
  for (int axis = 0; axis < 3; ++axis) {
    const double most_m = range.position_m[axis];
    watch.at(tick.at, SaturationCause::device_position, std::abs(position[axis]) >= most_m, most_m);
  }
  if (!tick.undelayed_N || !before.undelayed_N) return;
  const glm::dvec3 force_N = to_dvec3(*tick.undelayed_N) * device.limits.cut.gain;
  const glm::dvec3 change_N = force_N - to_dvec3(*before.undelayed_N) * device.limits.cut.gain;
  const ForceLimits& limits = device.limits;
  watch.at(tick.at, SaturationCause::clamp, glm::length(force_N) > limits.max_N, limits.max_N);
  watch.at(tick.at, SaturationCause::slew, glm::length(change_N) / period_s > limits.max_slew_N_per_s,
           limits.max_slew_N_per_s);
  for (int axis = 0; axis < 3; ++axis)
    watch.at(tick.at, SaturationCause::device_force, std::abs(force_N[axis]) > range.force_N, range.force_N);
}

std::string_view unit_of(SaturationCause cause) {
  switch (cause) {
    case SaturationCause::slew:
      return "N/s";
    case SaturationCause::cut:
      return "m/s";
    case SaturationCause::device_position:
      return "m";
    default:
      return "N";
  }
}

}  // namespace

std::vector<ForetoldSaturation> foretell_saturation(const Scenario& scenario) {
  std::vector<ForetoldSaturation> found;
  if (has_hand(scenario)) return found;
  std::vector<ReportedTicks> devices;
  for (const DeviceSpec& device : scenario.devices) devices.emplace_back(device, RealTime{scenario.run_duration.ns});
  for (std::size_t tool = 0; tool < devices.size(); ++tool) {
    const DeviceSpec& device = scenario.devices[tool];
    std::optional<internal::UndelayedSolver> solver;
    if (costs_little(scenario.scene)) solver.emplace(scenario, tool);
    Watch watch(device, found);
    TickRow before;
    for (std::int64_t k = 0; k < devices[tool].count(); ++k) {
      TickRow tick;
      tick.at = devices[tool].time(k);
      tick.position_m = to_vec3(devices[tool].position(k));
      if (solver) {
        std::array<glm::dvec3, kMaxTools> positions_m;
        for (std::size_t other = 0; other < devices.size(); ++other)
          positions_m[other] = devices[other].position_at(tick.at);
        tick.undelayed_N = solver->next(std::span(positions_m.data(), devices.size()));
      }
      if (k > 0 && tick.at >= RealTime{scenario.warmup.ns}) watch_tick(device, devices[tool].range(), before, tick, watch);
      before = tick;
    }
  }
  return found;
}

std::string text(const ForetoldSaturation& foretold) {
  return fmt::format("{}: {} at {:.6g} {}, first at {:.6g} s", foretold.device, name_of(foretold.cause), foretold.limit,
                     unit_of(foretold.cause), seconds(foretold.first));
}

std::vector<Diagnostic> foretold_errors(const Scenario& scenario, const std::vector<StrategyPlan>& plans,
                                        const std::vector<ForetoldSaturation>& foretold) {
  std::vector<Diagnostic> errors;
  for (const Expectation& expectation : scenario.expectations) {
    if (expectation.confidence) continue;
    const auto is_met = [&](const ForetoldSaturation& one, const StrategyPlan& plan, const char* of) {
      const std::string signal = fmt::format("{}.{}.{}", one.device, of, name_of(plan.kind));
      const bool reaches_steps = one.cause == SaturationCause::device_position && !traits_of(plan.kind).knows_motion;
      const bool in_time = one.first + plan.latency < RealTime{scenario.run_duration.ns};
      return !one.expected && in_time && internal::matches(expectation.signal, signal) &&
             judges_shape(signal, expectation.metric) && (std::string_view(of) == "force" || reaches_steps);
    };
    const ForetoldSaturation* met = nullptr;
    for (const ForetoldSaturation& one : foretold) {
      for (const StrategyPlan& plan : plans) {
        if (!met && (is_met(one, plan, "force") || is_met(one, plan, "interaction"))) met = &one;
      }
    }
    if (!met) continue;
    const Place& place = expectation.place;
    errors.push_back({place.file, place.line, place.column,
                      fmt::format("'{}' of '{}' cannot be judged: {}; {}", expectation.metric, expectation.signal,
                                  text(*met), internal::remedy_of(met->cause))});
  }
  return errors;
}

}  // namespace evenstep
