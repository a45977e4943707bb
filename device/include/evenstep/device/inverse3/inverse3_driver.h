#pragma once
/// A Haply Inverse3 through the service of its maker: positions in metres, forces in newtons, three axes.
/// docs/devices/inverse3.md says what is sent when, and which public clients say what a field means.
///
/// Its axes are the service's: by default X to the right, Y away from the user, Z up. Position 0 is where `origin_m` says.
/// From the driver's construction on the link sends a zero force to this device, because the service says nothing unasked;
/// other forces follow after start().

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/inverse3/inverse3_link.h"
#include "evenstep/device/inverse3/inverse3_messages.h"

namespace evenstep {

struct Inverse3Options {
  std::string device_id;             ///< empty: the only one
  glm::dvec3 origin_m{0};            ///< position 0, as the service counts
  bool shared = false;               ///< take the device even if the service says that it is in use
  Duration silence{10'000'000'000};  ///< the run ends after this long without a position
};

struct Inverse3Counters {
  std::int64_t absent = 0;        ///< messages without our device
  std::int64_t uncalibrated = 0;  ///< messages with it, but not calibrated
};

class Inverse3Driver final : public HapticDevice {
 public:
  /// The link must outlive the driver. Throws DeviceError if the first message of the service cannot be read, has no such
  /// device, or says that another program uses it.
  Inverse3Driver(Inverse3Link& link, const Inverse3Options& options);
  ~Inverse3Driver() override;
  Inverse3Driver(const Inverse3Driver&) = delete;
  Inverse3Driver& operator=(const Inverse3Driver&) = delete;

  void start() override;
  void stop() noexcept override;
  /// A sample is `drivable` while the device is calibrated, and fresh if a message with its position has come. While the
  /// link looks for a service that is away a sample is neither, and nothing is posted. A service that returns must have the
  /// same device, not used by another program, and the sample of that tick is not drivable either. Throws DeviceError when
  /// the connection has ended for ever, or brought no position for `silence`.
  DeviceSample read(RealTime now) override;
  /// Throws DeviceError before start() and after stop().
  void write(const glm::dvec3& force_N) override;
  const DeviceCounters& counters() const override { return counters_; }
  const Inverse3Counters& inverse3_counters() const { return inverse3_counters_; }
  std::map<std::string, std::int64_t> own_counters() const override;

 private:
  Inverse3State choose() const;
  void begin();
  void take(RealTime now);
  void come_back(RealTime now);
  std::string objection() const;
  [[noreturn]] void fail(const std::string& what) const;

  Inverse3Link& link_;
  Inverse3Options options_;
  std::string device_id_, text_;
  DeviceCounters counters_;
  Inverse3Counters inverse3_counters_;
  DeviceSample last_;
  std::optional<RealTime> heard_at_;  // the last position; at first the first read
  bool started_ = false, is_away_ = false, is_returning_ = false;
};

}  // namespace evenstep
