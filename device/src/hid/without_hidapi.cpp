// In the place of hidapi_transport.cpp in a build without hidapi (EVENSTEP_HIDAPI=OFF). There is never a transport, so its
// functions are never called.
#include <cstdlib>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/time/build_option.h"

namespace evenstep {
namespace {

[[noreturn]] void refuse() { throw DeviceError(refusal_without(build_option::kHidapi)); }

}  // namespace

bool built_with_hidapi() { return false; }
std::vector<HidListing> hid_devices() { refuse(); }
std::string udev_rule(const HidDeviceInfo&) { refuse(); }

struct HidapiTransport::State {};
HidapiTransport::HidapiTransport(const std::string&, const WallClock&, Duration) { refuse(); }
HidapiTransport::~HidapiTransport() = default;
HidRead HidapiTransport::read(std::span<std::byte>) { std::abort(); }
HidWrite HidapiTransport::write(std::span<const std::byte>) { std::abort(); }
HidWrite HidapiTransport::write_newest(std::span<const std::byte>) { std::abort(); }
std::int64_t HidapiTransport::refused_later() const { std::abort(); }
void HidapiTransport::wait_until_sent() { std::abort(); }
HidFeature HidapiTransport::get_feature(std::span<std::byte>) { std::abort(); }
HidWrite HidapiTransport::set_feature(std::span<const std::byte>) { std::abort(); }
std::span<const std::byte> HidapiTransport::report_descriptor() const { std::abort(); }
const HidDeviceInfo& HidapiTransport::info() const { std::abort(); }
WriteTimes HidapiTransport::write_times() const { std::abort(); }
std::int64_t HidapiTransport::times_unplugged() const { std::abort(); }

}  // namespace evenstep
