#pragma once
/// The drivers that a [[device]] can name. Each alternative of DriverSpec has
///   kName           the value of [[device]] driver,
///   fields()        the keys that exist only for this driver, as rows of the field table,
///   read()          reads these keys, which have been checked before, into the alternative,
///   knows_newtons() whether its force is known in newtons, so that expectations may be about it.
/// The driver itself is made in harness/src/parts/make_driver.cpp.

#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "evenstep/device/evdev/evdev_driver.h"
#include "evenstep/device/foreign_device.h"
#include "evenstep/device/hid/pid_driver.h"
#include "evenstep/device/hid/simulated_board.h"
#include "evenstep/device/hid/simulated_pid_device.h"
#include "evenstep/device/inverse3/inverse3_driver.h"
#include "evenstep/format/foreign.h"

namespace evenstep {

namespace internal {
class Table;
struct Field;
struct ScenarioReading;
}  // namespace internal

/// driver = "reference": docs/devices/reference-device.md. It has no keys of its own.
struct ReferenceSpec {
  static constexpr std::string_view kName = "reference";
  static std::vector<internal::Field> fields();
  static ReferenceSpec read(const internal::ScenarioReading& reading, const internal::Table& device);
  bool knows_newtons() const { return true; }
};

/// driver = "pid": a force-feedback device of the PID class, and its simulated device.
struct PidSpec {
  static constexpr std::string_view kName = "pid";
  /// Why a device of this driver cannot return after it was unplugged.
  static constexpr std::string_view kNoReturn =
      "renders no force to a device that was plugged in again, because its effects are lost and cannot be made anew in a "
      "tick";
  static std::vector<internal::Field> fields();
  static PidSpec read(const internal::ScenarioReading& reading, const internal::Table& device);
  bool knows_newtons() const { return options.full_scale_N.has_value(); }

  PidOptions options;
  PidFlavour flavour = PidFlavour::mask;
  std::optional<BoardKind> board;  ///< of the simulated device; empty: evenstep's own, with the flavour
  int pool_effects = 40;
  int block_load_error_at = -1;  ///< counted from 0
  Rate firmware_rate{4000, 1};   ///< at which it renders springs by itself
  std::vector<PidDeviceEvent> events;
};

/// driver = "evdev": a force-feedback device through Linux' own driver for it, and its simulated device.
struct EvdevSpec {
  static constexpr std::string_view kName = "evdev";
  static std::vector<internal::Field> fields();
  static EvdevSpec read(const internal::ScenarioReading& reading, const internal::Table& device);
  bool knows_newtons() const { return options.full_scale_N.has_value(); }

  EvdevOptions options;                     ///< without unchanged_age, which unchanged_age_of() gives
  Rate firmware_rate{4000, 1};              ///< at which it renders springs by itself
  std::optional<Duration> report_interval;  ///< the longest between two reports; empty: two periods of the device's rate
  int effects = 16;                         ///< this and the next three are of the simulated device
  int foreign_effects = 0;
  bool held = false;
  std::optional<RealTime> meddled_at;
};

/// driver = "inverse3": a Haply Inverse3 through its maker's service, and a simulated service.
struct Inverse3Spec {
  static constexpr std::string_view kName = "inverse3";
  static std::vector<internal::Field> fields();
  static Inverse3Spec read(const internal::ScenarioReading& reading, const internal::Table& device);
  bool knows_newtons() const { return true; }

  Inverse3Options options;
  Rate update_rate{2000, 1};  ///< this and the next two are of the connection
  Duration hold;
  bool remote = false;
  bool in_use = false;  ///< this and the next are of the simulated service
  std::optional<RealTime> uncalibrated_at;
};

/// driver = "foreign": registered by the program that runs the scenario.
struct ForeignDriverSpec {
  static constexpr std::string_view kName = "foreign";
  static std::vector<internal::Field> fields();
  static ForeignDriverSpec read(const internal::ScenarioReading& reading, const internal::Table& device);
  bool knows_newtons() const { return true; }

  Foreign part;
  DeviceFactory make;
};

using DriverSpec = std::variant<ReferenceSpec, PidSpec, EvdevSpec, Inverse3Spec, ForeignDriverSpec>;
inline bool knows_newtons(const DriverSpec& driver) {
  return std::visit([](const auto& spec) { return spec.knows_newtons(); }, driver);
}

/// The springs that devices of a driver render by themselves.
struct OwnSprings {
  std::optional<double> steepest_N_per_m;  ///< empty: the force is not known in newtons
  Rate firmware_rate;
};
/// Empty: the driver has none.
std::optional<OwnSprings> own_springs(const DriverSpec& driver);

}  // namespace evenstep
