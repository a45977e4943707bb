#include "evenstep/device/hid/pid_layout.h"

#include <algorithm>
#include <utility>

#include "evenstep/device/hid/pid_axes.h"

namespace evenstep {
namespace {

using pid::kPage;

enum Usage : std::uint32_t {
  kSetEffect = kPage | 0x21,
  kBlock = kPage | 0x22,
  kParameterBlock = kPage | 0x23,
  kConstant = kPage | 0x26,
  kSpring = kPage | 0x40,
  kDuration = kPage | 0x50,
  kSamplePeriod = kPage | 0x51,
  kGain = kPage | 0x52,
  kTriggerButton = kPage | 0x53,
  kTriggerRepeat = kPage | 0x54,
  kAxesEnable = kPage | 0x55,
  kDirectionEnable = kPage | 0x56,
  kDirection = kPage | 0x57,
  kStartDelay = kPage | 0xA7,
  kSetCondition = kPage | 0x5F,
  kCenter = kPage | 0x60,
  kPositiveCoefficient = kPage | 0x61,
  kNegativeCoefficient = kPage | 0x62,
  kPositiveSaturation = kPage | 0x63,
  kNegativeSaturation = kPage | 0x64,
  kDeadBand = kPage | 0x65,
  kMagnitude = kPage | 0x70,
  kSetConstant = kPage | 0x73,
  kOperation = kPage | 0x77,
  kStart = kPage | 0x79,
  kStop = kPage | 0x7B,
  kLoopCount = kPage | 0x7C,
  kDeviceGainReport = kPage | 0x7D,
  kDeviceGain = kPage | 0x7E,
  kPool = kPage | 0x7F,
  kRamSize = kPage | 0x80,
  kSimultaneous = kPage | 0x83,
  kDeviceManaged = kPage | 0xA9,
  kBlockLoad = kPage | 0x89,
  kSuccess = kPage | 0x8C,
  kFull = kPage | 0x8D,
  kError = kPage | 0x8E,
  kRamAvailable = kPage | 0xAC,
  kBlockFree = kPage | 0x90,
  kState = kPage | 0x92,
  kEffectPlaying = kPage | 0x94,
  kEnableActuators = kPage | 0x97,
  kDisableActuators = kPage | 0x98,
  kStopAll = kPage | 0x99,
  kReset = kPage | 0x9A,
  kPause = kPage | 0x9B,
  kResume = kPage | 0x9C,
  kPaused = kPage | 0x9F,
  kActuatorsEnabled = kPage | 0xA0,
  kSafetySwitch = kPage | 0xA4,
  kOverrideSwitch = kPage | 0xA5,
  kActuatorPower = kPage | 0xA6,
  kCreateEffect = kPage | 0xAB,
  kByteCount = 0x01003B,
};

/// The fields of one report: all fields of a type within a collection that have the id of the first such field.
class Scope {
 public:
  Scope(const ReportDescriptor& descriptor, ReportType type, std::uint32_t collection) : descriptor_(descriptor) {
    for (const HidField& field : descriptor.fields) {
      if (field.type != type || !descriptor.is_within(field, collection)) continue;
      if (!fields_.empty() && field.id != fields_.front()->id) continue;
      fields_.push_back(&field);
    }
  }
  bool exists() const { return !fields_.empty(); }
  PidReport report() const {
    const HidField& first = *fields_.front();
    return {first.id, descriptor_.report(first.type, first.id)->size()};
  }
  const std::vector<const HidField*>& fields() const { return fields_; }

  std::optional<PidValue> value(std::uint32_t usage) const {
    for (const HidField* field : fields_) {
      if (!field->variable()) continue;
      if (const auto index = element(*field, usage)) return PidValue{*field, *index};
    }
    return std::nullopt;
  }

  std::optional<PidChoice> choice(std::uint32_t usage) const {
    for (const HidField* field : fields_) {
      if (field->variable()) {
        if (const auto index = element(*field, usage)) return PidChoice{{*field, *index}, 1};
      } else if (const auto value = selector_of(*field, usage)) {
        return PidChoice{{*field, 0}, *value};
      }
    }
    return std::nullopt;
  }

 private:
  static std::optional<std::uint32_t> element(const HidField& field, std::uint32_t usage) {
    if (field.bits == 0 || field.bits > 32) return std::nullopt;
    return field.usages.find(usage, field.count);
  }
  static std::optional<std::uint32_t> selector_of(const HidField& array, std::uint32_t usage) {
    const auto value = selector(array, usage);
    if (!value || array.count == 0) return std::nullopt;
    const bool zero_is_none =
        array.logical_minimum == 0 && array.logical_maximum == static_cast<std::int64_t>(array.usages.size());
    return static_cast<std::uint32_t>(*value + (zero_is_none ? 1 : 0));
  }

  const ReportDescriptor& descriptor_;
  std::vector<const HidField*> fields_;
};

/// Takes the elements that were found, and notes those that are missing.
class Requirements {
 public:
  explicit Requirements(std::vector<std::string>& missing) : missing_(missing) {}
  template <class T>
  T need(std::optional<T> found, const char* what) {
    if (!found) missing_.emplace_back(what);
    return found.value_or(T{});
  }
  void need(bool holds, const char* what) {
    if (!holds) missing_.emplace_back(what);
  }

 private:
  std::vector<std::string>& missing_;
};

/// The first elements of the scope that lie within a collection, or have its usage; each with its own usage.
std::vector<std::pair<std::uint32_t, PidValue>> elements_within(const ReportDescriptor& descriptor, const Scope& scope,
                                                                std::uint32_t collection) {
  std::vector<std::pair<std::uint32_t, PidValue>> found;
  for (const HidField* field : scope.fields()) {
    if (!field->variable() || field->bits == 0 || field->bits > 32) continue;
    if (!descriptor.is_within(*field, collection)) {
      if (const auto index = field->usages.find(collection, field->count)) found.push_back({collection, {*field, *index}});
      continue;
    }
    for (std::uint32_t i = 0; i < field->count && found.size() < pid::kAxes; ++i)
      found.push_back({field->usages[i], {*field, i}});
  }
  return found;
}

PidSetEffect set_effect_of(const ReportDescriptor& descriptor, Requirements& needs) {
  const Scope scope(descriptor, ReportType::output, kSetEffect);
  needs.need(scope.exists(), "a Set Effect output report (usage 0x0F0021)");
  PidSetEffect effect;
  if (!scope.exists()) return effect;
  effect.report = scope.report();
  effect.block = needs.need(scope.value(kBlock), "an Effect Block Index (0x0F0022) in Set Effect");
  effect.constant =
      needs.need(scope.choice(kConstant), "an Effect Type that selects Constant Force (0x0F0026) in Set Effect");
  effect.spring = scope.choice(kSpring);
  effect.duration = scope.value(kDuration);
  effect.trigger_repeat = scope.value(kTriggerRepeat);
  effect.sample_period = scope.value(kSamplePeriod);
  effect.start_delay = scope.value(kStartDelay);
  effect.gain = scope.value(kGain);
  effect.trigger_button = scope.value(kTriggerButton);
  effect.direction_enable = scope.value(kDirectionEnable);
  for (const auto& [usage, value] : elements_within(descriptor, scope, kAxesEnable)) {
    if (usage >= pid::kFirstAxis && usage < pid::kFirstAxis + pid::kAxes)
      effect.axis_enable[usage - pid::kFirstAxis] = value;
  }
  for (const auto& [usage, value] : elements_within(descriptor, scope, kDirection)) effect.directions.push_back(value);
  return effect;
}

PidSetConstant set_constant_of(const ReportDescriptor& descriptor, Requirements& needs) {
  const Scope scope(descriptor, ReportType::output, kSetConstant);
  needs.need(scope.exists(), "a Set Constant Force output report (usage 0x0F0073)");
  if (!scope.exists()) return {};
  const PidSetConstant constant{scope.report(),
                                needs.need(scope.value(kBlock), "an Effect Block Index (0x0F0022) in Set Constant Force"),
                                needs.need(scope.value(kMagnitude), "a Magnitude (0x0F0070) in Set Constant Force")};
  const FieldLayout& magnitude = constant.magnitude.field;
  if (magnitude.bits > 0) {
    needs.need(magnitude.logical_minimum < 0 && magnitude.logical_maximum > 0,
               "a Magnitude of both signs (logical minimum < 0 < maximum) in Set Constant Force");
  }
  return constant;
}

PidOperation operation_of(const ReportDescriptor& descriptor, Requirements& needs) {
  const Scope scope(descriptor, ReportType::output, kOperation);
  needs.need(scope.exists(), "an Effect Operation output report (usage 0x0F0077)");
  if (!scope.exists()) return {};
  return {scope.report(), needs.need(scope.value(kBlock), "an Effect Block Index (0x0F0022) in Effect Operation"),
          needs.need(scope.choice(kStart), "an operation that selects Start (0x0F0079) in Effect Operation"),
          scope.choice(kStop), scope.value(kLoopCount)};
}

std::optional<PidSetCondition> set_condition_of(const ReportDescriptor& descriptor) {
  const Scope scope(descriptor, ReportType::output, kSetCondition);
  const auto block = scope.value(kBlock), coefficient = scope.value(kPositiveCoefficient);
  if (!block || !coefficient) return std::nullopt;
  return PidSetCondition{.report = scope.report(),
                         .block = *block,
                         .positive_coefficient = *coefficient,
                         .parameter_block = scope.value(kParameterBlock),
                         .center = scope.value(kCenter),
                         .negative_coefficient = scope.value(kNegativeCoefficient),
                         .positive_saturation = scope.value(kPositiveSaturation),
                         .negative_saturation = scope.value(kNegativeSaturation),
                         .dead_band = scope.value(kDeadBand)};
}

/// Devices differ in the collection around the commands (0x95 or 0x96), so this searches for the commands themselves.
std::optional<PidDeviceControl> device_control_of(const ReportDescriptor& descriptor) {
  for (const std::uint32_t collection : {kPage | 0x96, kPage | 0x95}) {
    const Scope scope(descriptor, ReportType::output, collection);
    const auto command = [&](Usage usage) { return scope.choice(usage); };
    if (!command(kEnableActuators) && !command(kStopAll) && !command(kReset)) continue;
    return PidDeviceControl{.report = scope.report(),
                            .enable_actuators = command(kEnableActuators),
                            .disable_actuators = command(kDisableActuators),
                            .stop_all = command(kStopAll),
                            .reset = command(kReset),
                            .pause = command(kPause),
                            .resume = command(kResume)};
  }
  return std::nullopt;
}

std::optional<PidCreateEffect> create_effect_of(const ReportDescriptor& descriptor) {
  const Scope scope(descriptor, ReportType::feature, kCreateEffect);
  const auto constant = scope.choice(kConstant);
  if (!constant) return std::nullopt;
  return PidCreateEffect{scope.report(), *constant, scope.choice(kSpring), scope.value(kByteCount)};
}

std::optional<PidBlockLoad> block_load_of(const ReportDescriptor& descriptor) {
  const Scope scope(descriptor, ReportType::feature, kBlockLoad);
  const auto block = scope.value(kBlock);
  if (!block) return std::nullopt;
  return PidBlockLoad{.report = scope.report(),
                      .block = *block,
                      .success = scope.choice(kSuccess),
                      .full = scope.choice(kFull),
                      .error = scope.choice(kError),
                      .ram_available = scope.value(kRamAvailable)};
}

std::optional<PidPoolLayout> pool_of(const ReportDescriptor& descriptor) {
  const Scope scope(descriptor, ReportType::feature, kPool);
  if (!scope.exists()) return std::nullopt;
  return PidPoolLayout{.report = scope.report(),
                       .ram_size = scope.value(kRamSize),
                       .simultaneous = scope.value(kSimultaneous),
                       .device_managed = scope.value(kDeviceManaged)};
}

std::optional<PidStateLayout> state_of(const ReportDescriptor& descriptor) {
  const Scope scope(descriptor, ReportType::input, kState);
  if (!scope.exists()) return std::nullopt;
  return PidStateLayout{.report = scope.report(),
                        .paused = scope.value(kPaused),
                        .actuators_enabled = scope.value(kActuatorsEnabled),
                        .safety_switch = scope.value(kSafetySwitch),
                        .override_switch = scope.value(kOverrideSwitch),
                        .actuator_power = scope.value(kActuatorPower),
                        .effect_playing = scope.value(kEffectPlaying),
                        .block = scope.value(kBlock)};
}

template <class Single>
std::optional<Single> single_value(const ReportDescriptor& descriptor, std::uint32_t collection, std::uint32_t usage) {
  const Scope scope(descriptor, ReportType::output, collection);
  const auto value = scope.value(usage);
  if (!value) return std::nullopt;
  return Single{scope.report(), *value};
}

/// The first absolute axis of each kind in any input report.
std::array<std::optional<PidPosition>, pid::kAxes> positions_of(const ReportDescriptor& descriptor) {
  std::array<std::optional<PidPosition>, pid::kAxes> positions;
  for (const HidField& field : descriptor.fields) {
    if (field.type != ReportType::input || !field.variable() || field.relative() || field.bits == 0 || field.bits > 32)
      continue;
    if (field.logical_minimum == field.logical_maximum) continue;
    for (std::uint32_t axis = 0; axis < pid::kAxes; ++axis) {
      const auto index = field.usages.find(pid::kFirstAxis + axis, field.count);
      if (!index || positions[axis]) continue;
      positions[axis] = PidPosition{{field.id, descriptor.report(field.type, field.id)->size()}, {field, *index}};
    }
  }
  return positions;
}

}  // namespace

Result<PidLayout, std::vector<std::string>> pid_layout(const ReportDescriptor& descriptor) {
  std::vector<std::string> missing;
  Requirements needs(missing);
  PidLayout layout;
  layout.position = positions_of(descriptor);
  for (const HidReport& report : descriptor.reports) {
    if (report.type == ReportType::input) layout.inputs.push_back({report.id, report.size()});
  }
  layout.set_effect = set_effect_of(descriptor, needs);
  layout.set_constant = set_constant_of(descriptor, needs);
  layout.operation = operation_of(descriptor, needs);
  layout.set_condition = set_condition_of(descriptor);
  layout.block_free = single_value<PidBlockFree>(descriptor, kBlockFree, kBlock);
  layout.device_control = device_control_of(descriptor);
  layout.device_gain = single_value<PidDeviceGain>(descriptor, kDeviceGainReport, kDeviceGain);
  layout.create_effect = create_effect_of(descriptor);
  layout.block_load = block_load_of(descriptor);
  layout.pool = pool_of(descriptor);
  layout.state = state_of(descriptor);
  if (!missing.empty()) return Failure(std::move(missing));
  return layout;
}

std::array<bool, pid::kAxes> pid_force_axes(const PidLayout& layout) {
  const PidSetEffect& effect = layout.set_effect;
  std::array<bool, pid::kAxes> listed{};
  for (std::size_t axis = 0; axis < pid::kAxes; ++axis) listed[axis] = effect.axis_enable[axis].has_value();
  if (listed != std::array<bool, pid::kAxes>{}) return listed;
  return {true, effect.directions.size() > 1, false};
}

bool set_nearest(std::span<std::byte> report, const PidValue& value, std::int64_t wanted) {
  const auto fits = nearest(value.field, wanted);
  return fits && set(report, value.field, value.index, *fits);
}

double seconds_per_count(const FieldLayout& duration) {
  const bool is_time = (duration.unit >> 12 & 0xF) == 1;
  double seconds = is_time ? 1 : 1e-3;
  for (int e = is_time ? std::clamp(duration.unit_exponent, -9, 9) : 0; e != 0; e += e < 0 ? 1 : -1) {
    seconds = e < 0 ? seconds / 10 : seconds * 10;
  }
  return seconds;
}

/// Every element of an array is a choice, and 0 can be one; so all make the same.
bool choose(std::span<std::byte> report, const PidChoice& choice) {
  const FieldLayout& field = choice.where.field;
  if (field.variable()) return set_raw(report, field, choice.where.index, choice.value);
  bool fits = true;
  for (std::uint32_t i = 0; i < field.count; ++i) fits = set_raw(report, field, i, choice.value) && fits;
  return fits;
}

bool is_chosen(std::span<const std::byte> report, const PidChoice& choice) {
  return get(report, choice.where) == std::optional<std::int64_t>(choice.value);
}

}  // namespace evenstep
