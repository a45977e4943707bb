// How PidDriver begins and ends: everything that may take long.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "evenstep/device/hid/pid_axes.h"
#include "evenstep/device/hid/pid_driver.h"
#include "pid_counts.h"
#include "report_exchange.h"

namespace evenstep {
namespace {

using internal::rounded;

/// Clockwise from north. Springs along Y point south: firmware that multiplies a spring by its direction then keeps the
/// sign.
constexpr std::array<double, 2> kForceDirection_deg{90, 0}, kSpringDirection_deg{90, 180};
/// As many as Linux makes: some devices answer wrongly at first.
constexpr int kPoolTries = 20;
constexpr std::int64_t kBelievable = 2;  // least number of effects at once

}  // namespace

void PidDriver::start() {
  assert(!started_);
  if (is_read_only()) return;
  refuse_what_is_missing();
  started_ = true;
  refusals_seen_ = transport_.refused_later();
  refused_since_.reset();
  try {
    start_effects();
  } catch (...) {
    abandon();
    throw;
  }
}

/// What the options ask for and the device cannot do, before anything is sent to it.
void PidDriver::refuse_what_is_missing() const {
  if (options_.effect_duration && !layout_.set_effect.duration) {
    fail(
        "the device's effects do not end by themselves, so a force would stay if this program hung: Set Effect has no "
        "Duration (0x0F0050); if you can switch the device off by hand, write effect_duration = \"none\"");
  }
  for (std::size_t axis = 0; axis < pid::kAxes && options_.springs; ++axis) {
    if (!is_used(axis) || !options_.reversed_spring[axis] || has_spring(axis)) continue;
    fail(fmt::format("the device renders no spring along {0}: {1}; leave {0} out of 'springs', then this program renders it",
                     "XYZ"[axis], lacks_for_spring(axis)));
  }
}

std::string PidDriver::lacks_for_spring(std::size_t axis) const {
  if (!layout_.set_condition) return "it has no Set Condition (0x0F005F) with a Positive Coefficient";
  if (!has_springs()) return "its effect types have no Spring (0x0F0040)";
  const auto& block = layout_.set_condition->parameter_block;
  if (axis > 0 && !block) return "Set Condition has no Parameter Block Offset (0x0F0023)";
  if (axis > 0 && nearest(block->field, static_cast<std::int64_t>(axis)) != static_cast<std::int64_t>(axis))
    return fmt::format("its Parameter Block Offset (0x0F0023) cannot be {}", axis);
  return "it is reversed, and its coefficients cannot be negative";
}

/// Cleans up after a failed start. Only a reset frees a block whose number the device has not told; but a reset enables the
/// actuators, so they are disabled after it.
void PidDriver::abandon() noexcept {
  stop();
  if (!layout_.device_control) return;
  try_command(layout_.device_control->reset);
  try_command(layout_.device_control->disable_actuators);
}

/// Resets twice, as Linux does: some devices lose the first command after they were plugged in.
void PidDriver::start_effects() {
  refreshed_at_.reset();
  if (layout_.device_control) {
    const PidDeviceControl& control = *layout_.device_control;
    command(control.reset, "Device Reset");
    command(control.reset, "Device Reset");
    command(control.stop_all, "Stop All Effects");
    set_gain();
    command(control.enable_actuators, "Enable Actuators");
  } else {
    set_gain();
  }
  choose_duration();
  ask_pool();
  for (const bool is_spring : {false, true}) {
    for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
      if (is_used(axis) && (!is_spring || has_spring(axis))) create(axis, is_spring);
    }
  }
}

bool PidDriver::has_springs() const {
  const bool creatable = numbers_blocks_ || layout_.create_effect->spring;
  return options_.springs && layout_.set_condition && layout_.set_effect.spring && creatable;
}

/// A spring along the second axis is its second block, so it needs a field for the block's number; and a reversed spring is
/// one of negative coefficients.
bool PidDriver::has_spring(std::size_t axis) const {
  if (!has_springs()) return false;
  if (!options_.reversed_spring[axis]) return false;
  const PidSetCondition& layout = *layout_.set_condition;
  if (axis > 0 && (!layout.parameter_block || nearest(layout.parameter_block->field, static_cast<std::int64_t>(axis)) !=
                                                  static_cast<std::int64_t>(axis)))
    return false;
  const auto can_be_negative = [](const PidValue& value) { return value.field.logical_minimum < 0; };
  return !reverses_spring(axis) || (can_be_negative(layout.positive_coefficient) &&
                                    (!layout.negative_coefficient || can_be_negative(*layout.negative_coefficient)));
}

/// Sets the device's own gain to its maximum; effects are given theirs in set_effect().
void PidDriver::set_gain() {
  if (!layout_.device_gain) return;
  const PidDeviceGain& device = *layout_.device_gain;
  const auto report = compose(device.report);
  set_nearest(report, device.gain, device.gain.field.logical_maximum);
  require_sent(report, "Device Gain");
}

void PidDriver::choose_duration() {
  effect_duration_.reset();
  if (!options_.effect_duration || !layout_.set_effect.duration) return;
  const FieldLayout& field = layout_.set_effect.duration->field;
  const double count_s = seconds_per_count(field);
  const auto counts = nearest(field, std::max<std::int64_t>(1, rounded(seconds(*options_.effect_duration) / count_s)));
  if (counts) effect_duration_ = Duration{rounded(static_cast<double>(*counts) * count_s * 1e9)};
}

/// Asks the pool whether the device or the driver numbers the blocks, and how many effects may play. A device that does not
/// answer, or not believably, is driven nevertheless: if it has no room for an effect, it says so at the effect's creation.
void PidDriver::ask_pool() {
  numbers_blocks_ = !layout_.create_effect || !layout_.block_load;
  pid_counters_.pool_unknown = false;
  if (!layout_.pool) return;
  const PidPoolLayout& pool = *layout_.pool;
  std::int64_t needed = 0;
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) needed += is_used(axis) ? 1 + has_spring(axis) : 0;
  std::optional<std::int64_t> simultaneous;
  for (int asked = 0; asked < kPoolTries && simultaneous.value_or(0) < kBelievable; ++asked) {
    const auto report = compose(pool.report);
    const HidFeature got = transport_.get_feature(report);
    if (got.status == HidFeature::Status::gone) internal::throw_gone(transport_);
    if (got.status == HidFeature::Status::rejected) break;
    if (got.status != HidFeature::Status::ok) continue;
    const auto answer = report.first(std::min(got.size, report.size()));
    if (pool.device_managed && get(answer, *pool.device_managed) == 0) numbers_blocks_ = true;
    if (!pool.simultaneous) return;
    simultaneous = get(answer, *pool.simultaneous);
  }
  pid_counters_.pool_unknown = simultaneous.value_or(0) < kBelievable;
  if (simultaneous && !pid_counters_.pool_unknown && *simultaneous < needed) {
    fail(fmt::format("the device plays {} effects at once, {} are needed: use fewer axes or no springs", *simultaneous,
                     needed));
  }
}

void PidDriver::create(std::size_t axis, bool is_spring) {
  const std::uint8_t block = allocate(is_spring);
  effects_.push_back({axis, is_spring, block, {}});
  Effect& effect = effects_.back();
  set_effect(effect);
  const auto first = is_spring ? no_spring(effect) : constant_force(effect, 0);
  require_sent(first, is_spring ? "Set Condition" : "Set Constant Force");
  effect.wanted.assign(first.begin(), first.end());
  effect.is_sent = true;
  require_sent(operation(effect, layout_.operation.start), "Effect Operation");
}

std::uint8_t PidDriver::allocate(bool is_spring) {
  if (numbers_blocks_) return static_cast<std::uint8_t>(effects_.size() + 1);
  const PidCreateEffect& create = *layout_.create_effect;
  const auto report = compose(create.report);
  choose(report, is_spring ? *create.spring : create.constant);
  const HidWrite sent = transport_.set_feature(report);
  if (sent == HidWrite::gone) internal::throw_gone(transport_);
  if (sent == HidWrite::rejected) fail("the device refuses Create New Effect");
  return loaded_block();
}

/// An answer may be shorter than declared, as long as block and status are there. One with the block of another effect is
/// not yet the answer to this request: two effects in a block would move the force of one axis to the other. A device that
/// does not answer at once may first tell the block of an effect of long ago, of a run before this one; so its answer counts
/// once it has been given twice in a row, or if the device gives it no second time.
std::uint8_t PidDriver::loaded_block() {
  const PidBlockLoad& load = *layout_.block_load;
  bool was_taken = false, is_late = false;
  std::uint8_t said = 0, said_last = 0;  // 0: nothing
  for (int asked = 0; asked < options_.block_load_tries; ++asked) {
    const auto report = compose(load.report);
    const HidFeature got = transport_.get_feature(report);
    if (got.status == HidFeature::Status::gone) internal::throw_gone(transport_);
    is_late = is_late || got.status == HidFeature::Status::rejected;
    if (got.status != HidFeature::Status::ok) continue;
    const auto answer = report.first(std::min(got.size, report.size()));
    const auto says = [&](const std::optional<PidChoice>& status) { return status && is_chosen(answer, *status); };
    const auto block = static_cast<std::uint8_t>(get(answer, load.block).value_or(0));
    if (says(load.full))
      throw PidBlockLoadError(
          transport_.info().path + ": the device has no room for another effect: use fewer axes or no springs",
          PidBlockLoadError::Reason::full);
    if (says(load.error))
      throw PidBlockLoadError(transport_.info().path + ": the device reports an error on loading an effect",
                              PidBlockLoadError::Reason::error);
    const bool is_taken =
        std::any_of(effects_.begin(), effects_.end(), [&](const Effect& effect) { return effect.block == block; });
    was_taken = was_taken || is_taken;
    const bool is_own = block != 0 && !is_taken && (!load.success || says(load.success));
    if (is_own && (!is_late || said_last == block)) return block;
    is_late = true;
    said_last = is_own ? block : std::uint8_t{0};
    if (is_own) said = block;
  }
  if (said != 0) return said;
  throw PidBlockLoadError(
      fmt::format("{}: the device did not say in {} tries {} (Block Load, 0x0F0089); its force feedback cannot be used: "
                  "leave out full_scale to read its positions alone",
                  transport_.info().path, options_.block_load_tries,
                  was_taken ? "in which block of its own an effect was loaded" : "whether an effect was loaded"),
      PidBlockLoadError::Reason::no_answer);
}

void PidDriver::set_effect(const Effect& effect) {
  const PidSetEffect& layout = layout_.set_effect;
  const auto report = compose(layout.report);
  set_nearest(report, layout.block, effect.block);
  choose(report, effect.is_spring ? *layout.spring : layout.constant);
  set_duration(report);
  for (const auto* zero : {&layout.trigger_repeat, &layout.sample_period, &layout.start_delay}) {
    if (*zero) set_nearest(report, **zero, 0);
  }
  if (layout.gain) set_nearest(report, *layout.gain, layout.gain->field.logical_maximum);
  address(report, effect);
  require_sent(report, "Set Effect");
}

void PidDriver::set_duration(std::span<std::byte> report) const {
  const auto& duration = layout_.set_effect.duration;
  if (!duration) return;
  if (effect_duration_)
    set_nearest(report, *duration, rounded(seconds(*effect_duration_) / seconds_per_count(duration->field)));
  else if (!set_raw(report, duration->field, duration->index, kPidInfinite) || duration->field.bits < 16)
    set_nearest(report, *duration, duration->field.logical_maximum);
}

bool PidDriver::is_by_direction(std::size_t axis) const {
  return !layout_.set_effect.directions.empty() && axis < kForceDirection_deg.size();
}

/// Addresses a single axis, by its direction if it has one. Axis bits are set raw, whatever their logical range: OpenFFBoard
/// declares 0..0 for the bit of its only axis. They stay 0 where Direction Enable is set, because some firmware takes a
/// direction only if no axis is set. Springs are the exception: unless their axis is named, the same firmware turns their
/// sign with the number of reports that it has got.
void PidDriver::address(std::span<std::byte> report, const Effect& effect) const {
  const PidSetEffect& layout = layout_.set_effect;
  const std::size_t axis = effect.axis;
  const bool by_direction = is_by_direction(axis);
  const auto set_bit = [&](const PidValue& bit) { set_raw(report, bit.field, bit.index, 1); };
  if (!pid_force_axes(layout_)[axis]) {
    fail(
        fmt::format("the device has no force along {0}: neither Axes Enable nor a direction says {0}; give it a travel of 0",
                    "XYZ"[axis]));
  }
  const auto& axis_bit = layout.axis_enable[axis];
  if (axis_bit && (!by_direction || !layout.direction_enable || effect.is_spring)) set_bit(*axis_bit);
  if (!by_direction) return;
  if (layout.direction_enable) set_bit(*layout.direction_enable);
  const PidValue& direction = layout.directions.front();
  const double degrees = (effect.is_spring ? kSpringDirection_deg : kForceDirection_deg)[axis];
  set_nearest(report, direction, internal::share(direction.field, degrees / 360));
}

void PidDriver::stop() noexcept {
  if (!std::exchange(started_, false)) return;
  for (const Effect& effect : effects_) {
    if (layout_.operation.stop) internal::try_to_send(transport_, operation(effect, *layout_.operation.stop));
  }
  if (layout_.device_control) {
    try_command(layout_.device_control->stop_all);
    try_command(layout_.device_control->disable_actuators);
  }
  for (const Effect& effect : effects_) {
    if (!layout_.block_free) break;
    const auto report = compose(layout_.block_free->report);
    set_nearest(report, layout_.block_free->block, effect.block);
    internal::try_to_send(transport_, report);
  }
  effects_.clear();
}

void PidDriver::require_sent(std::span<const std::byte> report, const char* name) {
  const HidWrite sent = internal::send_surely(transport_, report);
  if (sent == HidWrite::gone) internal::throw_gone(transport_);
  if (sent == HidWrite::rejected) fail(fmt::format("the device refuses {}", name));
}

void PidDriver::command(const std::optional<PidChoice>& what, const char* name) {
  if (!what) return;
  const auto report = compose(layout_.device_control->report);
  choose(report, *what);
  require_sent(report, name);
}

void PidDriver::try_command(const std::optional<PidChoice>& what) noexcept {
  if (!what) return;
  const auto report = compose(layout_.device_control->report);
  choose(report, *what);
  internal::try_to_send(transport_, report);
}

}  // namespace evenstep
