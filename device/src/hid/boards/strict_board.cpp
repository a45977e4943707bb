// A firmware that follows the standard to the letter, except for its quirks: those of boards that drivers stumbled over.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "evenstep/time/reproducible_math.h"
#include "firmware.h"

namespace evenstep::internal {
namespace {

enum Id : std::uint8_t {
  kState = 3,
  kSetEffect = 0x31,
  kSetCondition = 0x32,
  kConstantForce = 0x33,
  kOperation = 0x34,
  kBlockFree = 0x35,
  kControl = 0x36,
  kGain = 0x37,
  kEnvelope = 0x38,
  kCreate = 0x41,
  kLoad = 0x42,
  kPool = 0x43
};
constexpr std::uint8_t kConstant = 1, kSpring = 8;
constexpr int kInfinite = 0xFFFF;
constexpr double kMost = 32'767, kPi = 3.14159265358979323846;

/// Takes the values of a report apart one after the other; 0 beyond its end.
class Reading {
 public:
  explicit Reading(std::span<const std::byte> report) : report_(report) {}
  std::uint8_t byte() { return at_ < report_.size() ? byte_at(report_, at_++) : over(); }
  std::uint16_t word() {
    const std::uint8_t low = byte();
    return static_cast<std::uint16_t>(low | byte() << 8);
  }
  double share() { return static_cast<std::int16_t>(word()) / kMost; }
  bool is_whole() const { return whole_; }

 private:
  std::uint8_t over() { return whole_ = false, std::uint8_t{0}; }
  std::span<const std::byte> report_;
  std::size_t at_ = 2;  // after its id and the block
  bool whole_ = true;
};

struct Condition {
  double center = 0, positive = 0, negative = 0, positive_saturation = 0, negative_saturation = 0, dead_band = 0;
  bool was_set = false;
};

struct Effect {
  bool allocated = false, plays = false;
  std::uint8_t type = 0;
  double gain = 1, magnitude = 0;
  std::array<double, 2> towards{};  // the direction, along X and Y
  std::array<bool, 2> enabled{};    // by axis bits; count only without a direction
  bool by_direction = false;
  int duration_ms = kInfinite;
  std::int64_t started_ms = 0;
  std::array<Condition, 2> conditions;
};

class StrictBoard final : public Firmware {
  using Control = StrictQuirks::Control;
  using Load = StrictQuirks::Load;

 public:
  StrictBoard(StrictQuirks quirks, const FirmwareOptions& options)
      : quirks_(quirks), options_(options), effects_(static_cast<std::size_t>(std::min(16, options.pool_effects))) {}

  HidDeviceInfo info() const override { return {"", 0x1209, 0x0E59, "evenstep strict board", "simulated"}; }
  std::vector<std::byte> report_descriptor() const override;
  bool take_output(std::span<const std::byte> report, std::int64_t ms) override;
  bool take_feature(std::span<const std::byte> report) override;
  std::vector<std::byte> answer(std::uint8_t id) override;
  std::vector<std::byte> answer_load();
  std::vector<std::byte> position_report(const glm::dvec3& share) const override;
  std::vector<std::uint8_t> states() override { return std::exchange(states_, {}); }
  std::vector<std::byte> state_report(std::uint8_t state) const override { return bytes_of({kState, state}); }
  void see_switches(bool safety_switch, bool actuator_power) override {
    switch_closed_ = safety_switch;
    has_power_ = actuator_power;
    say_state();
  }

  int end_effects(std::int64_t ms) override;
  glm::dvec3 force(const glm::dvec3& share, const glm::dvec3& slope) const override;
  int playing() const override { return count_playing(effects_); }
  int allocated() const override {
    return count(effects_, [](const Effect& effect) { return effect.allocated; });
  }
  bool actuators_enabled() const override { return enabled_; }

 private:
  void say_state() {
    states_.push_back(static_cast<std::uint8_t>((paused_ ? 1 : 0) | (enabled_ ? 2 : 0) | (switch_closed_ ? 4 : 0) |
                                                (has_power_ ? 8 : 0) | (playing() > 0 ? 16 : 0)));
  }
  void set_effect(Effect& effect, Reading report) const;
  void set_condition(Effect& effect, Reading report) const;
  void operate(Effect& effect, std::span<const std::byte> report, std::int64_t ms);
  void take_control(std::span<const std::byte> report);
  void control(int command);
  double along(const Effect& effect, std::size_t axis, const glm::dvec3& share, const glm::dvec3& slope) const;
  double spring(const Effect& effect, std::size_t axis, const glm::dvec3& share, const glm::dvec3& slope) const;

  StrictQuirks quirks_;
  FirmwareOptions options_;
  std::vector<Effect> effects_;
  std::vector<std::uint8_t> states_;
  bool enabled_ = false, paused_ = false, switch_closed_ = true, has_power_ = true;
  double gain_ = 1;
  int created_ = 0, asked_ = 0;  // for an effect's block, since its creation
  std::uint8_t loaded_ = 0, loaded_before_ = 0, load_status_ = 0;
};

std::vector<std::byte> StrictBoard::report_descriptor() const {
  BoardItems at;
  at.joystick(8, 2);
  at.states(kState);

  at.block_report(0x21, kSetEffect);
  at.effect_type();
  if (quirks_.duration) {
    at.unit(0x1001, 0x0D);
    at.outputs({0x50}, 16, 0, 32'767);
    at.unit(0, 0);
  }
  at.outputs({0x52}, 8, 0, 255);
  if (quirks_.axes_enable) at.axes_enable(quirks_.motors);
  if (!quirks_.axes_enable && options_.for_linux_6_1) at.direction_enable(0);
  if (quirks_.direction) at.per_axis(0x57, quirks_.motors, 16, 36'000);
  if (options_.for_linux_6_1) {
    at.outputs({0x53}, 8, 0, 255);
    at.unit(0x1001, 0x0D);
    at.outputs({0x54, 0xA7}, 16, 0, 32'767);
    at.unit(0, 0);
  }
  at.close();
  if (options_.for_linux_6_1) at.envelope(kEnvelope, 32'767);

  at.block_report(0x5F, kSetCondition);
  if (quirks_.block_offset) {
    at.outputs({0x23}, 8, 0, 1);
  } else {
    at.per_axis(0x58, 2, 2, 3);
    at.output_padding(4);
  }
  at.outputs({0x60, 0x61}, 16, -32'767, 32'767);
  if (quirks_.negative_side) at.outputs({0x62}, 16, -32'767, 32'767);
  at.outputs({0x63}, 16, 0, 32'767);
  if (quirks_.negative_side) at.outputs({0x64, 0x65}, 16, 0, 32'767);
  at.close();

  at.constant_force(kConstantForce, 32'767);
  at.operation(kOperation);
  at.block_free(kBlockFree);
  if (quirks_.control == Control::array_from_1) at.device_control(kControl);
  if (quirks_.control == Control::two_from_0) at.device_control(kControl, 0, 2);
  if (quirks_.control == Control::mask_from_0) at.device_control_mask(kControl);
  at.gain(kGain);
  at.create_effect(kCreate);
  at.block_load(kLoad);
  at.pool(kPool, quirks_.pool_count);
  at.close();
  return std::move(at.bytes);
}

std::vector<std::byte> StrictBoard::position_report(const glm::dvec3& share) const { return joystick_report(2, share, 2); }

bool StrictBoard::take_output(std::span<const std::byte> report, std::int64_t ms) {
  if (report.size() < 2) return false;
  const std::size_t index = byte_at(report, 1);
  if (report[0] == std::byte{kControl}) return take_control(report), true;
  if (report[0] == std::byte{kGain}) return gain_ = byte_at(report, 1) / 255.0, true;
  if (index == 0 || index > effects_.size() || !effects_[index - 1].allocated) return true;
  Effect& effect = effects_[index - 1];
  switch (byte_at(report, 0)) {
    case kSetEffect:
      set_effect(effect, Reading(report));
      return true;
    case kSetCondition:
      set_condition(effect, Reading(report));
      return true;
    case kConstantForce:
      if (report.size() >= 4) effect.magnitude = signed_at(report, 2) / kMost;
      return true;
    case kOperation:
      if (report.size() >= 4) operate(effect, report, ms);
      return true;
    case kBlockFree:
      effect = {};
      return true;
    case kEnvelope:
      return options_.for_linux_6_1;
    default:
      return false;
  }
}

void StrictBoard::set_effect(Effect& effect, Reading report) const {
  Effect set = effect;
  set.type = report.byte();
  if (quirks_.duration) set.duration_ms = report.word();
  set.gain = report.byte() / 255.0;
  const std::uint8_t bits = quirks_.axes_enable || options_.for_linux_6_1 ? report.byte() : std::uint8_t{0};
  set.enabled = {quirks_.axes_enable && (bits & 1) != 0, quirks_.motors > 1 && (bits & 2) != 0};
  set.by_direction = !quirks_.axes_enable || (bits >> quirks_.motors & 1) != 0;
  // Clockwise from north, which is the far end of Y and its lowest position. Without a direction it comes from the right.
  const double turn = quirks_.direction ? report.word() / 36'000.0 : 0.25;
  const double angle = (quirks_.obeys_direction ? turn : 0.25) * 2 * kPi;
  set.towards = {reproducible::sin(angle), quirks_.motors > 1 ? -reproducible::cos(angle) : 0};
  if (report.is_whole()) effect = set;
}

void StrictBoard::set_condition(Effect& effect, Reading report) const {
  const std::uint8_t offset = report.byte();
  const std::size_t block = quirks_.block_offset ? offset : 0;
  Condition set;
  set.was_set = true;
  set.center = report.share();
  set.positive = set.negative = report.share();
  if (quirks_.negative_side) set.negative = report.share();
  set.positive_saturation = set.negative_saturation = report.share();
  if (quirks_.negative_side) {
    set.negative_saturation = report.share();
    set.dead_band = report.share();
  }
  if (report.is_whole() && block < effect.conditions.size()) effect.conditions[block] = set;
}

void StrictBoard::operate(Effect& effect, std::span<const std::byte> report, std::int64_t ms) {
  const std::uint8_t operation = byte_at(report, 2);
  if (operation == 2) stop_all(effects_);
  effect.plays = operation != 3;
  effect.started_ms = ms;
  say_state();
}

/// A bit for each command, or one or two that are carried out one after the other.
void StrictBoard::take_control(std::span<const std::byte> report) {
  const int least = quirks_.control == Control::two_from_0 ? 0 : 1;
  for (int command = 1; quirks_.control == Control::mask_from_0 && command <= 6; ++command) {
    if ((byte_at(report, 1) >> (command - 1) & 1) != 0) control(command);
  }
  if (quirks_.control == Control::mask_from_0) return;
  const std::size_t elements = quirks_.control == Control::two_from_0 ? 2 : 1;
  for (std::size_t i = 1; i <= elements && i < report.size(); ++i) control(byte_at(report, i) + 1 - least);
}

void StrictBoard::control(int command) {
  if (command == 1) enabled_ = true;
  if (command == 2) enabled_ = false;
  if (command == 3) stop_all(effects_);
  if (command == 4) {
    std::fill(effects_.begin(), effects_.end(), Effect{});
    enabled_ = true;
    paused_ = false;
    gain_ = 1;
  }
  if (command == 5) paused_ = true;
  if (command == 6) paused_ = false;
  say_state();
}

bool StrictBoard::take_feature(std::span<const std::byte> report) {
  if (report.size() < 2 || report[0] != std::byte{kCreate}) return false;
  const auto free = std::find_if(effects_.begin(), effects_.end(), [](const Effect& effect) { return !effect.allocated; });
  loaded_before_ = std::exchange(loaded_, std::uint8_t{0});
  asked_ = 0;
  if (created_++ == options_.block_load_error_at) {
    load_status_ = 3;
  } else if (free == effects_.end()) {
    load_status_ = 2;
  } else {
    *free = {};
    free->allocated = true;
    loaded_ = static_cast<std::uint8_t>(free - effects_.begin() + 1);
    load_status_ = 1;
  }
  return true;
}

std::vector<std::byte> StrictBoard::answer(std::uint8_t id) {
  std::vector<std::byte> bytes;
  if (id == kLoad) bytes = answer_load();
  if (id == kPool && !quirks_.silent_pool)
    bytes = quirks_.pool_count ? bytes_of({kPool, 0, 0x10, 16, 1}) : bytes_of({kPool, 0, 0x10, 1});
  if (quirks_.short_replies && !bytes.empty()) bytes.pop_back();
  return bytes;
}

/// `late`: nothing, then the answer to the request before, and then its own.
std::vector<std::byte> StrictBoard::answer_load() {
  const int asked = asked_++;
  if (quirks_.load == Load::never) return {};
  const bool stale = quirks_.load == Load::late && asked == 1 && loaded_before_ != 0;
  int block = stale ? loaded_before_ : loaded_, status = stale ? 1 : load_status_;
  if (quirks_.load == Load::late && asked < 3 && !stale) block = status = 0;
  if (quirks_.load == Load::error_first && asked == 0) block = 0, status = 3;
  if (quirks_.load == Load::always_1 && block != 0) block = 1;
  return bytes_of({kLoad, block, status, 0xFF, 0xFF});
}

int StrictBoard::end_effects(std::int64_t ms) {
  const int endless = quirks_.duration && !quirks_.endless ? -1 : kInfinite;
  const int ended = end_over(effects_, ms + 1, endless);  // to the millisecond
  if (ended > 0) say_state();
  return ended;
}

glm::dvec3 StrictBoard::force(const glm::dvec3& share, const glm::dvec3& slope) const {
  glm::dvec3 sum{0};
  if (!enabled_ || paused_) return sum;
  for (const Effect& effect : effects_) {
    for (std::size_t axis = 0; effect.plays && axis < 2; ++axis)
      sum[static_cast<int>(axis)] += effect.gain * along(effect, axis, share, slope);
  }
  for (int axis = 0; axis < 3; ++axis) sum[axis] = std::clamp(sum[axis], -1.0, 1.0) * gain_;
  return sum;
}

/// Without a direction, X is as if from the right: Linux sends the same magnitude then.
double StrictBoard::along(const Effect& effect, std::size_t axis, const glm::dvec3& share, const glm::dvec3& slope) const {
  if (effect.type == kConstant) {
    const bool by_direction = effect.by_direction || (!quirks_.direction && effect.enabled[0]);
    return effect.magnitude * (by_direction ? -effect.towards[axis] : effect.enabled[axis] ? 1.0 : 0.0);
  }
  return effect.type == kSpring && quirks_.springs ? spring(effect, axis, share, slope) : 0;
}

/// Several blocks act by axis and are not rotated; a single one acts along the direction, along which it has its own sign
/// unless springs turn.
double StrictBoard::spring(const Effect& effect, std::size_t axis, const glm::dvec3& share, const glm::dvec3& slope) const {
  const bool by_axis = quirks_.motors == 1 || effect.conditions[1].was_set || !effect.by_direction;
  const Condition& condition = effect.conditions[by_axis ? axis : 0];
  const double x = share.x, y = share.y;
  const double position = by_axis ? share[static_cast<int>(axis)] : x * effect.towards[0] + y * effect.towards[1];
  if (by_axis && !effect.by_direction && !effect.enabled[axis]) return 0;
  const double from_center = position - condition.center;
  if (std::abs(from_center) <= condition.dead_band) return 0;
  const double past = from_center - (from_center < 0 ? -condition.dead_band : condition.dead_band);
  const double steepness = slope[static_cast<int>(axis)] > 0 ? slope[static_cast<int>(axis)] : 1;
  const double pull = from_center > 0 ? std::min(condition.positive * past * steepness, condition.positive_saturation)
                                      : std::max(condition.negative * past * steepness, -condition.negative_saturation);
  return by_axis && !quirks_.springs_turn ? -pull : -pull * effect.towards[axis];
}

}  // namespace

std::unique_ptr<Firmware> strict_board(StrictQuirks quirks, const FirmwareOptions& options) {
  return std::make_unique<StrictBoard>(quirks, options);
}

}  // namespace evenstep::internal
