#include "evenstep/device/inverse3/simulated_inverse3.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

namespace evenstep {
namespace {

/// The entry of one device, as a ROS 2 node and a SOFA plugin print what they were sent.
std::string entry(const std::string& device_id, const std::string& config, const glm::dvec3& position_m, bool calibrated,
                  bool in_use) {
  return fmt::format(
      R"({{"device_id":"{}",{}"state":{{"control_mode":"idle","cursor_position":{{"x":{},"y":{},"z":{}}},)"
      R"("cursor_velocity":{{"x":0,"y":0,"z":0}}}},"status":{{"calibrated":{},"in_use":{},"power_supply":true,)"
      R"("ready":true,"started":true}}}})",
      device_id, config, static_cast<float>(position_m.x), static_cast<float>(position_m.y),
      static_cast<float>(position_m.z), calibrated, in_use);
}

const std::string kAskAll = R"({"session":{"force_render_full_state":{}}})";

std::string message(const std::string& entry) { return R"({"inverse3":[)" + entry + R"(],"session_id":7})"; }

}  // namespace

SimulatedInverse3::SimulatedInverse3(const Clock& clock, HeldBy by, SimulatedInverse3Options options)
    : clock_(clock),
      reports_(std::move(by), options.reports),
      options_(std::move(options)),
      outbox_(kAskAll, options_.hold) {
  say_first(clock_.now());
}

/// The inventory that a new connection begins with.
void SimulatedInverse3::say_first(RealTime at) {
  const glm::dvec3 position_m = reports_.position_m(at) + options_.origin_m;
  first_message_ = message(entry(options_.device_id, R"("config":{"handedness":"right","port":"COM12"},)", position_m,
                                 !options_.uncalibrated_at || at < *options_.uncalibrated_at, options_.in_use));
}

bool SimulatedInverse3::is_gone() {
  const RealTime now = clock_.now();
  if (!reports_.is_gone()) answer_until(now);
  if (!reports_.is_gone()) return false;
  reports_.advance(now);
  if (!reports_.take_returned()) return true;
  begin_anew();
  answer_until(now);
  return reports_.is_gone();
}

void SimulatedInverse3::answer_until(RealTime now) {
  const SimulatedDeviceOptions& device = options_.reports;
  while (!reports_.is_gone() && tick_time(device.rate, next_tick_, device.first_tick) <= now) {
    const RealTime tick = tick_time(device.rate, next_tick_++, device.first_tick);
    reports_.advance(tick);
    if (reports_.is_gone()) break;
    while (const auto report = reports_.pop()) newest_ = report;
    hear(tick, outbox_.due(tick));
  }
  if (!reports_.is_gone()) reports_.advance(now);
}

/// A new connection: the link asks for all devices and sends nothing of what was posted to the old one, whose force ended
/// with it.
void SimulatedInverse3::begin_anew() {
  motors_.lose(reports_.lost_at());
  force_N_ = glm::dvec3(0);
  newest_.reset();
  outbox_ = Inverse3Outbox(kAskAll, options_.hold);
  next_tick_ = reports_.next_tick();
  say_first(tick_time(options_.reports.rate, next_tick_, options_.reports.first_tick));
  has_returned_ = true;
}

/// The force that a message asks of our device; empty: it asks for none.
std::optional<glm::dvec3> SimulatedInverse3::asked_N(const std::string& text) const {
  std::optional<glm::dvec3> asked_N;
  const nlohmann::json order = nlohmann::json::parse(text, nullptr, false);
  if (!order.is_object() || !order.contains("inverse3")) return asked_N;
  for (const nlohmann::json& device : order["inverse3"]) {
    if (device.value("device_id", "") != options_.device_id) continue;
    const nlohmann::json force = device.value("/commands/set_cursor_force/values"_json_pointer, nlohmann::json::object());
    asked_N.emplace(0);
    for (int axis = 0; axis < 3; ++axis)
      (*asked_N)[axis] = static_cast<float>(force.value(std::string(1, "xyz"[axis]), 0.0));
  }
  return asked_N;
}

void SimulatedInverse3::hear(RealTime at, const std::string& text) {
  bool lost = false;
  if (reports_.write_fault(lost) == HidWrite::rejected || lost) return;
  const std::optional<glm::dvec3> wanted_N = asked_N(text);
  if (!wanted_N) return;
  motors_.heard(at);
  if (*wanted_N == force_N_) return;
  force_N_ = *wanted_N;
  motors_.render(at, force_N_);
  reports_.feel(at, force_N_);
}

std::string SimulatedInverse3::told(const SimulatedReport& report) const {
  using Shape = SimulatedReport::Shape;
  const RealTime at = tick_time(options_.reports.rate, report.tick, options_.reports.first_tick);
  const bool calibrated = !options_.uncalibrated_at || at < *options_.uncalibrated_at;
  const glm::dvec3 position_m = calibrated ? report.position_m + options_.origin_m : glm::dvec3(1);
  std::string text =
      message(entry(report.shape == Shape::unknown_id ? "FFFF" : options_.device_id, "", position_m, calibrated, true));
  if (report.shape == Shape::cut) text.resize(std::min(text.size(), static_cast<std::size_t>(report.bytes)));
  if (report.shape == Shape::longer) text.append(static_cast<std::size_t>(report.bytes), ']');
  return text;
}

Inverse3Link::Read SimulatedInverse3::read(std::string& text) {
  if (is_gone()) {
    text = "the connection to the service was closed";
    return reports_.is_away() ? Read::away : Read::gone;
  }
  if (std::exchange(has_returned_, false)) return Read::returned;
  if (reports_.is_unread()) return Read::nothing;
  if (!newest_) return Read::nothing;
  text = told(*newest_);
  newest_.reset();
  return Read::message;
}

void SimulatedInverse3::post(std::string text) {
  if (is_gone()) return motors_.ask_away(asked_N(text).value_or(glm::dvec3(0)));
  outbox_.post(std::move(text), clock_.now());
  hear(clock_.now(), outbox_.due(clock_.now()));
}

void SimulatedInverse3::rest(std::string text) {
  outbox_.rest(std::move(text));
  if (!is_gone()) hear(clock_.now(), outbox_.last());
}

MotorState SimulatedInverse3::motors() {
  MotorState state;
  if (!is_gone()) {
    motors_.until(clock_.now());
    state.force_N = force_N_;
  }
  motors_.tell(state);
  return state;
}

}  // namespace evenstep
