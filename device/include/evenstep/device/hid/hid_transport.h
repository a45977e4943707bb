#pragma once
/// The bytes to and from one HID device. Drivers lie above this interface; below it are the transports, hidapi (wall clock
/// only) and simulated devices. Byte 0 of every report is its id, which is 0 if the device does not number its reports. (But
/// input reports of such a device have no id byte at all, just as hidapi delivers them.)

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace evenstep {

struct HidDeviceInfo {
  std::string path;
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::string product;
  std::string serial;
};

struct HidRead {
  /// `away`: the device was unplugged, and is looked for. `returned`: once after that; it has lost what it was told before,
  /// and its counters begin anew.
  enum class Status { report, nothing, interrupted, away, returned, gone } status = Status::nothing;
  std::size_t size = 0;  ///< bytes of the report; if the buffer is smaller, the report was cut
};
enum class HidWrite { ok, rejected, gone };
struct HidFeature {
  enum class Status { ok, rejected, interrupted, gone } status = Status::rejected;
  std::size_t size = 0;  ///< bytes of the report, including its id
};

class HidTransport {
 public:
  virtual ~HidTransport() = default;
  /// Takes one input report from the queue, without waiting.
  virtual HidRead read(std::span<std::byte> buffer) = 0;
  /// Sends an output report. Reports are sent in the order of the calls.
  virtual HidWrite write(std::span<const std::byte> report) = 0;
  /// Sends an output report that becomes worthless when a later one comes (a force): while it waits to be sent, a later
  /// report with the same first two bytes (report id, effect block) takes its place. Never blocks.
  virtual HidWrite write_newest(std::span<const std::byte> report) { return write(report); }
  /// How many of the reports that write() and write_newest() have taken were refused afterwards, by the system or the device
  /// (stalled, timed out, cut): they had no effect, and nobody sends them again.
  virtual std::int64_t refused_later() const { return 0; }
  /// Waits until every report written so far is sent or refused, at most a second. Do not use it in a tick.
  virtual void wait_until_sent() {}
  /// Feature reports; report[0] is the id to ask for. They are sent after all output reports that were written before them.
  /// `rejected`: the device has no such report. They may block, so do not use them in a tick.
  virtual HidFeature get_feature(std::span<std::byte> /*report*/) { return {}; }
  virtual HidWrite set_feature(std::span<const std::byte> /*report*/) { return HidWrite::rejected; }
  virtual std::span<const std::byte> report_descriptor() const = 0;
  virtual const HidDeviceInfo& info() const = 0;
};

}  // namespace evenstep
