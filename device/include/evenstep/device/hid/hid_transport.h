#pragma once
/// Bytes to and from one HID device. The driver is the code above this seam; transports are hidapi (wall clock only) and
/// simulated. Every report carries its id as byte 0: 0 where the device does not number its reports (input reports of such a
/// device have no id byte at all, as hidapi delivers them).

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
  /// `returned`, once: the device was unplugged and is back. What it was told before is lost, and its counters begin anew.
  enum class Status { report, nothing, interrupted, returned, gone } status = Status::nothing;
  std::size_t size = 0;            ///< bytes of the report; may exceed what the buffer could take (then it is cut)
};
enum class HidWrite { ok, rejected, gone };
struct HidFeature {
  enum class Status { ok, rejected, interrupted, gone } status = Status::rejected;
  std::size_t size = 0;            ///< bytes of the report, its id included
};

class HidTransport {
 public:
  virtual ~HidTransport() = default;
  /// One queued input report, without waiting.
  virtual HidRead read(std::span<std::byte> buffer) = 0;
  /// Output reports, sent in the order of the calls.
  virtual HidWrite write(std::span<const std::byte> report) = 0;
  /// An output report that a later one makes worthless (a force): while it waits to be sent, a later report with the same
  /// first two bytes (report id, effect block) takes its place. Never blocks.
  virtual HidWrite write_newest(std::span<const std::byte> report) { return write(report); }
  /// Feature reports; report[0] is the id to ask for. They go after all output reports that were written before them. `rejected`:
  /// the device has no such report. May block: not for a tick.
  virtual HidFeature get_feature(std::span<std::byte> /*report*/) { return {}; }
  virtual HidWrite set_feature(std::span<const std::byte> /*report*/) { return HidWrite::rejected; }
  virtual std::span<const std::byte> report_descriptor() const = 0;
  virtual const HidDeviceInfo& info() const = 0;
};

}  // namespace evenstep
