#include "evenstep/device/hid/simulated_pid_device.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "../effect_springs.h"
#include "../turns.h"

namespace evenstep {
namespace {

// The bits of a state report; its block lies above them.
constexpr std::uint64_t kActuatorsPaused = 1, kEnabled = 2, kSafety = 4, kPower = 8, kPlaying = 16, kIsState = 32;
constexpr int kBlockShift = 8;

double fraction(std::span<const std::byte> report, const PidValue& value) {
  return static_cast<double>(get(report, value).value_or(0)) / static_cast<double>(value.field.logical_maximum);
}
double fraction(std::span<const std::byte> report, const std::optional<PidValue>& value, double otherwise) {
  return value ? fraction(report, *value) : otherwise;
}

}  // namespace

SimulatedPidDevice::SimulatedPidDevice(const Clock& clock, HeldBy by, SimulatedPidOptions options)
    : clock_(clock),
      reports_(std::move(by), options.reports),
      options_(std::move(options)),
      descriptor_(pid_descriptor(options_.descriptor)),
      parsed_(*parse_report_descriptor(descriptor_)),
      layout_(*pid_layout(parsed_)),
      info_{options_.reports.name, 0x1209, 0x0E58, "evenstep PID device", ""},
      effects_(static_cast<std::size_t>(options_.pool_effects) + 1),
      enabled_(!layout_.device_control) {
  assert(options_.pool_effects >= 0 && options_.pool_effects <= 40);
}

// ---- time

/// Carries out everything that has happened since the last call, in order of time.
void SimulatedPidDevice::catch_up() {
  const RealTime now = clock_.now();
  while (const auto at = next_change(now)) {
    run_until(*at);
    if (reports_.is_gone()) return;
    change_at(*at);
  }
  run_until(now);
}

std::optional<RealTime> SimulatedPidDevice::next_change(RealTime until) const {
  std::optional<RealTime> next;
  const auto consider = [&](RealTime at) {
    if (at <= until && (!next || at < *next)) next = at;
  };
  for (const Effect& effect : effects_) {
    if (effect.playing && effect.ends_at) consider(*effect.ends_at);
  }
  if (next_event_ < options_.events.size()) consider(options_.events[next_event_].at);
  return next;
}

void SimulatedPidDevice::change_at(RealTime at) {
  for (std::size_t block = 1; block < effects_.size(); ++block) {
    Effect& effect = effects_[block];
    if (!effect.playing || !effect.ends_at || *effect.ends_at > at) continue;
    effect.playing = false;
    ++effects_ended_;
    say_state(block);
  }
  for (; next_event_ < options_.events.size() && options_.events[next_event_].at <= at; ++next_event_) {
    const PidDeviceEvent& event = options_.events[next_event_];
    (event.kind == PidDeviceEvent::Kind::safety_switch ? safety_ : power_) = event.on;
    say_state(0);
  }
  render(at);
}

void SimulatedPidDevice::run_until(RealTime until) {
  if (any_spring()) {
    const RealTime first = options_.reports.first_tick;
    for (;; ++next_firmware_tick_) {
      const RealTime tick = tick_time(options_.firmware_rate, next_firmware_tick_, first);
      if (tick > until) break;
      reports_.advance(tick);
      if (reports_.is_gone()) return;
      render(tick);
    }
  }
  reports_.advance(until);
}

void SimulatedPidDevice::render(RealTime at) {
  const glm::dvec3 force_N = force_at(reports_.position_m(at));
  motors_.render(at, force_N);
  reports_.feel(at, force_N);
}

bool SimulatedPidDevice::any_spring() const {
  return std::any_of(effects_.begin(), effects_.end(),
                     [](const Effect& effect) { return effect.playing && effect.is_spring; });
}

// ---- force

glm::dvec3 SimulatedPidDevice::force_N() {
  catch_up();
  if (reports_.is_gone()) return glm::dvec3(0);
  return force_at(reports_.position_m(clock_.now()));
}

MotorState SimulatedPidDevice::motors() {
  MotorState state;
  state.force_N = force_N();
  if (!reports_.is_gone()) {
    motors_.until(clock_.now());
    state.effects_playing = playing();
    state.effects_allocated = allocated();
    state.actuators_enabled = enabled_ && layout_.device_control;
  }
  motors_.tell(state);
  state.effects_ended = effects_ended_;
  return state;
}

glm::dvec3 SimulatedPidDevice::force_at(const glm::dvec3& position_m) const {
  glm::dvec3 share{0};
  if (paused_ || !enabled_ || !safety_ || !power_) return share;
  for (const Effect& effect : effects_) {
    if (!effect.playing) continue;
    for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
      if (effect.along[axis] == 0) continue;
      share[static_cast<int>(axis)] += effect.is_spring
                                           ? spring_force(effect, axis, position_m) * std::abs(effect.along[axis])
                                           : effect.magnitude * effect.gain * effect.along[axis];
    }
  }
  for (int axis = 0; axis < 3; ++axis) share[axis] = std::clamp(share[axis], -1.0, 1.0) * gain_ * options_.full_scale_N;
  return share;
}

double SimulatedPidDevice::spring_force(const Effect& effect, std::size_t axis, const glm::dvec3& position_m) const {
  const Condition& condition = effect.conditions[effect.by_axis ? axis : 0];
  const auto along = static_cast<int>(axis);
  const double deflection = position_m[along] / (options_.travel_m[along] / 2) - condition.center;
  const double past = (std::abs(deflection) - condition.dead_band) * internal::full_steepness(options_, along);
  if (past <= 0) return 0;
  const double pull = deflection > 0 ? std::min(condition.above * past, condition.saturation_above)
                                     : std::min(condition.below * past, condition.saturation_below);
  return effect.gain * (deflection > 0 ? -pull : pull);
}

int SimulatedPidDevice::playing() const {
  return static_cast<int>(
      std::count_if(effects_.begin(), effects_.end(), [](const Effect& effect) { return effect.playing; }));
}
int SimulatedPidDevice::allocated() const {
  return static_cast<int>(
      std::count_if(effects_.begin(), effects_.end(), [](const Effect& effect) { return effect.allocated; }));
}

// ---- input reports

HidRead SimulatedPidDevice::read(std::span<std::byte> buffer) {
  catch_up();
  if (reports_.is_gone()) return {HidRead::Status::gone};
  if (reports_.take_interruption()) return {HidRead::Status::interrupted};
  const auto report = reports_.take();
  if (!report) return {HidRead::Status::nothing};
  return deliver(*report, report->other != 0 ? state_report(report->other) : position_report(*report), buffer);
}

std::vector<std::byte> SimulatedPidDevice::position_report(const SimulatedReport& report) const {
  std::vector<std::byte> bytes(layout_.position[0]->report.size);
  bytes[0] = std::byte{layout_.position[0]->report.id};
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
    if (!layout_.position[axis]) continue;
    const PidValue& value = layout_.position[axis]->value;
    const auto range = static_cast<double>(value.field.logical_maximum - value.field.logical_minimum);
    const double share = report.position_m[static_cast<int>(axis)] / options_.travel_m[static_cast<int>(axis)] + 0.5;
    set_nearest(bytes, value, value.field.logical_minimum + static_cast<std::int64_t>(std::round(share * range)));
  }
  return bytes;
}

void SimulatedPidDevice::say_state(std::size_t block) {
  if (!layout_.state) return;
  const bool plays = layout_.state->block && block != 0 ? effects_[block].playing : playing() > 0;
  reports_.push(kIsState | (paused_ ? kActuatorsPaused : 0) | (enabled_ ? kEnabled : 0) | (safety_ ? kSafety : 0) |
                (power_ ? kPower : 0) | (plays ? kPlaying : 0) | std::uint64_t{block} << kBlockShift);
}

std::vector<std::byte> SimulatedPidDevice::state_report(std::uint64_t state) const {
  const PidStateLayout& layout = *layout_.state;
  std::vector<std::byte> bytes(layout.report.size);
  bytes[0] = std::byte{layout.report.id};
  const auto put = [&](const std::optional<PidValue>& value, std::uint64_t content) {
    if (value) set_nearest(bytes, *value, static_cast<std::int64_t>(content));
  };
  put(layout.paused, (state & kActuatorsPaused) != 0);
  put(layout.actuators_enabled, (state & kEnabled) != 0);
  put(layout.safety_switch, (state & kSafety) != 0);
  put(layout.actuator_power, (state & kPower) != 0);
  put(layout.effect_playing, (state & kPlaying) != 0);
  put(layout.block, state >> kBlockShift);
  return bytes;
}

// ---- output reports

HidWrite SimulatedPidDevice::write(std::span<const std::byte> report) {
  catch_up();
  if (reports_.is_gone()) return HidWrite::gone;
  const HidReport* known =
      report.empty() ? nullptr : parsed_.report(ReportType::output, std::to_integer<std::uint8_t>(report[0]));
  bool lost = false;
  if (known == nullptr || report.size() < known->size() || reports_.write_fault(lost) == HidWrite::rejected)
    return HidWrite::rejected;
  if (lost) return HidWrite::ok;
  motors_.heard(clock_.now());
  take(report);
  render(clock_.now());
  return HidWrite::ok;
}

void SimulatedPidDevice::take(std::span<const std::byte> report) {
  const auto is = [id = std::to_integer<std::uint8_t>(report[0])](const auto& layout) { return layout.report.id == id; };
  const auto is_there = [&](const auto& layout) { return layout && is(*layout); };
  if (is(layout_.set_effect)) take_effect(report);
  if (is(layout_.set_constant)) take_constant(report);
  if (is_there(layout_.set_condition)) take_condition(report);
  if (is(layout_.operation)) take_operation(report);
  if (is_there(layout_.device_control)) take_control(report);
  if (is_there(layout_.device_gain)) gain_ = fraction(report, layout_.device_gain->gain);
  if (is_there(layout_.block_free)) free(static_cast<std::size_t>(get(report, layout_.block_free->block).value_or(0)));
}

/// The effect that a report names; nullptr if the block does not exist or was not created: the report is then ignored.
SimulatedPidDevice::Effect* SimulatedPidDevice::effect_of(std::span<const std::byte> report, const PidValue& block) {
  const auto index = static_cast<std::size_t>(get(report, block).value_or(0));
  return index >= 1 && index < effects_.size() && effects_[index].allocated ? &effects_[index] : nullptr;
}

void SimulatedPidDevice::take_effect(std::span<const std::byte> report) {
  const PidSetEffect& layout = layout_.set_effect;
  const auto index = static_cast<std::size_t>(get(report, layout.block).value_or(0));
  if ((!layout_.create_effect || !options_.device_managed) && index >= 1 && index < effects_.size())
    effects_[index].allocated = true;
  Effect* effect = effect_of(report, layout.block);
  if (effect == nullptr) return;
  effect->is_spring = layout.spring && is_chosen(report, *layout.spring);
  effect->gain = fraction(report, layout.gain, 1);
  effect->along = axes_of(report, effect->is_spring);
  effect->duration.reset();
  if (!layout.duration) return;
  const std::int64_t counts = get(report, *layout.duration).value_or(0);
  if (counts == kPidInfinite || counts > layout.duration->field.logical_maximum) return;
  effect->duration = Duration{
      static_cast<std::int64_t>(std::round(static_cast<double>(counts) * seconds_per_count(layout.duration->field) * 1e9))};
}

/// The axis bits select the axes; if none is set, a direction acts along X and Y. A spring along an axis has no direction. A
/// force along X without one is as if from 90 degrees.
std::array<double, pid::kAxes> SimulatedPidDevice::axes_of(std::span<const std::byte> report, bool is_spring) const {
  const PidSetEffect& layout = layout_.set_effect;
  std::array<double, pid::kAxes> along{};
  const bool by_direction =
      !layout.directions.empty() && (!layout.direction_enable || get(report, *layout.direction_enable) == 1);
  const auto is_set = [&](const std::optional<PidValue>& axis) { return axis && get(report, *axis) == 1; };
  const bool any_bit = std::any_of(layout.axis_enable.begin(), layout.axis_enable.end(), is_set);
  const bool lists_axes =
      std::any_of(layout.axis_enable.begin(), layout.axis_enable.end(), [](const auto& axis) { return axis.has_value(); });
  double turns = 0;
  if (by_direction) {
    const FieldLayout& field = layout.directions.front().field;
    turns = static_cast<double>(*get(report, layout.directions.front()) - field.logical_minimum) /
            static_cast<double>(field.logical_maximum - field.logical_minimum);
  }
  // Away from where the direction points: north is the lower end of Y, east the upper one of X.
  using internal::sin_of_turn;
  const std::array<double, pid::kAxes> direction{-sin_of_turn(turns), sin_of_turn(turns + 0.25), 0};
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
    const bool enabled = any_bit ? is_set(layout.axis_enable[axis]) : by_direction ? axis < 2 : !lists_axes && axis == 0;
    if (enabled)
      along[axis] = by_direction && axis < 2 && !(is_spring && any_bit) ? direction[axis] : axis == 0 && !is_spring ? -1 : 1;
  }
  return along;
}

void SimulatedPidDevice::take_constant(std::span<const std::byte> report) {
  if (Effect* effect = effect_of(report, layout_.set_constant.block))
    effect->magnitude = fraction(report, layout_.set_constant.magnitude);
}

void SimulatedPidDevice::take_condition(std::span<const std::byte> report) {
  const PidSetCondition& layout = *layout_.set_condition;
  Effect* effect = effect_of(report, layout.block);
  if (effect == nullptr) return;
  Condition condition;
  condition.center = fraction(report, layout.center, 0);
  condition.above = fraction(report, layout.positive_coefficient);
  condition.below = fraction(report, layout.negative_coefficient, condition.above);
  condition.saturation_above = fraction(report, layout.positive_saturation, 1);
  condition.saturation_below = fraction(report, layout.negative_saturation, condition.saturation_above);
  condition.dead_band = fraction(report, layout.dead_band, 0);
  const std::int64_t block = layout.parameter_block ? get(report, *layout.parameter_block).value_or(0) : 0;
  if (block < 0 || block >= static_cast<std::int64_t>(pid::kAxes)) return;
  effect->conditions[static_cast<std::size_t>(block)] = condition;
  effect->by_axis = effect->by_axis || block > 0;
}

void SimulatedPidDevice::take_operation(std::span<const std::byte> report) {
  Effect* effect = effect_of(report, layout_.operation.block);
  if (effect == nullptr) return;
  const bool starts = is_chosen(report, layout_.operation.start);
  if (!starts && !(layout_.operation.stop && is_chosen(report, *layout_.operation.stop))) return;
  const bool changed = effect->playing != starts;
  const bool any_before = any_spring();
  effect->playing = starts;
  effect->ends_at.reset();
  if (starts && effect->duration) effect->ends_at = clock_.now() + *effect->duration;
  // A spring is rendered from the next firmware tick on.
  if (!any_before)
    next_firmware_tick_ = first_tick_at_or_after(options_.firmware_rate, clock_.now(), options_.reports.first_tick);
  if (changed) say_state(static_cast<std::size_t>(effect - effects_.data()));
}

void SimulatedPidDevice::take_control(std::span<const std::byte> report) {
  const PidDeviceControl& layout = *layout_.device_control;
  const auto commanded = [&](const std::optional<PidChoice>& command) { return command && is_chosen(report, *command); };
  if (commanded(layout.reset)) reset();
  if (commanded(layout.enable_actuators)) enabled_ = true;
  if (commanded(layout.disable_actuators)) enabled_ = false;
  if (commanded(layout.pause)) paused_ = true;
  if (commanded(layout.resume)) paused_ = false;
  if (commanded(layout.stop_all)) {
    for (Effect& effect : effects_) effect.playing = false;
  }
  say_state(0);
}

void SimulatedPidDevice::reset() {
  std::fill(effects_.begin(), effects_.end(), Effect{});
  enabled_ = true;
  paused_ = false;
  gain_ = 1;
}

void SimulatedPidDevice::free(std::size_t block) {
  if (block >= 1 && block < effects_.size()) effects_[block] = {};
}

// ---- feature reports

std::size_t SimulatedPidDevice::lowest_free() const {
  for (std::size_t block = 1; block < effects_.size(); ++block) {
    if (!effects_[block].allocated) return block;
  }
  return 0;
}

HidWrite SimulatedPidDevice::set_feature(std::span<const std::byte> report) {
  catch_up();
  if (reports_.is_gone()) return HidWrite::gone;
  const auto& create = layout_.create_effect;
  if (!create || report.size() < create->report.size || std::to_integer<std::uint8_t>(report[0]) != create->report.id)
    return HidWrite::rejected;
  const bool is_spring = create->spring && is_chosen(report, *create->spring);
  const std::size_t block = lowest_free();
  load_ = {0, layout_.block_load ? layout_.block_load->error : std::nullopt, options_.block_load_delay};
  if (created_++ == options_.block_load_error_at || !options_.device_managed ||
      !(is_spring || is_chosen(report, create->constant)))
    return HidWrite::ok;
  if (block == 0) {
    load_.status = layout_.block_load->full;
    return HidWrite::ok;
  }
  effects_[block] = {};
  effects_[block].allocated = true;
  load_.block = block;
  load_.status = layout_.block_load->success;
  return HidWrite::ok;
}

HidFeature SimulatedPidDevice::get_feature(std::span<std::byte> report) {
  catch_up();
  if (reports_.is_gone()) return {HidFeature::Status::gone};
  if (options_.feature_interruptions > 0 && options_.feature_interruptions-- > 0) return {HidFeature::Status::interrupted};
  const auto asks = [&](const auto& layout) {
    return layout && report.size() >= layout->report.size && std::to_integer<std::uint8_t>(report[0]) == layout->report.id;
  };
  if (asks(layout_.block_load)) {
    std::fill(report.begin() + 1, report.end(), std::byte{0});
    if (load_.unanswered-- > 0) return {HidFeature::Status::ok, layout_.block_load->report.size};
    set_nearest(report, layout_.block_load->block, static_cast<std::int64_t>(load_.block));
    if (load_.status) choose(report, *load_.status);
    return {HidFeature::Status::ok, layout_.block_load->report.size};
  }
  if (!asks(layout_.pool)) return {HidFeature::Status::rejected};
  std::fill(report.begin() + 1, report.end(), std::byte{0});
  const int simultaneous = options_.pool_unready-- > 0 ? 0 : options_.simultaneous;
  if (layout_.pool->simultaneous) set_nearest(report, *layout_.pool->simultaneous, simultaneous);
  if (layout_.pool->device_managed) set_nearest(report, *layout_.pool->device_managed, options_.device_managed);
  return {HidFeature::Status::ok, layout_.pool->report.size};
}

}  // namespace evenstep
