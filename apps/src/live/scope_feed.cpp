#include "scope_feed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "status.h"

namespace evenstep::app {
namespace {

using nlohmann::json;

constexpr std::int64_t kMostTicksPerSecond = 2000;

/// Millionths are enough for a screen, and short.
json rounded(double value) {
  const double millionths = std::round(value * 1e6);
  return std::isfinite(millionths) ? json(millionths / 1e6) : json();
}
json at_s(std::int64_t ns) { return rounded(static_cast<double>(ns) * 1e-9); }
json milliseconds(Duration time) { return rounded(static_cast<double>(time.ns) * 1e-6); }
json milliseconds(const std::optional<Duration>& time) { return time ? milliseconds(*time) : json(); }

json columns() { return json::array({json::array(), json::array(), json::array()}); }
void append(json& to, const glm::dvec3& v, double factor) {
  for (int axis = 0; axis < 3; ++axis) to[static_cast<std::size_t>(axis)].push_back(rounded(v[axis] * factor));
}

json empty_rows() {
  return {{"steps",
           {{"simulated", json::array()},
            {"end", json::array()},
            {"hand", columns()},
            {"direct", columns()},
            {"sample", json::array()},
            {"force", json::array()}}},
          {"ticks", {{"at", json::array()}, {"force", columns()}, {"direct", columns()}}}};
}

std::string text_of(const json& value) { return value.dump(-1, ' ', true, json::error_handler_t::replace); }

double rate_of(std::int64_t count, Duration span) { return span.ns > 0 ? static_cast<double>(count) / seconds(span) : 0; }

}  // namespace

ScopeFeed::ScopeFeed(const Scenario& scenario, const WatchedRun& run) : run_(run), shadow_(scenario) {
  for (const WatchedRun::Device& device : run.devices)
    devices_.push_back({std::max<std::int64_t>(1, device.rate.num / device.rate.den / kMostTicksPerSecond), {}});
}

ScopeText ScopeFeed::page_text() const {
  ScopeText text{run_.scenario, run_.strategy, {}, "", ""};
  json devices = json::array();
  bool some = false;
  for (std::size_t i = 0; i < run_.devices.size(); ++i) {
    text.devices.push_back(run_.devices[i].name);
    devices.push_back({{"name", run_.devices[i].name}, {"limit_N", rounded(run_.devices[i].limit_N)}});
    const std::string why = shadow_.no_force(i);
    some |= why.empty();
    if (!why.empty()) text.shadow_note = "Without direct's force: " + why + ".";
  }
  text.program = text_of({{"strategy", run_.strategy}, {"devices", devices}, {"shadow_force", some}});
  return text;
}

void ScopeFeed::add(const SeenTick& tick) {
  devices_[tick.tool].worst.add(tick.guard);
  shadow_.add(tick);
}
void ScopeFeed::add(const SeenStep& step) { shadow_.add(step); }

std::string ScopeFeed::rows(RealTime until) {
  json devices = json::array();
  for (std::size_t i = 0; i < devices_.size(); ++i) devices.push_back(empty_rows());
  const auto tick = [&](const ShadowedTick& seen) {
    if (seen.tick.ran % devices_[seen.tick.tool].every != 0) return;
    json& rows = devices[seen.tick.tool]["ticks"];
    rows["at"].push_back(at_s(seen.tick.scheduled.ns));
    append(rows["force"], seen.tick.force_N, 1);
    append(rows["direct"], seen.direct_N.value_or(glm::dvec3(NAN)), 1);
  };
  const auto step = [&](const ShadowedStep& seen) {
    for (std::size_t i = 0; i < devices_.size(); ++i) {
      json& rows = devices[i]["steps"];
      rows["simulated"].push_back(at_s(seen.step.simulated.ns));
      rows["end"].push_back(at_s(seen.step.end.ns));
      append(rows["hand"], seen.step.tools[i].hand_m, 1e3);
      append(rows["direct"], seen.direct_m[i], 1e3);
      rows["sample"].push_back(seen.step.mapped ? milliseconds(seen.step.tools[i].sample_margin) : json());
      rows["force"].push_back(seen.step.mapped ? milliseconds(seen.step.force_margin) : json());
    }
  };
  shadow_.take(until, tick, step);
  json states = json::array();
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    states.push_back(state_text(run_.devices[i], devices_[i].worst));
    devices_[i].worst.guard.reset();
  }
  return text_of({{"devices", std::move(devices)}, {"states", std::move(states)}});
}

std::string ScopeFeed::figures(const LiveSnapshot& now) {
  json forces = json::array();
  for (const LiveSnapshot::Device& device : now.devices) forces.push_back(rounded(device.force_N));
  const LiveSpan &last = now.last, &whole = now.whole;
  return text_of({{"left_s", std::ceil(seconds(now.left))},
                  {"ticks_per_s", rounded(rate_of(last.counts.ticks, now.span * std::ssize(now.devices)))},
                  {"steps_per_s", rounded(rate_of(last.counts.steps, now.span))},
                  {"p50_ms", milliseconds(now.lateness_p50)},
                  {"p99_ms", milliseconds(now.lateness_p99)},
                  {"max_ms", milliseconds(last.lateness_max)},
                  {"max_run_ms", milliseconds(whole.lateness_max)},
                  {"missed", last.counts.missed},
                  {"missed_run", whole.counts.missed},
                  {"late_reads", last.counts.late_reads},
                  {"late_reads_run", whole.counts.late_reads},
                  {"late_forces", last.counts.late_forces},
                  {"late_forces_run", whole.counts.late_forces},
                  {"margin_ms", milliseconds(last.least_margin)},
                  {"margin_run_ms", milliseconds(whole.least_margin)},
                  {"clamped", last.clamped},
                  {"clamped_run", whole.clamped},
                  {"force_N", std::move(forces)},
                  {"dropped", now.dropped}});
}

}  // namespace evenstep::app
