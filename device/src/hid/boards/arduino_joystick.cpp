// ArduinoJoystickWithFFBLibrary: what PIDReportHandler.cpp and Joystick.cpp do, as far as forces and springs go. A sketch
// turns the library's two numbers into motors; here a positive one pushes towards higher positions.
#include <algorithm>
#include <array>

#include "evenstep/time/reproducible_math.h"
#include "firmware.h"

namespace evenstep::internal {
namespace {

enum Id : std::uint8_t {
  kSetEffect = 1,
  kSetCondition = 3,
  kConstantForce = 5,
  kOperation = 10,
  kBlockFree = 11,
  kControl = 12,
  kGain = 13,
  kCreate = 5,
  kLoad = 6,
  kPool = 7
};
constexpr std::uint8_t kConstant = 1, kSpring = 8, kDirectionEnable = 4;
constexpr int kInfinite = 0x7FFF, kMost = 10'000, kEffects = 14;
constexpr double kPi = 3.14159265358979323846;

struct Effect {
  bool allocated = false, plays = false;
  std::uint8_t type = 0, gain = 0, axis_bits = 0, condition_reports = 0;
  std::array<std::uint8_t, 2> directions{};
  std::int16_t magnitude = 0;
  int duration_ms = 0;
  std::int64_t started_ms = 0;
  std::array<ConditionCounts, 2> conditions;
};

class ArduinoJoystick final : public Firmware {
 public:
  explicit ArduinoJoystick(const FirmwareOptions& options)
      : options_(options), last_(std::min(kEffects - 1, options.pool_effects)) {}

  HidDeviceInfo info() const override { return {"", 0x2341, 0x8036, "Arduino Leonardo", "simulated"}; }
  std::vector<std::byte> report_descriptor() const override;
  bool take_output(std::span<const std::byte> report, std::int64_t ms) override;
  bool take_feature(std::span<const std::byte> report) override;
  std::vector<std::byte> answer(std::uint8_t id) override;
  std::vector<std::byte> position_report(const glm::dvec3& share) const override;

  int end_effects(std::int64_t ms) override;
  glm::dvec3 force(const glm::dvec3& share, const glm::dvec3& slope) const override;
  int playing() const override { return count_playing(effects_); }
  int allocated() const override {
    return count(effects_, [](const Effect& effect) { return effect.allocated; });
  }
  bool actuators_enabled() const override { return enabled_; }

 private:
  static void set_effect(Effect& effect, std::span<const std::byte> report);
  static void set_condition(Effect& effect, std::span<const std::byte> report);
  void operate(Effect& effect, std::span<const std::byte> report, std::int64_t ms);
  void control(std::uint8_t command);
  static int along(const Effect& effect, std::size_t axis, double position, double slope);
  static double spring(const Effect& effect, const ConditionCounts& condition, double position, double slope);

  FirmwareOptions options_;
  int last_;  // the highest block that may be used
  std::array<Effect, kEffects> effects_;
  bool enabled_ = true, paused_ = false;
  int created_ = 0;
  std::uint8_t loaded_ = 0, load_status_ = 0;
};

std::vector<std::byte> ArduinoJoystick::report_descriptor() const {
  BoardItems at;
  at.joystick(32, 2);
  at.block_report(0x21, kSetEffect);
  at.effect_type();
  at.unit(0x1003, 0xFD);
  at.outputs({0x50, 0x54, 0x51}, 16, 0, 32'767);
  at.unit(0, 0);
  at.outputs({0x52}, 8, 0, 255);
  at.outputs({0x53}, 8, 1, 8);
  at.axes_enable();
  at.per_axis(0x57, 2, 8, 255);
  at.close();

  at.block_report(0x5F, kSetCondition);
  at.outputs({0x23}, 4, 0, 1);
  at.per_axis(0x58, 2, 2);
  at.outputs({0x60, 0x61, 0x62}, 16, -kMost, kMost);
  at.outputs({0x63, 0x64, 0x65}, 16, 0, kMost);
  at.close();

  at.constant_force(kConstantForce, kMost);
  at.operation(kOperation);
  at.block_free(kBlockFree);
  at.device_control(kControl);
  at.gain(kGain);
  at.create_effect(kCreate);
  at.block_load(kLoad);
  at.pool(kPool);
  at.close();
  return std::move(at.bytes);
}

std::vector<std::byte> ArduinoJoystick::position_report(const glm::dvec3& share) const {
  return joystick_report(5, share, 2);
}

bool ArduinoJoystick::take_output(std::span<const std::byte> report, std::int64_t ms) {
  if (report.size() < 2) return false;
  const std::uint8_t index = byte_at(report, 1);
  if (report[0] == std::byte{kControl}) return control(index), true;
  if (report[0] == std::byte{kGain}) return true;  // kept, and never looked at again
  if (index >= kEffects) return true;
  Effect& effect = effects_[index];
  switch (byte_at(report, 0)) {
    case kSetEffect:
      if (report.size() >= 14) set_effect(effect, report);
      return true;
    case kSetCondition:
      if (report.size() >= 15) set_condition(effect, report);
      return true;
    case kConstantForce:
      if (report.size() >= 4) effect.magnitude = signed_at(report, 2);
      return true;
    case kOperation:
      if (report.size() >= 4) operate(effect, report, ms);
      return true;
    case kBlockFree:
      effect.allocated = effect.plays = false;
      return true;
    default:
      return false;
  }
}

void ArduinoJoystick::set_effect(Effect& effect, std::span<const std::byte> report) {
  effect.type = byte_at(report, 2);
  effect.duration_ms = word_at(report, 3);
  effect.gain = byte_at(report, 9);
  effect.axis_bits = byte_at(report, 11);
  effect.directions = {byte_at(report, 12), byte_at(report, 13)};
}

void ArduinoJoystick::set_condition(Effect& effect, std::span<const std::byte> report) {
  const std::uint8_t axis = byte_at(report, 2);
  if (axis >= 2) return;  // the library writes past its array; nobody knows what that does
  effect.conditions[axis] = condition_of(report);
  ++effect.condition_reports;
}

void ArduinoJoystick::operate(Effect& effect, std::span<const std::byte> report, std::int64_t ms) {
  const std::uint8_t operation = byte_at(report, 2), loops = byte_at(report, 3);
  if (operation == 2) stop_all(effects_);
  if (operation == 1 && loops > 0) effect.duration_ms = (effect.duration_ms * loops) & 0xFFFF;
  if (operation == 1 && loops == 255) effect.duration_ms = kInfinite;
  if (operation == 1 || operation == 2) {
    effect.plays = true;
    effect.started_ms = ms;
  }
  if (operation == 3) effect.plays = false;
}

void ArduinoJoystick::control(std::uint8_t command) {
  if (command == 1) enabled_ = true;
  if (command == 2) enabled_ = false;  // only noted: the forces go on
  if (command == 3) stop_all(effects_);
  if (command == 4) effects_.fill({});
  if (command == 5) paused_ = true;
  if (command == 6) paused_ = false;
}

bool ArduinoJoystick::take_feature(std::span<const std::byte> report) {
  if (report.size() < 2 || report[0] != std::byte{kCreate}) return false;
  int block = 1;
  while (block <= last_ && effects_[static_cast<std::size_t>(block)].allocated) ++block;
  const bool fails = created_++ == options_.block_load_error_at;
  loaded_ = fails || block > last_ ? std::uint8_t{0} : static_cast<std::uint8_t>(block);
  load_status_ = fails ? 3 : loaded_ == 0 ? 2 : 1;
  if (loaded_ == 0) return true;
  effects_[loaded_] = {};
  effects_[loaded_].allocated = true;
  return true;
}

std::vector<std::byte> ArduinoJoystick::answer(std::uint8_t id) {
  if (id == kLoad) return bytes_of({kLoad, loaded_, load_status_, 0, 0});
  if (id == kPool) return bytes_of({kPool, 0xFF, 0xFF, kEffects, 3});
  return {};
}

int ArduinoJoystick::end_effects(std::int64_t ms) { return end_over(effects_, ms, kInfinite); }

glm::dvec3 ArduinoJoystick::force(const glm::dvec3& share, const glm::dvec3& slope) const {
  glm::dvec3 sum{0};
  for (const Effect& effect : effects_) {
    for (int axis = 0; effect.plays && !paused_ && axis < 2; ++axis)
      sum[axis] += along(effect, static_cast<std::size_t>(axis), share[axis], slope[axis]);
  }
  for (int axis = 0; axis < 3; ++axis) sum[axis] = std::clamp<double>(sum[axis], -kMost, kMost) / kMost;
  return sum;
}

int ArduinoJoystick::along(const Effect& effect, std::size_t axis, double position, double slope) {
  const bool alone = effect.axis_bits == kDirectionEnable;
  const std::uint8_t direction = effect.directions[alone ? 0 : axis];
  const std::size_t block = alone && effect.condition_reports <= 1 ? 0 : axis;
  const double angle = direction / 255.0 * 2 * kPi;
  const double ratio = axis == 0 ? reproducible::sin(angle) : -reproducible::cos(angle);
  if (effect.type == kConstant) return static_cast<int>(effect.magnitude * effect.gain / 255 * ratio);
  if (effect.type != kSpring) return 0;
  const double force = spring(effect, effect.conditions[block], position, slope);
  return static_cast<int>(alone && effect.condition_reports == 1 ? force * ratio : force);
}

double ArduinoJoystick::spring(const Effect& effect, const ConditionCounts& condition, double position, double slope) {
  // The library compares the position, which is -1 to 1, with counts, so if the spring's center is not 0 it takes one side
  // for all positions.
  const int low = condition.center - condition.dead_band, high = condition.center + condition.dead_band;
  const double steepness = slope > 0 ? slope : 1;
  double force = 0;
  if (position < low) {
    force = std::max<double>((position - low / 10'000.0) * condition.negative * steepness, -condition.negative_saturation);
  } else if (position > high) {
    force = std::min<double>((position - high / 10'000.0) * condition.positive * steepness, condition.positive_saturation);
  }
  return -force * effect.gain / 255;
}

}  // namespace

std::unique_ptr<Firmware> arduino_joystick(const FirmwareOptions& options) {
  return std::make_unique<ArduinoJoystick>(options);
}

}  // namespace evenstep::internal
