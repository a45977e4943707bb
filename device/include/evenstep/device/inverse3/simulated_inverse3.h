#pragma once
/// A Haply Inverse Service with one Inverse3, in software, and the link to it. It is a second reading of what the service
/// says, taken from other clients than the driver's was (docs/devices/inverse3.md); no code of the driver's is used.
///
/// In every device tick the link sends what is due and the service answers; a force that is posted is also sent at once.
/// Positions and forces are printed as single-precision numbers, as the service does. A force stays until another one comes
/// or the connection ends: nothing public says how soon the service lets go by itself.
///
/// Faults (simulated_reports.h): `lost`, `late`, `duplicated` answers; `cut` and `longer` texts; `unknown_id`: of another
/// device; `unread`: the program reads nothing. The service ignores what it does not understand and says nothing of it, so
/// `write_lost`, `write_rejected` and `write_refused` are the same: a message that does nothing. At `unplug_at_tick` the
/// connection is closed; a device that returns is the same one, behind a new connection.

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/device/hid/simulated_reports.h"
#include "evenstep/device/inverse3/inverse3_link.h"
#include "evenstep/device/motion.h"

namespace evenstep {

struct SimulatedInverse3Options {
  SimulatedDeviceOptions reports;
  std::string device_id = "049D";
  glm::dvec3 origin_m{0};                   ///< where the hand's position 0 is, as the service counts
  Duration hold{100'000'000};               ///< of the link
  bool in_use = false;                      ///< another program has the device
  std::optional<RealTime> uncalibrated_at;  ///< from then on it is not calibrated, and its positions are nonsense
};

class SimulatedInverse3 final : public Inverse3Link, public SimulatedMotors {
 public:
  SimulatedInverse3(const Clock& clock, HeldBy by, SimulatedInverse3Options options);

  Read read(std::string& text) override;
  void post(std::string text) override;
  void rest(std::string text) override;
  const std::string& first_message() const override { return first_message_; }
  const std::string& name() const override { return options_.reports.name; }
  MotorState motors() override;

 private:
  bool is_gone();
  void answer_until(RealTime now);
  void begin_anew();
  void say_first(RealTime at);
  std::optional<glm::dvec3> asked_N(const std::string& message) const;
  void hear(RealTime at, const std::string& message);
  std::string told(const SimulatedReport& report) const;

  const Clock& clock_;
  SimulatedReports reports_;
  SimulatedInverse3Options options_;
  Inverse3Outbox outbox_;
  MotorLog motors_;
  std::string first_message_;
  glm::dvec3 force_N_{0};
  std::optional<SimulatedReport> newest_;  // that nobody has read yet
  std::int64_t next_tick_ = 0;
  bool has_returned_ = false;  // and no read has said so
};

}  // namespace evenstep
