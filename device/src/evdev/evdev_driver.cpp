#include "evenstep/device/evdev/evdev_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "../effect_springs.h"
#include "../surely.h"

namespace evenstep {
namespace {

/// A limit, so that a device that makes events faster than they are read cannot hang the tick: 64 reads of 64 events are 64
/// times as many events as the kernel keeps of a device with a few axes.
constexpr int kMaxReadsPerTick = 64;
constexpr std::size_t kEventsPerRead = 64;
/// A call may be interrupted by a signal, or fail because another program is using the device at that moment.
constexpr int kTries = 3;

/// A share of the whole, rounded to counts.
template <class Count>
Count counts(double share, int whole) {
  return static_cast<Count>(std::lround(std::clamp(share, -1.0, 1.0) * whole));
}

template <class Call>
int tried(Call call) {
  int error = 0;
  for (int tries = 0; tries < kTries; ++tries) {
    if ((error = call()) == 0 || error == ENODEV || error == ENOSPC) return error;
  }
  return error;
}

}  // namespace

EvdevDriver::EvdevDriver(EvdevNode& node, const EvdevOptions& options) : node_(node), options_(options) {
  check_options();
  if (const int error = node_.grab(); error == EBUSY) {
    fail("another program has the device for itself (EVIOCGRAB); end it, or use the device's hidraw node");
  } else if (error != 0) {
    fail(fmt::format("it cannot be taken for evenstep alone: {}", std::strerror(error)));
  }
  has_gain_ = node_.has_feedback(evdev::kGain);
  has_autocenter_ = node_.has_feedback(evdev::kAutocenter);
  if (options_.unchanged_age && node_.tells_times()) times_.emplace(*options_.unchanged_age);
  evdev_counters_.untimed = options_.unchanged_age && !times_;
  later_.reserve(kEventsPerRead);
  adopt_axes();
}

EvdevDriver::~EvdevDriver() {
  stop();
  restore_axes();
}

void EvdevDriver::check_options() const {
  if (!(options_.gain > 0 && options_.gain <= 1))
    fail(fmt::format("gain is {}; it must be above 0 and at most 1", options_.gain));
  if (options_.full_scale_N && !(*options_.full_scale_N > 0 && std::isfinite(*options_.full_scale_N)))
    fail(fmt::format("full_scale_N is {}; it must be above 0", *options_.full_scale_N));
  const std::int64_t effect_ms = options_.effect_duration.ns / 1'000'000;
  if (effect_ms < 2 || effect_ms > evdev::kLongestEffect_ms) fail("effect_duration must be from 2 ms to 32.767 s");
  if (options_.unchanged_age && options_.unchanged_age->ns <= 0) fail("unchanged_age must be above 0");
  if (options_.update_rate.num <= 0 || options_.update_rate.den <= 0) fail("update_rate must be above 0");
  bool any = false;
  for (int axis = 0; axis < 3; ++axis) {
    const double travel_m = options_.travel_m[axis];
    if (!(travel_m >= 0 && std::isfinite(travel_m))) fail(fmt::format("travel_m of axis {} is {}", "XYZ"[axis], travel_m));
    any = any || is_used(axis);
    if (is_used(axis) && !node_.has_axis(static_cast<std::uint16_t>(axis)))
      fail(fmt::format("axis {} has a travel, but the device has no such axis; give it a travel of 0", "XYZ"[axis]));
  }
  if (!any) fail("no axis has a travel: give travel_m for at least one of X, Y, Z");
  if (is_read_only()) return;
  if (!node_.has_feedback(evdev::kConstant)) fail("the kernel's driver for it plays no constant forces (FF_CONSTANT)");
  if (options_.springs && !node_.has_feedback(evdev::kSpring))
    fail("the kernel's driver for it plays no springs (FF_SPRING)");
}

// ---- positions

/// The kernel smooths a joystick's changes smaller than a 128th of its range; this tells it not to.
void EvdevDriver::adopt_axes() {
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_used(axis)) continue;
    const auto code = static_cast<std::uint16_t>(axis);
    EvdevAxis& found = axes_[code];
    if (const int error = node_.axis(code, found); error != 0) fail(std::strerror(error));
    if (found.minimum >= found.maximum)
      fail(fmt::format("axis {} says that it goes from {} to {}", "XYZ"[axis], found.minimum, found.maximum));
    EvdevAxis exact = found;
    exact.fuzz = 0;
    if (found.fuzz != 0 && node_.set_axis(code, exact) != 0)
      fail(fmt::format("the kernel smooths axis {} and cannot be told not to", "XYZ"[axis]));
  }
  if (!ask_positions()) fail("it does not say where its axes are");
}

void EvdevDriver::restore_axes() noexcept {
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    EvdevAxis now;
    if (!is_used(axis) || axes_[axis].fuzz == 0 || node_.axis(axis, now) != 0) continue;
    now.fuzz = axes_[axis].fuzz;
    node_.set_axis(axis, now);
  }
}

/// False: the device cannot say now.
bool EvdevDriver::ask_positions() {
  std::array<EvdevAxis, 3> now;
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    const int error = is_used(axis) ? node_.axis(axis, now[axis]) : 0;
    if (error == ENODEV) fail_gone();
    if (error != 0) return false;
  }
  last_.at_range = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (is_used(axis)) place(axis, now[static_cast<std::size_t>(axis)].value);
  }
  return true;
}

/// A value outside the range counts as its nearest end.
void EvdevDriver::place(int axis, std::int32_t value) {
  const EvdevAxis& range = axes_[static_cast<std::size_t>(axis)];
  raw_[static_cast<std::size_t>(axis)] = value;
  const std::int64_t within = std::clamp(value, range.minimum, range.maximum);
  const double share =
      static_cast<double>(within - range.minimum) / static_cast<double>(std::int64_t{range.maximum} - range.minimum);
  last_.position_m[axis] = (share - 0.5) * options_.travel_m[axis];
  last_.at_range = last_.at_range || within == range.minimum || within == range.maximum;
}

void EvdevDriver::take(const EvdevEvent& event) {
  if (event.type == evdev::kAbs && event.code < 3 && is_used(event.code) && !is_lost_) {
    raw_[event.code] = event.value;
    positions_changed_ = true;
  }
  if (event.type != evdev::kSyn) return;
  if (event.code == evdev::kSynDropped) {
    is_lost_ = true;
    ++evdev_counters_.dropped;
  }
  if (event.code != evdev::kSynReport || !(is_lost_ || positions_changed_)) return;
  if (is_lost_ && !ask_positions()) {  // the kernel's own table has what was lost, and nothing since is newer
    is_asking_ = true;
    return;
  }
  if (!is_lost_) {
    last_.at_range = false;
    for (int axis = 0; axis < 3; ++axis) {
      if (is_used(axis)) place(axis, raw_[static_cast<std::size_t>(axis)]);
    }
  }
  newest_event_ = event.at;
  note_report();
}

void EvdevDriver::note_report() {
  is_lost_ = is_asking_ = positions_changed_ = false;
  ++counters_.reports;
  ++last_.sequence;
  last_.fresh = true;
}

/// Takes events up to the tick's time. The first later one and all that follow are kept for the next tick, which takes them
/// whatever their times. False: there was a later one.
bool EvdevDriver::take_until(RealTime now, std::span<const EvdevEvent> events) {
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (times_ && events[i].at > now) {
      later_.assign(events.begin() + static_cast<std::ptrdiff_t>(i), events.end());
      return false;
    }
    take(events[i]);
  }
  return true;
}

/// A change between the last read and the question is told twice, by the table and by its event, which does no harm.
void EvdevDriver::forget_queued() {
  std::array<EvdevEvent, kEventsPerRead> events;
  for (int reads = 0; reads < kMaxReadsPerTick; ++reads) {
    const EvdevRead got = node_.read(events);
    if (got.status == EvdevRead::Status::gone) fail_gone();
    if (got.status == EvdevRead::Status::away || got.status == EvdevRead::Status::returned) return come_back();
    if (got.status == EvdevRead::Status::nothing) break;
  }
  is_lost_ = is_asking_ = !ask_positions();
  positions_changed_ = false;
}

DeviceSample EvdevDriver::read(RealTime now) {
  last_.read_at = now;
  last_.fresh = false;
  last_.drivable = true;
  last_.away = is_away_;
  newest_event_.reset();
  for (const EvdevEvent& event : later_) take(event);
  later_.clear();
  std::array<EvdevEvent, kEventsPerRead> events;
  for (int reads = 0; reads < kMaxReadsPerTick; ++reads) {
    const EvdevRead got = node_.read(events);
    if (got.status == EvdevRead::Status::gone) fail_gone();
    if (got.status == EvdevRead::Status::away) is_away_ = true;
    if (got.status == EvdevRead::Status::returned) come_back();
    if (is_away_ || got.status == EvdevRead::Status::nothing) break;
    if (!take_until(now, std::span(events).first(std::min(got.count, events.size())))) break;
  }
  if (is_asking_ && !is_away_ && ask_positions()) note_report();
  if (last_.fresh) last_event_ = now;
  if (is_away_) last_.away = true;
  if (last_.away) last_.drivable = false;
  if (!last_.fresh) {
    ++counters_.stale;
    if (!last_event_ && is_position_known()) last_event_ = now;
    last_.fresh = !is_away_ && last_event_ && now - *last_event_ <= options_.still;
  }
  if (times_) date(now);
  notice_uploads();
  notice_refusals(now);
  return last_;
}

/// A position that was asked for later has no event of its own: it is as old as a position that nothing has changed. Until
/// it has come, the hand's present position is unknown.
void EvdevDriver::date(RealTime now) {
  if (last_.fresh && newest_event_)
    times_->changed(*newest_event_, now);
  else if (last_.fresh)
    last_.fresh = !is_lost_ && times_->unchanged(now);
  last_.taken_at = times_->taken(now);
}

/// The forces rise from zero again, because this tick still says that the device is away. Where the hand is may be unknown,
/// as at the start (is_position_known).
void EvdevDriver::come_back() {
  is_away_ = false;
  last_.away = true;
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    EvdevAxis found;
    if (!is_used(axis) || node_.axis(axis, found) != ENXIO) continue;
    is_away_ = true;  // again: the next read says so
    return;
  }
  adopt_axes();
  is_lost_ = is_asking_ = positions_changed_ = last_.fresh = false;
  newest_event_.reset();
  last_event_.reset();
  next_send_ = {};
  next_effect_ = 0;
  for (Effect& effect : effects_) {
    effect.is_sent = effect.is_played = false;
    effect.refused_since.reset();
  }
  refreshed_at_.reset();
}

/// Before an axis's first event the kernel reports 0 for it. That counts as a position only if 0 is not an end of the range.
bool EvdevDriver::is_position_known() const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_end = axes_[axis].minimum == 0 || axes_[axis].maximum == 0;
    if (is_used(static_cast<int>(axis)) && raw_[axis] == 0 && is_end) return false;
  }
  return true;
}

// ---- start and stop

void EvdevDriver::start() {
  assert(!started_);
  if (is_read_only()) return;
  started_ = true;
  try {
    set_device();
    for (const bool is_spring : {false, true}) {
      for (int axis = 0; axis < 2; ++axis) {
        if (is_used(axis) && (!is_spring || has_spring(axis))) create(axis, is_spring);
      }
    }
    if (effects_.empty()) fail("it has forces along X and Y only, and neither has a travel");
  } catch (...) {
    stop();
    throw;
  }
}

/// Sets full gain, because some drivers ignore the gain: the share of the full scale is in the levels instead. Switches
/// autocentering off, because a device that centers by itself would push unasked.
void EvdevDriver::set_device() {
  if (has_gain_ && node_.write({evdev::kFf, evdev::kGain, evdev::kFullGain}) == ENODEV) fail_gone();
  if (has_autocenter_ && node_.write({evdev::kFf, evdev::kAutocenter, 0}) == ENODEV) fail_gone();
}

bool EvdevDriver::has_spring(int axis) const {
  return options_.springs && options_.reversed_spring[static_cast<std::size_t>(axis)].has_value();
}

/// A spring along Y points up, as PidDriver's: firmware that multiplies a spring by its direction then keeps its sign, and a
/// sign that was measured in one way holds in the other. Most drivers of the kernel's ignore it.
void EvdevDriver::create(int axis, bool is_spring) {
  EvdevEffect effect;
  effect.type = is_spring ? evdev::kSpring : evdev::kConstant;
  effect.direction = axis == 0 ? evdev::kLeft : is_spring ? evdev::kUp : evdev::kDown;
  effect.length_ms = static_cast<std::uint16_t>(options_.effect_duration.ns / 1'000'000);
  const int error = tried([&] { return node_.upload(effect); });
  if (error == ENODEV) fail_gone();
  if (error == ENOSPC) {
    int room = 0;
    node_.effect_count(room);
    fail(
        fmt::format("no room for effect {}: the device has room for {}, of all programs together; end the other programs, "
                    "or use fewer axes or no springs",
                    effects_.size() + 1, room));
  }
  if (error != 0) fail(fmt::format("it refuses {}: {}", is_spring ? "a spring" : "a constant force", std::strerror(error)));
  effects_.push_back({axis, effect, true, false, {}});
}

void EvdevDriver::stop() noexcept {
  for (const Effect& effect : effects_) {
    internal::surely([&] {
      tried([&] { return node_.write({evdev::kFf, static_cast<std::uint16_t>(effect.wanted.id), 0}); });
    });
    internal::surely([&] { tried([&] { return node_.erase(effect.wanted.id); }); });
  }
  effects_.clear();
  started_ = false;
  refreshed_at_.reset();
}

// ---- forces

void EvdevDriver::require_writable() const {
  if (is_read_only())
    fail("a force cannot be written: evdev knows no newtons; give full_scale_N, the force of the largest level");
  if (!started_) fail("a force cannot be written before start() or after stop()");
}

void EvdevDriver::write(const glm::dvec3& force_N) {
  require_writable();
  assert(std::isfinite(force_N.x) && std::isfinite(force_N.y) && std::isfinite(force_N.z));
  const double largest_N = largest_force_N();
  bool saturated = false;
  for (Effect& effect : effects_) {
    if (effect.wanted.type != evdev::kConstant) continue;
    const double along_N = force_N[effect.axis];
    saturated = saturated || std::abs(along_N) > largest_N;
    const bool is_negative = (effect.axis == 0) != options_.reversed_force[static_cast<std::size_t>(effect.axis)];
    const double level = std::clamp(along_N, -largest_N, largest_N) / *options_.full_scale_N;
    EvdevEffect newest = effect.wanted;
    newest.level = counts<std::int16_t>(is_negative ? -level : level, evdev::kLargestLevel);
    want(effect, newest);
  }
  if (saturated) ++evdev_counters_.saturated;
  send_wanted();
}

/// The condition of one axis; in `rendered`, the same in newtons and metres.
EvdevCondition EvdevDriver::condition_of(const DeviceSpring& wanted, int axis, DeviceSpring& rendered) const {
  EvdevCondition condition;
  const double half_m = options_.travel_m[axis] / 2, full_N = *options_.full_scale_N,
               slope = internal::full_slope_N_per_m(options_, axis);
  if (std::abs(wanted.center_m[axis]) > half_m) return condition;
  const auto coefficient = [&](double stiffness) {
    return counts<std::int16_t>(std::min(stiffness / slope, options_.gain), evdev::kLargestLevel);
  };
  const double limit_N = std::min(wanted.limit_N[axis], largest_force_N());
  condition.center = counts<std::int16_t>(wanted.center_m[axis] / half_m, evdev::kLargestLevel);
  condition.right_coefficient = coefficient(wanted.above_N_per_m[axis]);
  condition.left_coefficient = coefficient(wanted.below_N_per_m[axis]);
  condition.right_saturation = condition.left_saturation =
      counts<std::uint16_t>(limit_N / full_N, evdev::kLargestSaturation);
  rendered.center_m[axis] = condition.center * half_m / evdev::kLargestLevel;
  rendered.above_N_per_m[axis] = condition.right_coefficient * slope / evdev::kLargestLevel;
  rendered.below_N_per_m[axis] = condition.left_coefficient * slope / evdev::kLargestLevel;
  rendered.limit_N[axis] = condition.right_saturation * full_N / evdev::kLargestSaturation;
  if (options_.reversed_spring[static_cast<std::size_t>(axis)].value_or(false)) {
    condition.right_coefficient = static_cast<std::int16_t>(-condition.right_coefficient);
    condition.left_coefficient = static_cast<std::int16_t>(-condition.left_coefficient);
  }
  return condition;
}

DeviceSpring EvdevDriver::write_spring(const DeviceSpring& wanted) {
  require_writable();
  DeviceSpring rendered;
  for (Effect& effect : effects_) {
    if (effect.wanted.type != evdev::kSpring) continue;
    EvdevEffect newest = effect.wanted;
    newest.conditions[static_cast<std::size_t>(effect.axis)] = condition_of(wanted, effect.axis, rendered);
    want(effect, newest);
  }
  send_wanted();
  return rendered;
}

// ---- sending

/// The kernel's driver sends nothing to the device if an effect is uploaded unchanged. So that a refresh makes up for a lost
/// report, every second one changes a value by one count: a level by 1 / 32767, a dead band by 1 / 65535.
void EvdevDriver::want(Effect& effect, EvdevEffect newest) {
  const bool is_odd = evdev_counters_.refreshes % 2 == 1;
  if (newest.type == evdev::kConstant)
    newest.level = static_cast<std::int16_t>(newest.level + (!is_odd ? 0 : newest.level > 0 ? -1 : 1));
  else
    newest.conditions[static_cast<std::size_t>(effect.axis)].dead_band = is_odd;
  if (newest == effect.wanted) return;
  effect.wanted = newest;
  effect.is_sent = false;
}

void EvdevDriver::send_wanted() {
  if (is_away_) return;
  const RealTime now = last_.read_at;
  if (!refreshed_at_ || now - *refreshed_at_ >= Duration{options_.effect_duration.ns / 2}) {
    refreshed_at_ = now;
    ++evdev_counters_.refreshes;
    set_device();
    for (Effect& effect : effects_) effect.is_played = false;
  }
  const Duration period = period_ceil(options_.update_rate);
  while (now >= next_send_ && send_one()) next_send_ = std::max(next_send_, now - period) + period;
  const auto is_done = [](const Effect& effect) { return effect.is_sent && effect.is_played; };
  if (!std::all_of(effects_.begin(), effects_.end(), is_done)) ++evdev_counters_.waited;
}

/// Whether there was something to send. An effect's play comes before its force, which may change in every tick and then
/// leave no room for the play.
bool EvdevDriver::send_one() {
  for (std::size_t i = 0; i < effects_.size(); ++i) {
    Effect& effect = effects_[(next_effect_ + i) % effects_.size()];
    if (effect.is_played && effect.is_sent) continue;
    next_effect_ = (next_effect_ + i + 1) % effects_.size();
    if (!effect.is_played)
      effect.is_played = is_taken(node_.write({evdev::kFf, static_cast<std::uint16_t>(effect.wanted.id), 1}));
    else if (!(effect.is_sent = is_taken(node_.upload(effect.wanted))) && !effect.refused_since)
      effect.refused_since = last_.read_at;
    return true;
  }
  return false;
}

bool EvdevDriver::is_taken(int error) {
  if (error == ENODEV) fail_gone();
  if (error != 0) ++counters_.write_failures;
  return error == 0;
}

void EvdevDriver::notice_uploads() {
  for (Effect& effect : effects_) {
    if (!effect.is_sent || is_away_) continue;
    const EvdevNode::Upload uploaded = node_.uploaded(effect.wanted.id);
    if (uploaded == EvdevNode::Upload::taken) effect.refused_since.reset();
    if (uploaded != EvdevNode::Upload::refused) continue;
    ++counters_.write_failures;
    effect.is_sent = false;
    if (!effect.refused_since) effect.refused_since = last_.read_at;
  }
}

void EvdevDriver::notice_refusals(RealTime now) const {
  for (const Effect& effect : effects_) {
    if (!effect.refused_since || now - *effect.refused_since < options_.effect_duration) continue;
    fail(fmt::format("the device has refused an effect for {:.0f} ms; if it still pushes, switch it off",
                     seconds(options_.effect_duration) * 1e3));
  }
}

std::map<std::string, std::int64_t> EvdevDriver::own_counters() const {
  return {{"evdev_refreshes", evdev_counters_.refreshes},
          {"evdev_saturated", evdev_counters_.saturated},
          {"evdev_dropped", evdev_counters_.dropped},
          {"evdev_waited", evdev_counters_.waited},
          {"evdev_untimed", evdev_counters_.untimed}};
}

void EvdevDriver::fail(const std::string& what) const { throw DeviceError(node_.info().path + ": " + what); }
void EvdevDriver::fail_gone() const {
  fail("device '" + node_.info().name + "' is gone (unplugged or reset); plug it in and run again");
}

double steepest_spring_N_per_m(const EvdevOptions& options) { return internal::steepest_spring_N_per_m(options, 2); }

}  // namespace evenstep
