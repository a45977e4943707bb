// OpenFFBoard: what HidFFB.cpp and EffectsCalculator.cpp of its firmware do, as far as forces and springs go.
#include <algorithm>
#include <array>
#include <utility>

#include "evenstep/time/reproducible_math.h"
#include "firmware.h"

namespace evenstep::internal {
namespace {

enum Id : std::uint8_t {
  kState = 2,
  kSetEffect = 1,
  kSetEnvelope = 2,
  kSetCondition = 3,
  kConstantForce = 5,
  kOperation = 10,
  kBlockFree = 11,
  kControl = 12,
  kGain = 13,
  kCreate = 0x11,
  kLoad = 0x12,
  kPool = 0x13
};
constexpr std::uint8_t kConstant = 1, kSpring = 8;
constexpr int kInfinite = 0xFFFF;
constexpr std::int32_t kMost = 0x7FFF;
/// (64 + 1) / 256 * 16: the gain and the scale of springs that the firmware has unless they are set.
constexpr double kOwnSlope = 4.0625;
constexpr float kPi = 3.14159265F;

/// The levels are magnitudes without a sign, the times milliseconds.
struct Envelope {
  std::uint16_t attack_level = 0, fade_level = 0;
  std::uint32_t attack_ms = 0, fade_ms = 0;
};

struct Effect {
  std::uint8_t type = 0;
  bool plays = false;
  std::uint8_t gain = 255;
  std::int16_t magnitude = 0;
  int duration_ms = kInfinite;
  std::int64_t started_ms = 0;
  std::array<float, 2> ratio{};
  Envelope envelope;
  std::array<ConditionCounts, 2> conditions;
  bool one_condition = true;
};

class OpenFfBoard final : public Firmware {
 public:
  OpenFfBoard(int axes, const FirmwareOptions& options)
      : axes_(axes), options_(options), effects_(static_cast<std::size_t>(std::min(40, options.pool_effects))) {}

  HidDeviceInfo info() const override { return {"", 0x1209, 0xFFB0, "FFBoard", "simulated"}; }
  std::vector<std::byte> report_descriptor() const override;
  bool take_output(std::span<const std::byte> report, std::int64_t ms) override;
  bool take_feature(std::span<const std::byte> report) override;
  std::vector<std::byte> answer(std::uint8_t id) override;
  std::vector<std::byte> position_report(const glm::dvec3& share) const override;
  std::vector<std::uint8_t> states() override { return std::exchange(states_, {}); }
  std::vector<std::byte> state_report(std::uint8_t state) const override { return bytes_of({kState, state}); }

  int end_effects(std::int64_t ms) override;
  glm::dvec3 force(const glm::dvec3& share, const glm::dvec3& slope) const override;
  int playing() const override { return count_playing(effects_); }
  int allocated() const override {
    return count(effects_, [](const Effect& effect) { return effect.type != 0; });
  }
  bool actuators_enabled() const override { return active_; }

 private:
  void say_state() { states_.push_back(active_ ? 0x1A : 0x09); }  // power; enabled and playing, or paused
  void set_effect(Effect& effect, std::span<const std::byte> report);
  void set_condition(Effect& effect, std::span<const std::byte> report) const;
  void operate(std::size_t index, std::span<const std::byte> report, std::int64_t ms);
  void control(std::uint8_t commands);
  std::int32_t magnitude(const Effect& effect) const;
  std::int32_t spring(const Effect& effect, std::size_t axis, double position, double slope) const;

  int axes_;
  FirmwareOptions options_;
  std::vector<Effect> effects_;
  std::vector<std::uint8_t> states_;
  bool active_ = false;
  int gain_ = 255;
  std::int64_t now_ms_ = 0;
  int created_ = 0;
  std::uint8_t loaded_ = 1, load_status_ = 1;
};

std::vector<std::byte> OpenFfBoard::report_descriptor() const {
  BoardItems at;
  at.joystick(64, 8);
  at.states(kState);

  at.block_report(0x21, kSetEffect);
  at.effect_type();
  at.unit(0x1003, 0xFD);
  at.outputs({0x50, 0x54, 0x51, 0xA7}, 16, 0, 32'767);
  at.unit(0, 0);
  at.outputs({0x52}, 8, 0, 255);
  at.outputs({0x53}, 8, 1, 8);
  at.open(0x55);
  at.page(0x01);
  // With one axis these bits, and Direction Enable after them, have the logical range 0..0.
  axes_ == 1 ? at.outputs({0x30}, 1, 0, 0) : at.outputs({0x30, 0x31}, 1, 0, 1);
  at.close();
  at.page(0x0F);
  at.outputs({0x56}, 1, 0, axes_ == 1 ? 0 : 1);
  at.output_padding(7 - axes_);
  at.per_axis(0x57, axes_, 16, 36'000);  // Direction
  at.per_axis(0x58, axes_, 16, 32'765);  // Type Specific Block Offset
  at.close();

  at.envelope(kSetEnvelope, 32'767);
  at.block_report(0x5F, kSetCondition);
  at.outputs({0x23}, axes_ == 1 ? 6 : 4, 0, 3);
  at.per_axis(0x58, axes_, 2);
  at.outputs({0x60, 0x61, 0x62}, 16, -32'768, 32'767);
  at.outputs({0x63, 0x64, 0x65}, 16, 0, 32'767);
  at.close();

  at.constant_force(kConstantForce, 32'767);
  at.operation(kOperation);
  at.block_free(kBlockFree);
  at.open_report(0x95, kControl);
  at.open(0x96);
  at.usages({0x97, 0x98, 0x99, 0x9A, 0x9B, 0x9C});
  at.logical(1, 6);
  at.format(1, 8);
  at.output(BoardItems::kVariable);
  at.close();
  at.close();
  at.gain(kGain);
  at.create_effect(kCreate);
  at.block_load(kLoad);
  at.pool(kPool);
  at.close();
  return std::move(at.bytes);
}

std::vector<std::byte> OpenFfBoard::position_report(const glm::dvec3& share) const {
  std::vector<std::byte> bytes(9);
  bytes[0] = std::byte{1};
  for (int axis = 0; axis < 8; ++axis) put_position(bytes, axis < axes_ ? share[axis] : 0);
  return bytes;
}

bool OpenFfBoard::take_output(std::span<const std::byte> report, std::int64_t ms) {
  now_ms_ = ms;
  if (report.size() < 2) return false;
  if (report[0] == std::byte{kControl}) return control(byte_at(report, 1)), true;
  if (report[0] == std::byte{kGain}) return gain_ = byte_at(report, 1), true;
  const std::size_t index = byte_at(report, 1);
  if (index == 0 || index > effects_.size()) return true;
  Effect& effect = effects_[index - 1];
  switch (byte_at(report, 0)) {
    case kSetEffect:
      if (report.size() >= static_cast<std::size_t>(axes_ == 1 ? 16 : 18)) set_effect(effect, report);
      return true;
    case kSetEnvelope:
      if (report.size() >= 14)
        effect.envelope = {word_at(report, 2), word_at(report, 4), long_word_at(report, 6), long_word_at(report, 10)};
      return true;
    case kSetCondition:
      if (report.size() >= 15) set_condition(effect, report);
      return true;
    case kConstantForce:
      if (report.size() >= 4) effect.magnitude = signed_at(report, 2);
      return true;
    case kOperation:
      if (report.size() >= 4) operate(index - 1, report, ms);
      return true;
    case kBlockFree:
      effect = {};
      return true;
    default:
      return false;
  }
}

void OpenFfBoard::control(std::uint8_t commands) {
  if (commands & 0x01) active_ = true;
  if (commands & (0x02 | 0x04)) active_ = false;  // it treats Disable Actuators and Stop All Effects alike
  if (commands & 0x08) {
    active_ = false;
    std::fill(effects_.begin(), effects_.end(), Effect{});
  }
  if (commands & 0x10) active_ = false;
  if (commands & 0x20) active_ = true;
}

/// The axis byte has a bit for each axis, then Direction Enable.
void OpenFfBoard::set_effect(Effect& effect, std::span<const std::byte> report) {
  effect.type = byte_at(report, 2);
  const int duration_ms = word_at(report, 3);
  effect.duration_ms = duration_ms == 0 ? kInfinite : duration_ms;
  effect.gain = byte_at(report, 11);
  const int axis_bits = byte_at(report, 13);
  const bool by_direction = axis_bits & (1 << axes_);
  const std::uint16_t direction_x = word_at(report, 14);
  const std::uint16_t direction_y = axes_ == 2 ? word_at(report, 16) : std::uint16_t{0};
  bool by_conditions = false;
  for (std::size_t axis = 0; axis < 2 && effect.type == kSpring && !effect.one_condition; ++axis) {
    if (!effect.conditions[axis].acts()) continue;
    effect.ratio[axis] = 1;
    by_conditions = true;
  }
  if (!by_conditions) {
    const float angle = 2 * kPi * (static_cast<float>(direction_x) / 36'000.0F);
    const auto linear = [](std::uint16_t direction) { return (static_cast<float>(direction) - 18'000.0F) / 18'000.0F; };
    effect.ratio = {by_direction ? static_cast<float>(reproducible::sin(static_cast<double>(angle)))
                                 : (axis_bits & 1 ? linear(direction_x) : 0),
                    by_direction ? -static_cast<float>(reproducible::cos(static_cast<double>(angle)))
                                 : (axis_bits & 2 ? -linear(direction_y) : 0)};
  }
  active_ = true;
  say_state();
}

void OpenFfBoard::set_condition(Effect& effect, std::span<const std::byte> report) const {
  const std::size_t axis = std::min<std::size_t>(static_cast<std::size_t>(axes_), byte_at(report, 2));
  if (axis >= 2) return;  // the firmware writes past its array; nobody knows what that does
  effect.conditions[axis] = condition_of(report);
  const bool acts = effect.conditions[axis].acts();
  if (axis > 0 && acts) effect.one_condition = false;
  if ((acts || (axis > 0 && effect.one_condition)) && effect.ratio[axis] == 0) effect.ratio[axis] = 1;
}

void OpenFfBoard::operate(std::size_t index, std::span<const std::byte> report, std::int64_t ms) {
  const std::uint8_t operation = byte_at(report, 2);
  if (operation == 3) {
    effects_[index].plays = false;
    return;
  }
  if (operation == 2) stop_all(effects_);
  effects_[index].plays = true;
  effects_[index].started_ms = ms;
}

bool OpenFfBoard::take_feature(std::span<const std::byte> report) {
  if (report.size() < 2 || report[0] != std::byte{kCreate}) return false;
  const auto free = std::find_if(effects_.begin(), effects_.end(), [](const Effect& effect) { return effect.type == 0; });
  const std::uint8_t type = byte_at(report, 1);
  if (created_++ == options_.block_load_error_at) {
    load_status_ = 3;
  } else if (free == effects_.end() || type == 0 || type > 12) {
    load_status_ = 2;
  } else {
    *free = {};
    free->type = type;
    loaded_ = static_cast<std::uint8_t>(free - effects_.begin() + 1);
    load_status_ = 1;
    say_state();
  }
  return true;
}

std::vector<std::byte> OpenFfBoard::answer(std::uint8_t id) {
  if (id == kLoad) return bytes_of({kLoad, loaded_, load_status_, 0, 0});
  if (id == kPool) return bytes_of({kPool, 0, 0, static_cast<int>(effects_.size()), 1});
  return {};
}

int OpenFfBoard::end_effects(std::int64_t ms) {
  now_ms_ = ms;
  return end_over(effects_, ms, kInfinite);
}

glm::dvec3 OpenFfBoard::force(const glm::dvec3& share, const glm::dvec3& slope) const {
  glm::dvec3 sum{0};
  if (!active_) return sum;
  for (const Effect& effect : effects_) {
    for (int axis = 0; effect.plays && axis < axes_; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      std::int32_t torque = 0;
      if (effect.type == kConstant)
        torque = static_cast<std::int32_t>(static_cast<float>(-magnitude(effect) * effect.gain / 255) * effect.ratio[at]);
      if (effect.type == kSpring) torque = -spring(effect, at, share[axis], slope[axis]);
      sum[axis] += torque * gain_ / 255;
    }
  }
  for (int axis = 0; axis < 3; ++axis) sum[axis] = std::clamp<double>(sum[axis], -kMost, kMost) / kMost;
  return sum;
}

/// An effect without an end has no envelope.
std::int32_t OpenFfBoard::magnitude(const Effect& effect) const {
  if (effect.duration_ms == kInfinite) return effect.magnitude;
  const Envelope& envelope = effect.envelope;
  const std::int64_t elapsed_ms = now_ms_ - effect.started_ms;
  const std::int64_t left_ms = std::max<std::int64_t>(0, effect.duration_ms - elapsed_ms);
  std::int64_t size = effect.magnitude < 0 ? -effect.magnitude : effect.magnitude;
  if (elapsed_ms < envelope.attack_ms)
    size = (size - envelope.attack_level) * elapsed_ms / envelope.attack_ms + envelope.attack_level;
  if (left_ms < envelope.fade_ms) size = (size - envelope.fade_level) * left_ms / envelope.fade_ms + envelope.fade_level;
  return static_cast<std::int32_t>(effect.magnitude < 0 ? -size : size);
}

std::int32_t OpenFfBoard::spring(const Effect& effect, std::size_t axis, double position, double slope) const {
  const ConditionCounts& condition = effect.conditions[effect.one_condition ? 0 : axis];
  const double counts = position * kMost;
  const double from_center = counts - condition.center;
  if ((from_center < 0 ? -from_center : from_center) <= condition.dead_band) return 0;
  const double coefficient = from_center > 0 ? condition.positive : condition.negative;
  const double past = from_center - (from_center < 0 ? -1 : 1) * static_cast<double>(condition.dead_band);
  const double force = coefficient / kMost * (slope > 0 ? slope : kOwnSlope) * past;
  const double within = std::clamp<double>(force, -condition.negative_saturation, condition.positive_saturation);
  return static_cast<std::int32_t>(within * static_cast<double>(effect.ratio[axis]));
}

}  // namespace

std::unique_ptr<Firmware> openffboard(int axes, const FirmwareOptions& options) {
  return std::make_unique<OpenFfBoard>(axes, options);
}

}  // namespace evenstep::internal
