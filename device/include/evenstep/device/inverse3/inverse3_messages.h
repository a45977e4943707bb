#pragma once
/// What the Haply Inverse Service and its clients say to each other: JSON texts. docs/devices/inverse3.md has every field
/// that is used, with the public clients that say so; no other field is looked at.
///
/// A message comes from outside and is not trusted. It is read without a tree in memory and refused as a whole if it is not
/// JSON, is longer or deeper than the limits below, or has a used field of another type. Whatever it says besides is
/// skipped.

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/time/result.h"

namespace evenstep {

inline constexpr std::size_t kLongestInverse3Message = 65536;  ///< bytes: 40 devices with all that is known of them
inline constexpr int kDeepestInverse3Message = 32;             ///< nested objects and lists; the service nests 6
inline constexpr std::size_t kMostInverse3Devices = 64;        ///< in one message
inline constexpr std::size_t kLongestInverse3Id = 64;
/// No coordinate of a device that stands on a table is further away from its base.
inline constexpr double kInverse3Reach_m = 2;

/// One device in a message. What the message does not say is empty.
struct Inverse3State {
  std::string device_id;                 ///< printable characters of ASCII without blanks, quotes and backslashes
  std::optional<glm::dvec3> position_m;  ///< `state.cursor_position`, by its own axes from its own origin; within reach
  std::optional<bool> calibrated;        ///< `status.calibrated`; false: its position means nothing
  std::optional<bool> in_use;            ///< `status.in_use`
};

/// The devices in the list `inverse3` of a message; none if there is no such list. The error is for people.
Result<std::vector<Inverse3State>> read_inverse3_message(std::string_view message);

/// The message that makes the device push with this force, which must be finite. `device_id` as in Inverse3State.
std::string inverse3_force_message(std::string_view device_id, const glm::dvec3& force_N);
/// The message that asks for all devices, with all that is known of them.
std::string inverse3_inventory_message();

/// Where a service listens, and which of its devices is meant: ws://127.0.0.1:10001#049D
struct Inverse3Address {
  std::string host;         ///< a numeric address, without the brackets of IPv6
  unsigned port = 10001;    ///< 1 to 65535
  std::string device_id;    ///< empty: the only one
  std::string text;         ///< as it was written
  bool is_loopback = true;  ///< the service is on this machine
};
/// Reads ws://HOST[:PORT][/][#DEVICE_ID]; HOST is `localhost`, 1.2.3.4 or [::1]. No name is looked up.
Result<Inverse3Address> read_inverse3_address(std::string_view text);

}  // namespace evenstep
