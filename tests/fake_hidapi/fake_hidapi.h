#pragma once
/// libhidapi and sysfs as HidapiTransport sees them, with a simulated device below. Writes can be made to end in every way
/// in which the system or a device may end them. This is linked instead of libhidapi.

#include <cstdint>

#include "evenstep/device/hid/hid_transport.h"

namespace evenstep::test {

/// How the next writes end: with -1 and errno `error`, or with `difference` bytes more or fewer than given. None of them
/// reaches the device.
struct FailingWrites {
  int count = 0;
  int error = 0;
  int difference = 0;
};

class FakeHidapi {
 public:
  /// The device must outlive this object. There may be only one at a time.
  explicit FakeHidapi(HidTransport& device);
  ~FakeHidapi();
  FakeHidapi(const FakeHidapi&) = delete;
  FakeHidapi& operator=(const FakeHidapi&) = delete;

  void fail(FailingWrites how);
  std::int64_t failed() const;  ///< number of writes so far that failed
};

}  // namespace evenstep::test
