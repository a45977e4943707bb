#pragma once
/// The functions of hidapi that the transport calls. libhidapi, and with it libudev, is opened when the first of them is
/// called: a run without a real device never loads it.

#include <hidapi/hidapi.h>

// clang-format off
#define EVENSTEP_HID_FUNCTIONS(X)                                                                                 \
  X(hid_close) X(hid_enumerate) X(hid_error) X(hid_free_enumeration) X(hid_get_feature_report) X(hid_init)        \
  X(hid_open_path) X(hid_read_timeout) X(hid_send_feature_report) X(hid_write)
// clang-format on

namespace evenstep::internal {

struct HidapiLibrary {
#define EVENSTEP_DECLARE(name) decltype(&::name) name = nullptr;
  EVENSTEP_HID_FUNCTIONS(EVENSTEP_DECLARE)
#undef EVENSTEP_DECLARE
};

/// Throws DeviceError with the remedy if libhidapi-hidraw is not installed.
const HidapiLibrary& hidapi();

}  // namespace evenstep::internal
