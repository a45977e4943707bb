#include "evenstep/device/hid/pid_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "pid_counts.h"
#include "report_exchange.h"

namespace evenstep {
namespace {

/// The distance from the middle of the range, as a share of half the range.
double deflection(const FieldLayout& field, std::int64_t value) { return 2 * internal::fraction_of(field, value) - 1; }

/// Takes the place of the effects' duration where they do not end: forces and Starts are sent again after half of it, and a
/// device that refuses reports for all of it is given up.
constexpr Duration kUsualDuration{500'000'000};

/// Waiting reports can only replace one another if their second byte is the effect block.
bool names_block_second(const PidValue& block) {
  return block.field.bit_offset == 0 && block.field.bits == 8 && block.index == 0;
}

}  // namespace

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

// ---- a tick

DeviceSample PidDriver::read(RealTime now) {
  last_.read_at = now;
  last_.fresh = false;
  const PidSilence before = silence();
  const bool had_returned = has_returned_;
  const bool is_here = internal::drain(
      transport_, input_, [&](std::span<const std::byte> report) { take(report); }, [&] { has_returned_ = true; });
  last_.away = !is_here || has_returned_ != had_returned;
  if (!last_.fresh) ++counters_.stale;
  notice_silence(before);
  notice_refusals(now);
  last_.drivable = !is_silent() && !last_.away;
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
  saw_actuators_ = saw_actuators_ || state_.actuators_enabled == true;
  saw_switch_ = saw_switch_ || state_.safety_switch == true;
  saw_power_ = saw_power_ || state_.actuator_power == true;
}

void PidDriver::require_writable() const {
  if (is_read_only())
    fail("a force cannot be written: PID devices have no newtons; give full_scale_N, the force of the largest magnitude");
  if (!started_) fail("a force cannot be written before start() or after stop()");
}

PidSilence PidDriver::silence() const {
  if (has_returned_) return PidSilence::returned;
  if (state_.paused == true) return PidSilence::paused;
  if (saw_actuators_ && state_.actuators_enabled == false) return PidSilence::actuators_off;
  if (saw_switch_ && state_.safety_switch == false) return PidSilence::switch_open;
  if (saw_power_ && state_.actuator_power == false) return PidSilence::no_power;
  return PidSilence::none;
}

void PidDriver::notice_silence(PidSilence before) {
  if (before != PidSilence::none) return;
  switch (silence()) {
    case PidSilence::none:
    case PidSilence::returned:
      return;
    case PidSilence::paused:
      ++pid_counters_.cuts_paused;
      return;
    case PidSilence::actuators_off:
      ++pid_counters_.cuts_actuators;
      return;
    case PidSilence::switch_open:
      ++pid_counters_.cuts_switch;
      return;
    case PidSilence::no_power:
      ++pid_counters_.cuts_power;
      return;
  }
}

/// It is not known which report was refused, so everything is sent again, as in a refresh.
void PidDriver::notice_refusals(RealTime now) {
  const std::int64_t refused = internal::new_refusals(transport_, refusals_seen_, counters_);
  if (refused > 0) refreshed_at_.reset();
  if (refused == 0 && !refused_in_tick_) refused_since_.reset();
  if ((refused > 0 || refused_in_tick_) && !refused_since_) refused_since_ = now;
  refused_in_tick_ = false;
  const Duration patience = effect_duration_.value_or(kUsualDuration);
  if (!started_ || !refused_since_ || now - *refused_since_ < patience) return;
  fail(fmt::format("the device has refused reports for {:.0f} ms; if it still pushes, switch it off",
                   seconds(patience) * 1e3));
}

std::map<std::string, std::int64_t> PidDriver::own_counters() const {
  return {{"pid_refreshes", pid_counters_.refreshes},     {"pid_saturated", pid_counters_.saturated},
          {"pid_unpowered", pid_counters_.unpowered},     {"pid_pool_unknown", pid_counters_.pool_unknown},
          {"pid_cuts_paused", pid_counters_.cuts_paused}, {"pid_cuts_actuators", pid_counters_.cuts_actuators},
          {"pid_cuts_switch", pid_counters_.cuts_switch}, {"pid_cuts_power", pid_counters_.cuts_power}};
}

void PidDriver::write(const glm::dvec3& force_N) {
  require_writable();
  assert(std::isfinite(force_N.x) && std::isfinite(force_N.y) && std::isfinite(force_N.z));
  if (is_silent()) ++pid_counters_.unpowered;
  bool saturated = false;
  for (Effect& effect : effects_) {
    if (effect.is_spring) continue;
    const double along_N = force_N[static_cast<int>(effect.axis)];
    saturated = saturated || std::abs(along_N) > largest_force_N();
    want(effect, constant_force(effect, along_N));
  }
  if (saturated) ++pid_counters_.saturated;
  send_wanted();
}

/// Along X a positive magnitude pushes towards lower positions: Linux's 90 degrees are a force to the left. A device without
/// a direction gets the same magnitude from Linux, so it is one that pushes as if from there.
std::span<std::byte> PidDriver::constant_force(const Effect& effect, double force_N) {
  const auto report = compose(layout_.set_constant.report);
  const PidValue& magnitude = layout_.set_constant.magnitude;
  const double largest_N = largest_force_N();
  const bool is_negative = (effect.axis == 0) != options_.reversed_force[effect.axis];
  const double wanted_N = std::clamp(force_N, -largest_N, largest_N) * (is_negative ? -1 : 1);
  const auto most = static_cast<double>(std::min(magnitude.field.logical_maximum, -magnitude.field.logical_minimum));
  set_nearest(report, layout_.set_constant.block, effect.block);
  set_nearest(report, magnitude, internal::rounded(wanted_N / *options_.full_scale_N * most));
  return report;
}

void PidDriver::want(Effect& effect, std::span<const std::byte> report) {
  if (std::equal(report.begin(), report.end(), effect.wanted.begin(), effect.wanted.end())) return;
  effect.wanted.assign(report.begin(), report.end());
  effect.is_sent = false;
}

/// Sends what has changed or was refused. A refresh sends everything, in case something was lost, together with Start; a
/// refused refresh is tried again in the next tick.
void PidDriver::send_wanted() {
  const Duration period{effect_duration_.value_or(kUsualDuration).ns / 2};
  const bool refreshes = !refreshed_at_ || last_.read_at - *refreshed_at_ >= period;
  bool all = true;
  for (Effect& effect : effects_) {
    if (refreshes || !effect.is_sent)
      effect.is_sent =
          send_in_tick(effect.wanted, effect.is_spring ? layout_.set_condition->block : layout_.set_constant.block);
    if (!refreshes) continue;
    all = send_in_tick(operation(effect, layout_.operation.start), layout_.operation.block) && effect.is_sent && all;
  }
  if (!refreshes || !all) return;
  refreshed_at_ = last_.read_at;
  ++pid_counters_.refreshes;
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
  const bool taken = internal::is_taken(sent, transport_, counters_);
  refused_in_tick_ = refused_in_tick_ || !taken;
  return taken;
}

void PidDriver::fail(const std::string& what) const { throw DeviceError(transport_.info().path + ": " + what); }

}  // namespace evenstep
