#pragma once
/// What the kernel tells about /dev/hidrawN in sysfs, readable by everyone and without opening the device. (hidapi 0.13.1 cannot
/// give the report descriptor, opens any path it is told, and has no strings for a device that is not on USB.)

#include <cstddef>
#include <string>
#include <vector>

namespace evenstep::internal {

/// "hidraw3" of "/dev/hidraw3", or of a link to it; empty where the path is no hidraw device.
std::string hidraw_name(const std::string& path);
/// Empty where it cannot be read.
std::vector<std::byte> hidraw_report_descriptor(const std::string& name);
/// HID_NAME (or another key) of the device's uevent; empty where there is none.
std::string hidraw_property(const std::string& name, const std::string& key);
/// "/dev/input/event7" where an input device of the kernel's can play force feedback on the same device; else empty.
std::string hidraw_force_feedback_node(const std::string& name);

}  // namespace evenstep::internal
