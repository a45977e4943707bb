#include "evenstep/device/evdev/simulated_evdev.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <utility>

#include "../effect_springs.h"
#include "../turns.h"

namespace evenstep {
namespace {

constexpr std::size_t kPlaces = 64;  // of the program's buffer

/// Smooths a value as the kernel's input core does: changes below half of the fuzz vanish, larger ones count partly.
std::int32_t smoothed(std::int32_t value, std::int32_t old, std::int32_t fuzz) {
  const std::int64_t change = std::abs(std::int64_t{value} - old);
  if (fuzz == 0 || change >= std::int64_t{fuzz} * 2) return value;
  if (change < fuzz / 2) return old;
  if (change < fuzz) return static_cast<std::int32_t>((std::int64_t{old} * 3 + value) / 4);
  return static_cast<std::int32_t>((std::int64_t{old} + value) / 2);
}

}  // namespace

SimulatedEvdev::SimulatedEvdev(const Clock& clock, HeldBy by, SimulatedEvdevOptions options)
    : clock_(clock),
      reports_(std::move(by), options.reports),
      options_(std::move(options)),
      info_{options_.reports.name, "evenstep evdev device", 0x1209, 0x0E59},
      slots_(static_cast<std::size_t>(options_.effects)),
      autocenter_(options_.autocenter) {
  for (int i = 0; i < std::min(options_.effects, options_.foreign_effects); ++i)
    slots_[static_cast<std::size_t>(i)].owner = Owner::other;
  for (EvdevAxis& axis : axes_) axis = {0, options_.minimum, options_.maximum, options_.fuzz};
}

// ---- time

void SimulatedEvdev::catch_up() {
  const RealTime now = clock_.now();
  if (!reports_.is_gone()) change_until(now);
  if (!reports_.is_gone()) return;
  reports_.advance(now);
  if (!reports_.take_returned()) return;
  begin_anew();
  change_until(now);
}

void SimulatedEvdev::change_until(RealTime now) {
  while (const auto at = next_change(now)) {
    run_until(*at);
    if (reports_.is_gone()) return;
    change_at(*at);
  }
  run_until(now);
}

/// The device knows no effects, and centers by itself from when it was plugged in. The node is new; the program that found
/// it has uploaded its effects again, without force and under the same numbers.
void SimulatedEvdev::begin_anew() {
  motors_.lose(reports_.lost_at());
  for (Slot& slot : slots_) {
    const bool is_ours = slot.owner == Owner::we;
    slot.playing = false;
    slot.ends_at.reset();
    slot.known.level = 0;
    slot.known.conditions = {};
    slot.loaded = slot.known;
    if (!is_ours) slot = {};
  }
  gain_ = 0xFFFF;
  autocenter_ = options_.autocenter;
  render(reports_.plugged_in_at());
  for (EvdevAxis& axis : axes_) axis = {0, options_.minimum, options_.maximum, options_.fuzz};
  queue_.clear();
  complete_ = 0;
  next_tick_ = reports_.next_tick();
  has_returned_ = true;
}

/// The answer of a LiveEvdev whose device is away or gone.
int SimulatedEvdev::without_device() const { return reports_.is_away() ? ENXIO : ENODEV; }

bool SimulatedEvdev::is_gone() {
  catch_up();
  return reports_.is_gone();
}

std::optional<RealTime> SimulatedEvdev::next_change(RealTime until) const {
  std::optional<RealTime> next;
  const auto consider = [&](const std::optional<RealTime>& at) {
    if (at && *at <= until && (!next || *at < *next)) next = at;
  };
  for (const Slot& slot : slots_) {
    if (slot.playing) consider(slot.ends_at);
  }
  if (!meddled_) consider(options_.meddled_at);
  return next;
}

void SimulatedEvdev::change_at(RealTime at) {
  for (Slot& slot : slots_) {
    if (!slot.playing || !slot.ends_at || *slot.ends_at > at) continue;
    slot.playing = false;
    ++effects_ended_;
  }
  if (!meddled_ && options_.meddled_at && *options_.meddled_at <= at) {
    meddled_ = true;
    gain_ = 0;
    autocenter_ = 0xFFFF;
    for (Slot& slot : slots_) slot.playing = false;
  }
  render(at);
}

void SimulatedEvdev::run_until(RealTime until) {
  if (is_springy()) {
    const RealTime first = options_.reports.first_tick;
    for (;; ++next_firmware_tick_) {
      const RealTime tick = tick_time(options_.firmware_rate, next_firmware_tick_, first);
      if (tick > until) break;
      report_until(tick);
      if (reports_.is_gone()) return;
      render(tick);
    }
  }
  report_until(until);
}

/// The kernel takes each report as it comes, so no report waits on the device.
void SimulatedEvdev::report_until(RealTime until) {
  const SimulatedDeviceOptions& device = options_.reports;
  for (; tick_time(device.rate, next_tick_, device.first_tick) <= until; ++next_tick_) {
    reports_.advance(tick_time(device.rate, next_tick_, device.first_tick));
    if (reports_.is_gone()) return;
    while (const auto report = reports_.pop()) publish(*report);
  }
  reports_.advance(until);
  if (reports_.is_gone()) return;
  while (const auto report = reports_.pop()) publish(*report);  // reports that have an age come between two ticks
}

// ---- events

void SimulatedEvdev::publish(const SimulatedReport& report) {
  using Shape = SimulatedReport::Shape;
  if (report.shape == Shape::cut || report.shape == Shape::unknown_id) return;
  const RealTime at = stamp_of(report);
  for (int axis = 0; axis < 3; ++axis) {
    if (!has_axis(static_cast<std::uint16_t>(axis))) continue;
    EvdevAxis& range = axes_[static_cast<std::size_t>(axis)];
    const double share = std::clamp(report.position_m[axis] / options_.travel_m[axis] + 0.5, 0.0, 1.0);
    const double span = static_cast<double>(std::int64_t{range.maximum} - range.minimum);
    const auto exact = static_cast<std::int32_t>(range.minimum + static_cast<std::int64_t>(std::round(share * span)));
    const std::int32_t value = smoothed(exact, range.value, range.fuzz);
    if (value == range.value) continue;
    range.value = value;
    queue({evdev::kAbs, static_cast<std::uint16_t>(axis), value, at});
  }
  queue({evdev::kSyn, evdev::kSynReport, 0, at});
}

/// The time of the report's tick, in the whole microseconds of struct input_event.
RealTime SimulatedEvdev::stamp_of(const SimulatedReport& report) const {
  const RealTime tick = tick_time(options_.reports.rate, report.tick, options_.reports.first_tick);
  return {floor_mul_div(tick.ns, 1, 1000) * 1000};
}

void SimulatedEvdev::queue(const EvdevEvent& event) {
  if (options_.held) return;
  const bool ends_report = event.type == evdev::kSyn && event.code == evdev::kSynReport;
  if (ends_report && complete_ == queue_.size()) return;  // an empty report
  queue_.push_back(event);
  if (queue_.size() == kPlaces) {
    queue_ = {{evdev::kSyn, evdev::kSynDropped, 0, event.at}, event};
    complete_ = 0;
  }
  if (ends_report) complete_ = queue_.size();
}

EvdevRead SimulatedEvdev::read(std::span<EvdevEvent> events) {
  if (is_gone()) return {reports_.is_away() ? EvdevRead::Status::away : EvdevRead::Status::gone};
  if (std::exchange(has_returned_, false)) return {EvdevRead::Status::returned};
  if (reports_.take_interruption()) return {EvdevRead::Status::interrupted};
  if (reports_.is_unread()) return {};
  std::size_t count = 0;
  for (; count < events.size() && complete_ > 0; ++count, --complete_) {
    events[count] = queue_.front();
    queue_.pop_front();
  }
  return count > 0 ? EvdevRead{EvdevRead::Status::events, count} : EvdevRead{};
}

bool SimulatedEvdev::has_axis(std::uint16_t code) { return code < 3 && options_.travel_m[code] > 0; }
bool SimulatedEvdev::has_feedback(std::uint16_t code) {
  return code == evdev::kConstant || code == evdev::kGain || code == evdev::kAutocenter ||
         (code == evdev::kSpring && options_.springs);
}

int SimulatedEvdev::axis(std::uint16_t code, EvdevAxis& axis) {
  if (is_gone()) return without_device();
  if (!has_axis(code)) return EINVAL;
  axis = axes_[code];
  return 0;
}

int SimulatedEvdev::set_axis(std::uint16_t code, const EvdevAxis& axis) {
  if (is_gone()) return without_device();
  if (!has_axis(code)) return EINVAL;
  axes_[code] = axis;
  return 0;
}

int SimulatedEvdev::grab() {
  if (is_gone()) return without_device();
  return options_.held ? EBUSY : 0;
}

// ---- effects

int SimulatedEvdev::effect_count(int& count) {
  if (is_gone()) return without_device();
  count = options_.effects;
  return 0;
}

int SimulatedEvdev::access(Owner who, int id) const {
  if (id < 0 || id >= static_cast<int>(slots_.size())) return EINVAL;
  const Owner owner = slots_[static_cast<std::size_t>(id)].owner;
  if (owner == Owner::nobody) return EINVAL;
  return owner == who ? 0 : EACCES;
}

int SimulatedEvdev::upload(EvdevEffect& effect) {
  is_told_ = true;
  if (is_gone()) {
    motors_.ask_away({std::abs(effect.level / 32767.0) * options_.full_scale_N, 0, 0});
    return without_device();
  }
  if ((effect.type != evdev::kConstant && effect.type != evdev::kSpring) || !has_feedback(effect.type)) return EINVAL;
  const bool is_new = effect.id == -1;
  const auto free = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.owner == Owner::nobody; });
  if (is_new && free == slots_.end()) return ENOSPC;
  if (const int refusal = is_new ? 0 : access(Owner::we, effect.id); refusal != 0) return refusal;
  Slot& slot = is_new ? *free : slots_[static_cast<std::size_t>(effect.id)];
  if (!is_new && slot.known.type != effect.type) return EINVAL;
  if (!is_new && slot.known == effect) return 0;
  bool lost = false;
  if (reports_.write_fault(lost) == HidWrite::rejected) return EIO;
  if (is_new) {
    effect.id = static_cast<std::int16_t>(&slot - slots_.data());
    slot = {Owner::we, effect, effect, false, {}};
  }
  slot.known = effect;
  if (lost) return 0;
  slot.loaded = effect;
  motors_.heard(clock_.now());
  render(clock_.now());
  return 0;
}

int SimulatedEvdev::erase_as(Owner who, int id) {
  if (is_gone()) return without_device();
  if (const int refusal = access(who, id); refusal != 0) return refusal;
  slots_[static_cast<std::size_t>(id)] = {};
  motors_.heard(clock_.now());
  render(clock_.now());
  return 0;
}
int SimulatedEvdev::erase(int id) { return erase_as(Owner::we, id); }

int SimulatedEvdev::write(const EvdevEvent& event) {
  is_told_ = true;
  if (is_gone()) return without_device();
  if (event.type != evdev::kFf) return 0;
  bool lost = false;
  if (reports_.write_fault(lost) == HidWrite::rejected || lost) return 0;
  const bool is_setting = event.code == evdev::kGain || event.code == evdev::kAutocenter;
  if (is_setting && (event.value < 0 || event.value > 0xFFFF)) return 0;
  if (event.code == evdev::kGain) gain_ = event.value;
  if (event.code == evdev::kAutocenter) autocenter_ = event.value;
  if (!is_setting) {
    if (event.code >= slots_.size() || slots_[event.code].owner == Owner::nobody) return 0;
    play(slots_[event.code], event.value > 0);
  }
  motors_.heard(clock_.now());
  render(clock_.now());
  return 0;
}

void SimulatedEvdev::play(Slot& slot, bool plays) {
  if (!is_springy())
    next_firmware_tick_ = first_tick_at_or_after(options_.firmware_rate, clock_.now(), options_.reports.first_tick);
  slot.playing = plays;
  slot.ends_at.reset();
  if (plays && slot.loaded.length_ms > 0)
    slot.ends_at = clock_.now() + Duration{std::int64_t{slot.loaded.length_ms} * 1'000'000};
}

// ---- force

bool SimulatedEvdev::is_springy() const {
  return std::any_of(slots_.begin(), slots_.end(),
                     [](const Slot& slot) { return slot.playing && slot.loaded.type == evdev::kSpring; });
}

void SimulatedEvdev::render(RealTime at) {
  const glm::dvec3 force_N = force_at(reports_.position_m(at));
  motors_.render(at, force_N);
  reports_.feel(at, force_N);
}

glm::dvec3 SimulatedEvdev::force_N() {
  if (is_gone()) return glm::dvec3(0);
  return force_at(reports_.position_m(clock_.now()));
}

glm::dvec3 SimulatedEvdev::force_at(const glm::dvec3& position_m) const {
  using internal::sin_of_turn;
  glm::dvec3 share{0};
  for (const Slot& slot : slots_) {
    if (!slot.playing) continue;
    const EvdevEffect& effect = slot.loaded;
    if (effect.type == evdev::kConstant) {
      // Left is a quarter of a turn from down, towards the user: lower X, higher Y.
      const double turns = effect.direction / 65536.0, level = static_cast<double>(effect.level) / 0x7FFF;
      share += glm::dvec3{-sin_of_turn(turns), sin_of_turn(turns + 0.25), 0} * level;
    }
    for (int axis = 0; axis < 2 && effect.type == evdev::kSpring; ++axis)
      share[axis] += spring_share(effect.conditions[static_cast<std::size_t>(axis)], axis, position_m);
  }
  glm::dvec3 force_N{0};
  for (int axis = 0; axis < 2; ++axis) {
    if (options_.travel_m[axis] <= 0) continue;
    const double centering = -position_m[axis] / (options_.travel_m[axis] / 2) * autocenter_ / 0xFFFF;
    force_N[axis] = std::clamp(share[axis] * gain_ / 0xFFFF + centering, -1.0, 1.0) * options_.full_scale_N;
  }
  return force_N;
}

/// Right of the center the right coefficient pulls, up to the right saturation.
double SimulatedEvdev::spring_share(const EvdevCondition& condition, int axis, const glm::dvec3& position_m) const {
  const double half_m = options_.travel_m[axis] / 2;
  if (half_m <= 0) return 0;
  const double off = position_m[axis] / half_m - static_cast<double>(condition.center) / 0x7FFF;
  const double past =
      std::max(0.0, std::abs(off) - condition.dead_band / 65535.0) * internal::full_steepness(options_, axis);
  const double coefficient = off > 0 ? condition.right_coefficient : condition.left_coefficient;
  const double most = (off > 0 ? condition.right_saturation : condition.left_saturation) / 65535.0;
  const double pull = std::clamp(coefficient / 0x7FFF * past, -most, most);
  return off > 0 ? -pull : pull;
}

MotorState SimulatedEvdev::motors() {
  MotorState state;
  state.force_N = force_N();
  if (!reports_.is_gone()) {
    motors_.until(clock_.now());
    for (const Slot& slot : slots_) {
      state.effects_playing += slot.playing;
      state.effects_allocated += slot.owner == Owner::we;
    }
  }
  motors_.tell(state);
  state.effects_ended = effects_ended_;
  state.by_itself = !is_told_;
  return state;
}

}  // namespace evenstep
