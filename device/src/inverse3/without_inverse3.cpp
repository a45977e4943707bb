#include "evenstep/device/haptic_device.h"
#include "evenstep/device/inverse3/inverse3_socket.h"

namespace evenstep {

struct Inverse3Socket::State {
  std::string text;
};

std::vector<Inverse3State> inverse3_devices(const Inverse3Address&) { return {}; }

Inverse3Socket::Inverse3Socket(const Inverse3Address& address, const WallClock&, const Inverse3SocketOptions&) {
  throw DeviceError(
      address.text +
      ": this evenstep was built without WebSockets: install libboost-dev and build it with EVENSTEP_INVERSE3");
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
