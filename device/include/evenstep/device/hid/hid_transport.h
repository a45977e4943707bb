#pragma once
/// Bytes to and from one HID device. The driver is the code above this seam; transports are hidapi (wall clock only) and
/// simulated. Numbered reports carry their id as byte 0 both ways.

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
  enum class Status { report, nothing, interrupted, gone } status = Status::nothing;
  std::size_t size = 0;            ///< bytes of the report; may exceed what the buffer could take (then it is cut)
};
enum class HidWrite { ok, rejected, gone };

class HidTransport {
 public:
  virtual ~HidTransport() = default;
  /// One queued input report, without waiting.
  virtual HidRead read(std::span<std::byte> buffer) = 0;
  virtual HidWrite write(std::span<const std::byte> report) = 0;
  virtual std::span<const std::byte> report_descriptor() const = 0;
  virtual const HidDeviceInfo& info() const = 0;
};

}  // namespace evenstep
