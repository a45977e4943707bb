// Any bytes as a message of a Haply Inverse Service; and as the address of one.
#include <cmath>
#include <string_view>

#include "evenstep/device/inverse3/inverse3_messages.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto devices = read_inverse3_message(text);
  require(devices.ok() || (!devices.error().empty() && devices.error().size() < 200), "a refusal says nothing, or too much");
  if (devices) {
    require(devices->size() <= kMostInverse3Devices, "more devices than the limit");
    for (const Inverse3State& device : *devices) {
      require(!device.device_id.empty() && device.device_id.size() <= kLongestInverse3Id, "an id of a wrong length");
      for (const char c : device.device_id)
        require(c > ' ' && c <= '~' && c != '"' && c != '\\', "an id that must be escaped");
      for (int axis = 0; axis < 3 && device.position_m; ++axis)
        require(std::abs((*device.position_m)[axis]) <= kInverse3Reach_m, "a position out of reach");
      // What is sent to the device is JSON that contains its id again.
      const std::string sent = inverse3_force_message(device.device_id, device.position_m.value_or(glm::dvec3(0)));
      const auto own = read_inverse3_message(sent);
      require(own.ok() && own->size() == 1 && own->front().device_id == device.device_id, "a message of ours is no JSON");
    }
  }
  const auto address = read_inverse3_address(text);
  require(!address.ok() || (address->port >= 1 && address->port <= 65535 && !address->host.empty()),
          "an address of nothing");
  require(address.ok() || address.error().size() < 200, "a refusal says too much");
  return 0;
}
