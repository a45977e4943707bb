#pragma once
/// What a program may ask of one /dev/input/eventN of Linux: events, axes, and force feedback effects (linux/input.h). The
/// driver lies above this interface; below it are the kernel (evdev_file.h, in a live run live_evdev.h) and a simulated
/// device.
///
/// Calls that return int give 0, or the errno of the system call: ENODEV after the device was unplugged, for every call.
/// Numbers of types, codes and effects are those of linux/input-event-codes.h and linux/input.h.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

namespace evdev {
inline constexpr std::uint16_t kSyn = 0x00, kAbs = 0x03, kFf = 0x15;  // types of events
inline constexpr std::uint16_t kSynReport = 0, kSynDropped = 3;       // codes of kSyn
inline constexpr std::uint16_t kSpring = 0x53, kConstant = 0x52;      // types of effects
inline constexpr std::uint16_t kGain = 0x60, kAutocenter = 0x61;      // codes of kFf beside effects' numbers
inline constexpr int kFullGain = 0xFFFF, kLargestLevel = 0x7FFF, kLargestSaturation = 0xFFFF;
inline constexpr std::uint16_t kDown = 0x0000, kLeft = 0x4000, kUp = 0x8000;  // directions, in 65536ths of a turn
inline constexpr std::int64_t kLongestEffect_ms = 0x7FFF;
}  // namespace evdev

struct EvdevEvent {
  std::uint16_t type = 0, code = 0;
  std::int32_t value = 0;
  /// When the kernel got it, if the node tells times: an EvdevFile by CLOCK_MONOTONIC, all others by the clock of the run.
  RealTime at = {};
};

struct EvdevRead {
  /// `away`: the device was unplugged, and is looked for. `returned`: once after that; its axes must be asked for anew, and
  /// its effects are there again, without force and not playing.
  enum class Status { events, nothing, interrupted, away, returned, gone } status = Status::nothing;
  std::size_t count = 0;
};

/// struct input_absinfo, as far as it is used.
struct EvdevAxis {
  std::int32_t value = 0, minimum = 0, maximum = 0;
  std::int32_t fuzz = 0;  ///< the kernel smooths changes smaller than twice this
  std::int32_t flat = 0, resolution = 0;
};

/// struct ff_condition_effect.
struct EvdevCondition {
  std::uint16_t right_saturation = 0, left_saturation = 0;
  std::int16_t right_coefficient = 0, left_coefficient = 0;
  std::uint16_t dead_band = 0;
  std::int16_t center = 0;
  bool operator==(const EvdevCondition&) const = default;
};

/// struct ff_effect, for constant forces and springs.
struct EvdevEffect {
  std::uint16_t type = evdev::kConstant;
  std::int16_t id = -1;                        ///< -1: a new effect, which is given its number by upload()
  std::uint16_t direction = 0;                 ///< where the force points to: 0 down (towards the user), 0x4000 left
  std::uint16_t length_ms = 0;                 ///< 0: plays until it is stopped
  std::int16_t level = 0;                      ///< of a constant force
  std::array<EvdevCondition, 2> conditions{};  ///< of a spring: along X, along Y
  bool operator==(const EvdevEffect&) const = default;
};

struct EvdevInfo {
  std::string path;
  std::string name;
  std::uint16_t vendor_id = 0, product_id = 0;
  std::string serial;
};

class EvdevNode {
 public:
  virtual ~EvdevNode() = default;
  /// Takes events that are waiting, without waiting itself.
  virtual EvdevRead read(std::span<EvdevEvent> events) = 0;
  /// Whether its events say when the kernel got them. False: their times are by a clock that nothing here uses.
  virtual bool tells_times() const { return true; }
  /// Plays (value > 0) or stops (0) the effect `code`, or sets evdev::kGain or kAutocenter. The kernel does not say that an
  /// effect is not there.
  virtual int write(const EvdevEvent& event) = 0;
  /// Uploads a new effect, or changes one that was uploaded through this node. ENOSPC: the device has no room. EINVAL: there
  /// is no such effect, or it is of another type. EACCES: it is another program's.
  virtual int upload(EvdevEffect& effect) = 0;
  /// What has become of the last upload that changed the effect: if a separate thread sends it, upload() cannot tell.
  enum class Upload { waits, taken, refused };
  virtual Upload uploaded(int /*id*/) { return Upload::taken; }
  /// Stops an effect and frees its place. EINVAL and EACCES as above.
  virtual int erase(int id) = 0;
  /// From now on events come to nobody else. EBUSY: another program has them for itself. (Its own writes still reach the
  /// device.)
  virtual int grab() = 0;
  /// How many effects the device has room for, of all programs together.
  virtual int effect_count(int& count) = 0;
  /// Whether it has the absolute axis (0: X, 1: Y, 2: Z), and whether it can play the effect or set the gain.
  virtual bool has_axis(std::uint16_t code) = 0;
  virtual bool has_feedback(std::uint16_t code) = 0;
  /// EAGAIN: not now, ask again.
  virtual int axis(std::uint16_t code, EvdevAxis& axis) = 0;
  virtual int set_axis(std::uint16_t code, const EvdevAxis& axis) = 0;
  virtual const EvdevInfo& info() const = 0;
};

}  // namespace evenstep
