#include "hidapi_library.h"

#include <fmt/format.h>

#include "evenstep/device/haptic_device.h"
#include "evenstep/time/library_on_demand.h"

namespace evenstep::internal {
namespace {

HidapiLibrary load() {
  HidapiLibrary library;
#define EVENSTEP_BY_NAME(name) FunctionByName{#name, reinterpret_cast<void**>(&library.name)},
  const auto missing = load_on_demand("libhidapi-hidraw.so.0", {EVENSTEP_HID_FUNCTIONS(EVENSTEP_BY_NAME)});
#undef EVENSTEP_BY_NAME
  if (missing)
    throw DeviceError(fmt::format("hidapi cannot be loaded: {}; to see HID devices, install libhidapi-hidraw0", *missing));
  return library;
}

}  // namespace

const HidapiLibrary& hidapi() {
  static const HidapiLibrary library = load();
  return library;
}

}  // namespace evenstep::internal
