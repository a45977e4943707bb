#pragma once
/// libhidapi and sysfs as HidapiTransport sees them, with one device of ours below: writes can be made to end in any way
/// that the system or a device ends them. Linked instead of libhidapi.

#include <cstdint>

#include "evenstep/device/hid/hid_transport.h"

namespace evenstep::test {

/// How the next writes end: -1 with errno `error`, or with `difference` bytes more or fewer than given. The device gets
/// nothing of them.
struct FailingWrites {
  int count = 0;
  int error = 0;
  int difference = 0;
};

class FakeHidapi {
 public:
  /// The device must outlive it; there is one at a time.
  explicit FakeHidapi(HidTransport& device);
  ~FakeHidapi();
  FakeHidapi(const FakeHidapi&) = delete;
  FakeHidapi& operator=(const FakeHidapi&) = delete;

  void fail(FailingWrites how);
  std::int64_t failed() const;  ///< writes so far that ended so
};

}  // namespace evenstep::test
