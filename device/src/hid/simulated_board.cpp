#include "evenstep/device/hid/simulated_board.h"

#include <algorithm>
#include <utility>

#include "../effect_springs.h"
#include "boards/firmware.h"

namespace evenstep {
namespace {

constexpr std::uint64_t kStateReport = 0x100;  // above the byte of a state report

using Quirks = internal::StrictQuirks;

/// How the boards that were only described differ from a strict reading.
Quirks quirks_of(BoardKind kind) {
  switch (kind) {
    case BoardKind::openffboard_1:
    case BoardKind::openffboard_2:
    case BoardKind::arduino:
      break;
    case BoardKind::silent_pool:
      return {.silent_pool = true};
    case BoardKind::short_replies:
      return {.short_replies = true};
    case BoardKind::vrs:
      return {.motors = 1, .direction = false, .block_offset = false, .control = Quirks::Control::mask_from_0};
    case BoardKind::asetek:
      return {.motors = 1, .block_offset = false, .negative_side = false};
    case BoardKind::moza:
      return {.motors = 1, .endless = false, .springs_turn = true};
    case BoardKind::pxn:
      return {.motors = 1, .springs = false};
    case BoardKind::fixed_direction:
      return {.motors = 1, .axes_enable = false, .obeys_direction = false};
    case BoardKind::two_commands:
      return {.control = Quirks::Control::two_from_0};
    case BoardKind::late_load:
      return {.pool_count = false, .load = Quirks::Load::late};
    case BoardKind::no_duration:
      return {.duration = false};
    case BoardKind::load_error_first:
      return {.load = Quirks::Load::error_first};
    case BoardKind::load_never:
      return {.load = Quirks::Load::never};
    case BoardKind::load_always_1:
      return {.load = Quirks::Load::always_1};
  }
  return {};
}

std::unique_ptr<internal::Firmware> firmware_of(const SimulatedBoardOptions& options) {
  const internal::FirmwareOptions own{options.pool_effects, options.block_load_error_at, options.for_linux_6_1};
  if (options.kind == BoardKind::openffboard_1) return internal::openffboard(1, own);
  if (options.kind == BoardKind::openffboard_2) return internal::openffboard(2, own);
  if (options.kind == BoardKind::arduino) return internal::arduino_joystick(own);
  return internal::strict_board(quirks_of(options.kind), own);
}

std::int64_t whole_ms(RealTime at) { return floor_mul_div(at.ns, 1, 1'000'000); }

}  // namespace

const std::vector<NamedBoard>& simulated_boards() {
  static const std::vector<NamedBoard> boards{{"openffboard-1", BoardKind::openffboard_1},
                                              {"openffboard-2", BoardKind::openffboard_2},
                                              {"arduino", BoardKind::arduino},
                                              {"silent-pool", BoardKind::silent_pool},
                                              {"short-replies", BoardKind::short_replies},
                                              {"vrs", BoardKind::vrs},
                                              {"asetek", BoardKind::asetek},
                                              {"moza", BoardKind::moza},
                                              {"pxn", BoardKind::pxn},
                                              {"fixed-direction", BoardKind::fixed_direction},
                                              {"two-commands", BoardKind::two_commands},
                                              {"late-load", BoardKind::late_load},
                                              {"no-duration", BoardKind::no_duration},
                                              {"load-error-first", BoardKind::load_error_first},
                                              {"load-never", BoardKind::load_never},
                                              {"load-always-1", BoardKind::load_always_1}};
  return boards;
}

int motors_of(BoardKind kind) { return kind == BoardKind::openffboard_1 ? 1 : quirks_of(kind).motors; }

SimulatedBoard::SimulatedBoard(const Clock& clock, HeldBy by, SimulatedBoardOptions options)
    : clock_(clock),
      reports_(std::move(by), options.reports),
      options_(std::move(options)),
      firmware_(firmware_of(options_)),
      descriptor_(firmware_->report_descriptor()),
      info_(firmware_->info()) {
  info_.path = options_.reports.name;
}

SimulatedBoard::~SimulatedBoard() = default;

/// Carries out everything that has happened since the last call, in order of time.
void SimulatedBoard::catch_up() {
  const RealTime now = clock_.now();
  while (!reports_.is_gone()) {
    std::optional<RealTime> next;
    if (firmware_->playing() > 0) next = tick_time(options_.firmware_rate, next_firmware_tick_, options_.reports.first_tick);
    const bool event = next_event_ < options_.events.size() && (!next || options_.events[next_event_].at <= *next);
    if (event) next = options_.events[next_event_].at;
    if (!next || *next > now) break;
    reports_.advance(*next);
    if (reports_.is_gone()) return;
    if (event) {
      const PidDeviceEvent& what = options_.events[next_event_++];
      (what.kind == PidDeviceEvent::Kind::safety_switch ? switch_closed_ : has_power_) = what.on;
      firmware_->see_switches(switch_closed_, has_power_);
    } else {
      ++next_firmware_tick_;
      effects_ended_ += firmware_->end_effects(whole_ms(*next));
    }
    pass_on_states();
    render(*next);
  }
  reports_.advance(now);
}

void SimulatedBoard::pass_on_states() {
  for (const std::uint8_t state : firmware_->states()) reports_.push(kStateReport | state);
}

glm::dvec3 SimulatedBoard::force_N(RealTime at) {
  glm::dvec3 share{0}, slope{0};
  const glm::dvec3 position_m = reports_.position_m(at);
  for (int axis = 0; axis < 3; ++axis) {
    if (options_.travel_m[axis] <= 0) continue;
    share[axis] = std::clamp(position_m[axis] / (options_.travel_m[axis] / 2), -1.0, 1.0);
    if (options_.full_slope_N_per_m) slope[axis] = internal::full_steepness(options_, axis);
  }
  return switch_closed_ && has_power_ ? firmware_->force(share, slope) * options_.full_scale_N : glm::dvec3(0);
}

void SimulatedBoard::render(RealTime at) {
  const glm::dvec3 force = force_N(at);
  motors_.render(at, force);
  reports_.feel(at, force);
}

MotorState SimulatedBoard::motors() {
  catch_up();
  MotorState state;
  if (!reports_.is_gone()) {
    motors_.until(clock_.now());
    state.force_N = force_N(clock_.now());
    state.effects_playing = firmware_->playing();
    state.effects_allocated = firmware_->allocated();
    state.actuators_enabled = firmware_->actuators_enabled();
  }
  motors_.tell(state);
  state.effects_ended = effects_ended_;
  return state;
}

HidRead SimulatedBoard::read(std::span<std::byte> buffer) {
  catch_up();
  if (reports_.is_gone()) return {HidRead::Status::gone};
  if (reports_.take_interruption()) return {HidRead::Status::interrupted};
  const auto report = reports_.take();
  if (!report) return {HidRead::Status::nothing};
  if (report->other != 0) return deliver(*report, firmware_->state_report(report->other & 0xFF), buffer);
  glm::dvec3 share{0};
  for (int axis = 0; axis < 3; ++axis) {
    if (options_.travel_m[axis] > 0)
      share[axis] = std::clamp(report->position_m[axis] / (options_.travel_m[axis] / 2), -1.0, 1.0);
  }
  return deliver(*report, firmware_->position_report(share), buffer);
}

HidWrite SimulatedBoard::write(std::span<const std::byte> report) {
  catch_up();
  if (reports_.is_gone()) return HidWrite::gone;
  bool lost = false;
  if (reports_.write_fault(lost) == HidWrite::rejected) return HidWrite::rejected;
  if (lost) return HidWrite::ok;
  const bool played = firmware_->playing() > 0;
  if (!firmware_->take_output(report, whole_ms(clock_.now()))) return HidWrite::rejected;
  if (!played)
    next_firmware_tick_ = first_tick_at_or_after(options_.firmware_rate, clock_.now(), options_.reports.first_tick);
  motors_.heard(clock_.now());
  pass_on_states();
  render(clock_.now());
  return HidWrite::ok;
}

HidWrite SimulatedBoard::set_feature(std::span<const std::byte> report) {
  catch_up();
  if (reports_.is_gone()) return HidWrite::gone;
  if (!firmware_->take_feature(report)) return HidWrite::rejected;
  pass_on_states();
  return HidWrite::ok;
}

HidFeature SimulatedBoard::get_feature(std::span<std::byte> report) {
  catch_up();
  if (reports_.is_gone()) return {HidFeature::Status::gone};
  const std::vector<std::byte> answer =
      firmware_->answer(report.empty() ? std::uint8_t{0} : std::to_integer<std::uint8_t>(report[0]));
  if (answer.empty()) return {HidFeature::Status::rejected};
  std::copy_n(answer.begin(), std::min(answer.size(), report.size()), report.begin());
  return {HidFeature::Status::ok, answer.size()};
}

}  // namespace evenstep
