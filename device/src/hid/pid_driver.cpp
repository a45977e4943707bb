#include "evenstep/device/hid/pid_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "report_exchange.h"

namespace evenstep {
namespace {

std::int64_t rounded(double value) { return static_cast<std::int64_t>(std::round(std::clamp(value, -1e15, 1e15))); }

/// The value at the given fraction of a field's range.
std::int64_t share(const FieldLayout& field, double fraction) {
  return field.logical_minimum + rounded(fraction * static_cast<double>(field.logical_maximum - field.logical_minimum));
}
double fraction_of(const FieldLayout& field, std::int64_t value) {
  const auto range = static_cast<double>(field.logical_maximum - field.logical_minimum);
  return range > 0 ? static_cast<double>(value - field.logical_minimum) / range : 1;
}

/// The distance from the middle of the range, as a share of half the range.
double deflection(const FieldLayout& field, std::int64_t value) { return 2 * fraction_of(field, value) - 1; }

/// Waiting reports can only replace one another if their second byte is the effect block.
bool names_block_second(const PidValue& block) {
  return block.field.bit_offset == 0 && block.field.bits == 8 && block.index == 0;
}

/// The direction of a force along X or Y, in degrees from north, clockwise.
constexpr std::array<double, 2> kDirection_deg{90, 0};

}  // namespace

/// The counts of Set Condition; all 0 means no spring.
struct PidDriver::Condition {
  std::int64_t center = 0, below = 0, above = 0, saturation = 0;
};

PidDriver::PidDriver(HidTransport& transport, PidLayout layout, const PidOptions& options)
    : transport_(transport), layout_(std::move(layout)), options_(options) {
  check_options();
  std::size_t longest = 1;
  for (const PidReport& input : layout_.inputs) longest = std::max(longest, input.size);
  input_.resize(longest);
}

PidDriver::~PidDriver() { stop(); }

void PidDriver::check_options() const {
  if (!(options_.gain > 0 && options_.gain <= 1))
    fail(fmt::format("gain is {}; it must be above 0 and at most 1", options_.gain));
  if (options_.full_scale_N && !(*options_.full_scale_N > 0 && std::isfinite(*options_.full_scale_N))) {
    fail(fmt::format("full_scale_N is {}; it must be above 0", *options_.full_scale_N));
  }
  if (options_.effect_duration && options_.effect_duration->ns <= 0) fail("effect_duration must be above 0");
  bool any = false;
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
    const double travel_m = options_.travel_m[static_cast<int>(axis)];
    if (!(travel_m >= 0 && std::isfinite(travel_m))) fail(fmt::format("travel_m of axis {} is {}", "XYZ"[axis], travel_m));
    if (!is_used(axis)) continue;
    any = true;
    if (!layout_.position[axis])
      fail(fmt::format("axis {} has a travel, but no input report has it; give it a travel of 0", "XYZ"[axis]));
  }
  if (!any) fail("no axis has a travel: give travel_m for at least one of X, Y, Z");
}

// ---- start and stop

void PidDriver::start() {
  assert(!started_);
  if (is_read_only()) return;
  started_ = true;
  try {
    start_effects();
  } catch (...) {
    abandon();
    throw;
  }
}

/// Cleans up after a failed start. A block whose number the device has not told can only be freed by a reset, which enables
/// the actuators.
void PidDriver::abandon() noexcept {
  stop();
  if (!layout_.device_control) return;
  try_command(layout_.device_control->reset);
  try_command(layout_.device_control->disable_actuators);
}

void PidDriver::start_effects() {
  refreshed_at_.reset();
  if (layout_.device_control) {
    command(layout_.device_control->reset, "Device Reset");
    set_gain();
    command(layout_.device_control->enable_actuators, "Enable Actuators");
  } else {
    set_gain();
  }
  choose_duration();
  ask_pool();
  for (const bool is_spring : {false, true}) {
    for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
      if (is_used(axis) && (!is_spring || has_springs())) create(axis, is_spring);
    }
  }
}

bool PidDriver::has_springs() const {
  const bool creatable = numbers_blocks_ || layout_.create_effect->spring;
  return options_.springs && layout_.set_condition && layout_.set_effect.spring && creatable;
}

/// Sets the device's own gain if it has one, otherwise that of its effects; without either, the driver limits the force
/// itself.
void PidDriver::set_gain() {
  std::optional<double> applied;
  const auto counted = [&](const FieldLayout& field) {
    // Rounded down, so that it is not more than was asked for, but not to 0; the 1e-9 corrects the rounding of 0.6 * 255.
    const auto range = static_cast<double>(field.logical_maximum - field.logical_minimum);
    const std::int64_t whole = static_cast<std::int64_t>(options_.gain * range + 1e-9);
    const std::int64_t counts =
        nearest(field, field.logical_minimum + std::max<std::int64_t>(1, whole)).value_or(field.logical_maximum);
    applied = fraction_of(field, counts);
    return counts;
  };
  if (layout_.set_effect.gain) effect_gain_ = layout_.set_effect.gain->field.logical_maximum;
  if (layout_.device_gain) {
    const PidDeviceGain& device = *layout_.device_gain;
    const auto report = compose(device.report);
    set_nearest(report, device.gain, counted(device.gain.field));
    require_sent(report, "Device Gain");
  } else if (layout_.set_effect.gain) {
    effect_gain_ = counted(layout_.set_effect.gain->field);
  }
  device_force_N_ = *options_.full_scale_N * applied.value_or(1);
  largest_force_N_ = *options_.full_scale_N * applied.value_or(options_.gain);
}

void PidDriver::choose_duration() {
  effect_duration_.reset();
  if (!options_.effect_duration || !layout_.set_effect.duration) return;
  const FieldLayout& field = layout_.set_effect.duration->field;
  const double count_s = seconds_per_count(field);
  const auto counts = nearest(field, std::max<std::int64_t>(1, rounded(seconds(*options_.effect_duration) / count_s)));
  if (counts) effect_duration_ = Duration{rounded(static_cast<double>(*counts) * count_s * 1e9)};
}

/// Asks the pool who numbers the blocks, and how many effects may play.
void PidDriver::ask_pool() {
  numbers_blocks_ = !layout_.create_effect || !layout_.block_load;
  if (!layout_.pool) return;
  const auto report = compose(layout_.pool->report);
  const HidFeature got = transport_.get_feature(report);
  if (got.status == HidFeature::Status::gone) internal::throw_gone(transport_);
  if (got.status != HidFeature::Status::ok || got.size < report.size()) return;
  if (layout_.pool->device_managed && get(report, *layout_.pool->device_managed) == 0) numbers_blocks_ = true;
  std::int64_t needed = 0;
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) needed += is_used(axis) ? 1 + has_springs() : 0;
  if (!layout_.pool->simultaneous) return;
  const std::int64_t simultaneous = get(report, *layout_.pool->simultaneous).value_or(needed);
  if (simultaneous < needed)
    fail(fmt::format("the device plays {} effects at once, {} are needed: use fewer axes or no springs", simultaneous,
                     needed));
}

void PidDriver::create(std::size_t axis, bool is_spring) {
  effects_.push_back({axis, is_spring, allocate(is_spring), {}});
  Effect& effect = effects_.back();
  set_effect(effect);
  const auto first = is_spring ? condition(effect, Condition{}) : constant_force(effect, 0);
  require_sent(first, is_spring ? "Set Condition" : "Set Constant Force");
  effect.sent.assign(first.begin(), first.end());
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

std::uint8_t PidDriver::loaded_block() {
  const PidBlockLoad& load = *layout_.block_load;
  const auto says = [&](std::span<const std::byte> report, const std::optional<PidChoice>& status) {
    return status && is_chosen(report, *status);
  };
  for (int asked = 0; asked < options_.block_load_tries; ++asked) {
    const auto report = compose(load.report);
    const HidFeature got = transport_.get_feature(report);
    if (got.status == HidFeature::Status::gone) internal::throw_gone(transport_);
    if (got.status != HidFeature::Status::ok || got.size < report.size()) continue;
    const auto block = static_cast<std::uint8_t>(get(report, load.block).value_or(0));
    if (says(report, load.full))
      throw PidBlockLoadError(transport_.info().path + ": the device has no room for another effect",
                              PidBlockLoadError::Reason::full);
    if (says(report, load.error))
      throw PidBlockLoadError(transport_.info().path + ": the device reports an error on loading an effect",
                              PidBlockLoadError::Reason::error);
    if (block != 0 && (!load.success || says(report, load.success))) return block;
  }
  throw PidBlockLoadError(fmt::format("{}: the device did not say in {} tries whether an effect was loaded",
                                      transport_.info().path, options_.block_load_tries),
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
  if (layout.gain) set_nearest(report, *layout.gain, effect_gain_);
  address(report, effect.axis);
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

/// Addresses a single axis: by its bit, and by its direction if it can be given as a direction.
void PidDriver::address(std::span<std::byte> report, std::size_t axis) const {
  const PidSetEffect& layout = layout_.set_effect;
  const bool by_direction = !layout.directions.empty() && axis < kDirection_deg.size();
  if (!layout.axis_enable[axis] && !by_direction && axis > 0) {
    fail(fmt::format("axis {} of an effect can be said neither by Axes Enable nor by Direction: give it a travel of 0",
                     "XYZ"[axis]));
  }
  if (layout.axis_enable[axis]) set_nearest(report, *layout.axis_enable[axis], 1);
  if (!by_direction) return;
  if (layout.direction_enable) set_nearest(report, *layout.direction_enable, 1);
  const PidValue& direction = layout.directions.front();
  set_nearest(report, direction, share(direction.field, kDirection_deg[axis] / 360));
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

// ---- a tick

DeviceSample PidDriver::read(RealTime now) {
  last_.read_at = now;
  last_.fresh = false;
  internal::drain(
      transport_, input_, [&](std::span<const std::byte> report) { take(report); }, [&] { has_returned_ = true; });
  if (!last_.fresh) ++counters_.stale;
  last_.drivable = !is_silent();
  return last_;
}

/// On a device without report ids the first byte is not an id; such a device has only one input report.
void PidDriver::take(std::span<const std::byte> bytes) {
  const bool numbered =
      std::any_of(layout_.inputs.begin(), layout_.inputs.end(), [](const PidReport& input) { return input.id != 0; });
  const auto id = numbered && !bytes.empty() ? std::to_integer<std::uint8_t>(bytes[0]) : std::uint8_t{0};
  const auto known =
      std::find_if(layout_.inputs.begin(), layout_.inputs.end(), [&](const PidReport& input) { return input.id == id; });
  if (known == layout_.inputs.end() || bytes.size() < known->size) {
    ++counters_.malformed;
    return;
  }
  if (layout_.state && layout_.state->report.id == id) take_state(bytes);
  take_positions(id, bytes);
}

void PidDriver::take_positions(std::uint8_t id, std::span<const std::byte> bytes) {
  bool positions = false;
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) {
    const auto& position = layout_.position[axis];
    if (!is_used(axis) || position->report.id != id) continue;
    positions = true;
    const FieldLayout& field = position->value.field;
    const std::int64_t value = *get(bytes, position->value);
    // A value outside the range means "no value" if the field allows that, and otherwise the nearest end of the range.
    const std::int64_t within = std::clamp(value, field.logical_minimum, field.logical_maximum);
    if (value != within && field.has_null()) continue;
    last_.position_m[static_cast<int>(axis)] = deflection(field, within) * options_.travel_m[static_cast<int>(axis)] / 2;
  }
  if (!positions) return;
  last_.at_range = false;
  for (int axis = 0; axis < 3; ++axis) {
    const double most_m = options_.travel_m[axis] / 2;
    last_.at_range |= most_m > 0 && std::abs(last_.position_m[axis]) >= most_m;
  }
  ++counters_.reports;
  ++last_.sequence;
  last_.fresh = true;
}

void PidDriver::take_state(std::span<const std::byte> bytes) {
  ++pid_counters_.state_reports;
  const PidStateLayout& layout = *layout_.state;
  const auto flag = [&](const std::optional<PidValue>& value) {
    return value ? std::optional(get(bytes, *value) != 0) : std::nullopt;
  };
  state_ = {.paused = flag(layout.paused),
            .actuators_enabled = flag(layout.actuators_enabled),
            .safety_switch = flag(layout.safety_switch),
            .override_switch = flag(layout.override_switch),
            .actuator_power = flag(layout.actuator_power),
            .effect_playing = flag(layout.effect_playing)};
}

void PidDriver::require_writable() const {
  if (is_read_only())
    fail("a force cannot be written: PID devices have no newtons; give full_scale_N, the force of the largest magnitude");
  if (!started_) fail("a force cannot be written before start() or after stop()");
}

bool PidDriver::is_silent() const {
  return has_returned_ || state_.paused == true || state_.actuators_enabled == false || state_.safety_switch == false ||
         state_.actuator_power == false;
}

std::map<std::string, std::int64_t> PidDriver::own_counters() const {
  return {{"pid_refreshes", pid_counters_.refreshes},
          {"pid_saturated", pid_counters_.saturated},
          {"pid_unpowered", pid_counters_.unpowered}};
}

void PidDriver::write(const glm::dvec3& force_N) {
  require_writable();
  assert(std::isfinite(force_N.x) && std::isfinite(force_N.y) && std::isfinite(force_N.z));
  if (is_silent()) ++pid_counters_.unpowered;
  bool saturated = false;
  for (Effect& effect : effects_) {
    if (effect.is_spring) continue;
    const double along_N = force_N[static_cast<int>(effect.axis)];
    saturated = saturated || std::abs(along_N) > largest_force_N_;
    update(effect, constant_force(effect, along_N), layout_.set_constant.block);
  }
  if (saturated) ++pid_counters_.saturated;
  refresh();
}

std::span<std::byte> PidDriver::constant_force(const Effect& effect, double force_N) {
  const auto report = compose(layout_.set_constant.report);
  const PidValue& magnitude = layout_.set_constant.magnitude;
  const double wanted_N =
      std::clamp(force_N, -largest_force_N_, largest_force_N_) * (options_.reversed_force[effect.axis] ? -1 : 1);
  const auto most = static_cast<double>(std::min(magnitude.field.logical_maximum, -magnitude.field.logical_minimum));
  set_nearest(report, layout_.set_constant.block, effect.block);
  set_nearest(report, magnitude, rounded(wanted_N / device_force_N_ * most));
  return report;
}

void PidDriver::update(Effect& effect, std::span<const std::byte> report, const PidValue& block) {
  if (std::equal(report.begin(), report.end(), effect.sent.begin(), effect.sent.end())) return;
  if (send_in_tick(report, block)) std::copy(report.begin(), report.end(), effect.sent.begin());
}

/// The force of an effect is sent together with its Start, in case it was lost before. A refused refresh is tried again in
/// the next tick.
void PidDriver::refresh() {
  if (!effect_duration_ || (refreshed_at_ && (last_.read_at - *refreshed_at_).ns < effect_duration_->ns / 2)) return;
  bool all = true;
  for (const Effect& effect : effects_) {
    all = send_in_tick(effect.sent, effect.is_spring ? layout_.set_condition->block : layout_.set_constant.block) && all;
    all = send_in_tick(operation(effect, layout_.operation.start), layout_.operation.block) && all;
  }
  if (!all) return;
  refreshed_at_ = last_.read_at;
  ++pid_counters_.refreshes;
}

// ---- springs

double PidDriver::largest_slope_N_per_m(int axis) const {
  const double full_scale_N = *options_.full_scale_N;
  const double full =
      options_.full_slope_N_per_m ? (*options_.full_slope_N_per_m)[axis] : full_scale_N / (options_.travel_m[axis] / 2);
  return full * (device_force_N_ / full_scale_N);
}

std::optional<PidDriver::Condition> PidDriver::counts_of(const DeviceSpring& wanted, int axis) const {
  const PidSetCondition& layout = *layout_.set_condition;
  const double half_travel_m = options_.travel_m[axis] / 2;
  const double below = wanted.below_N_per_m[axis], above = wanted.above_N_per_m[axis], slope = largest_slope_N_per_m(axis);
  if (std::abs(wanted.center_m[axis]) > half_travel_m || (!layout.center && wanted.center_m[axis] != 0)) return std::nullopt;
  if (!layout.negative_coefficient && below != above) return std::nullopt;
  const double limit_N = std::min(wanted.limit_N[axis], largest_force_N_);
  if (!layout.positive_saturation && limit_N < device_force_N_) return std::nullopt;
  const auto counts = [](double fraction, const FieldLayout& field) {
    return rounded(std::min(fraction, 1.0) * static_cast<double>(field.logical_maximum));
  };
  Condition condition;
  if (layout.center) condition.center = counts(wanted.center_m[axis] / half_travel_m, layout.center->field);
  condition.above = counts(above / slope, layout.positive_coefficient.field);
  condition.below =
      layout.negative_coefficient ? counts(below / slope, layout.negative_coefficient->field) : condition.above;
  if (layout.positive_saturation)
    condition.saturation = counts(limit_N / device_force_N_, layout.positive_saturation->field);
  return condition;
}

void PidDriver::render(const Condition& counts, DeviceSpring& rendered, int axis) const {
  const PidSetCondition& layout = *layout_.set_condition;
  const auto fraction = [](std::int64_t value, const FieldLayout& field) {
    return static_cast<double>(value) / static_cast<double>(field.logical_maximum);
  };
  const double slope = largest_slope_N_per_m(axis);
  if (layout.center) rendered.center_m[axis] = fraction(counts.center, layout.center->field) * (options_.travel_m[axis] / 2);
  rendered.above_N_per_m[axis] = fraction(counts.above, layout.positive_coefficient.field) * slope;
  rendered.below_N_per_m[axis] = layout.negative_coefficient
                                     ? fraction(counts.below, layout.negative_coefficient->field) * slope
                                     : rendered.above_N_per_m[axis];
  rendered.limit_N[axis] = layout.positive_saturation
                               ? fraction(counts.saturation, layout.positive_saturation->field) * device_force_N_
                               : device_force_N_;
}

DeviceSpring PidDriver::write_spring(const DeviceSpring& wanted) {
  require_writable();
  DeviceSpring rendered;
  for (Effect& effect : effects_) {
    if (!effect.is_spring) continue;
    const int axis = static_cast<int>(effect.axis);
    const auto counts = counts_of(wanted, axis);
    if (counts) render(*counts, rendered, axis);
    update(effect, condition(effect, counts.value_or(Condition{})), layout_.set_condition->block);
  }
  refresh();
  return rendered;
}

std::span<std::byte> PidDriver::condition(const Effect& effect, const Condition& counts) {
  const PidSetCondition& layout = *layout_.set_condition;
  const auto report = compose(layout.report);
  set_nearest(report, layout.block, effect.block);
  set_nearest(report, layout.positive_coefficient, counts.above);
  const auto optional = [&](const std::optional<PidValue>& value, std::int64_t count) {
    if (value) set_nearest(report, *value, count);
  };
  optional(layout.parameter_block, 0);  // the effect has one axis
  optional(layout.center, counts.center);
  optional(layout.negative_coefficient, counts.below);
  optional(layout.positive_saturation, counts.saturation);
  optional(layout.negative_saturation, counts.saturation);
  optional(layout.dead_band, 0);
  return report;
}

// ---- sending

/// A report of zeros with its id; valid until the next call.
std::span<std::byte> PidDriver::compose(const PidReport& report) {
  if (output_.size() < report.size) output_.resize(report.size);
  const auto bytes = std::span(output_).first(report.size);
  std::fill(bytes.begin(), bytes.end(), std::byte{0});
  bytes[0] = std::byte{report.id};
  return bytes;
}

std::span<std::byte> PidDriver::operation(const Effect& effect, const PidChoice& what) {
  const auto report = compose(layout_.operation.report);
  set_nearest(report, layout_.operation.block, effect.block);
  choose(report, what);
  if (layout_.operation.loop_count) set_nearest(report, *layout_.operation.loop_count, 1);
  return report;
}

bool PidDriver::send_in_tick(std::span<const std::byte> report, const PidValue& block) {
  const HidWrite sent = names_block_second(block) ? transport_.write_newest(report) : transport_.write(report);
  return internal::is_taken(sent, transport_, counters_);
}

void PidDriver::require_sent(std::span<const std::byte> report, const char* name) {
  const HidWrite sent = transport_.write(report);
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

void PidDriver::fail(const std::string& what) const { throw DeviceError(transport_.info().path + ": " + what); }

double steepest_spring_N_per_m(const PidOptions& options) {
  double least_N_per_m = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (options.travel_m[axis] <= 0) continue;
    const double full = options.full_slope_N_per_m ? (*options.full_slope_N_per_m)[axis]
                                                   : *options.full_scale_N / (options.travel_m[axis] / 2);
    least_N_per_m = std::min(least_N_per_m, full * options.gain);
  }
  return least_N_per_m;
}

}  // namespace evenstep
