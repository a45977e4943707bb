#pragma once
/// What sysfs says about /dev/hidrawN, which anybody can read without opening the device. (hidapi 0.13.1 cannot give the
/// report descriptor, opens any path that it is given, and gives no strings for a device that is not on USB.)

#include <cstddef>
#include <string>
#include <vector>

namespace evenstep::internal {

/// "hidraw3" for "/dev/hidraw3", or for a link to it; empty if the path is not a hidraw device.
std::string hidraw_name(const std::string& path);
/// Empty if it cannot be read.
std::vector<std::byte> hidraw_report_descriptor(const std::string& name);
/// HID_NAME (or another key) in the device's uevent; empty if there is none.
std::string hidraw_property(const std::string& name, const std::string& key);
/// "/dev/input/event7" if the kernel has an input device there that can play force feedback on the same device; else empty.
std::string hidraw_force_feedback_node(const std::string& name);

}  // namespace evenstep::internal
