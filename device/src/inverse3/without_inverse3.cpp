#include "evenstep/device/haptic_device.h"
#include "evenstep/device/inverse3/inverse3_socket.h"
#include "evenstep/time/build_option.h"

namespace evenstep {

struct Inverse3Socket::State {
  std::string text;
};

bool built_with_inverse3() { return false; }

std::vector<Inverse3State> inverse3_devices(const Inverse3Address&) { return {}; }

Inverse3Socket::Inverse3Socket(const Inverse3Address& address, const WallClock&, const Inverse3SocketOptions&) {
  throw DeviceError(address.text + ": " + refusal_without(build_option::kInverse3));
}
Inverse3Socket::~Inverse3Socket() = default;
Inverse3Link::Read Inverse3Socket::read(std::string&) { return Read::gone; }
void Inverse3Socket::post(std::string) {}
void Inverse3Socket::rest(std::string) {}
void Inverse3Socket::reject(std::string) {}
const std::string& Inverse3Socket::first_message() const { return state_->text; }
const std::string& Inverse3Socket::name() const { return state_->text; }
Inverse3Times Inverse3Socket::times() const { return {}; }

}  // namespace evenstep
