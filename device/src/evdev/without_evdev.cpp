#include "evenstep/device/evdev/evdev_file.h"
#include "evenstep/device/haptic_device.h"

namespace evenstep {

std::vector<EvdevListing> evdev_devices() { return {}; }
std::vector<std::unique_ptr<EvdevNode>> open_again(const EvdevInfo&) { return {}; }

EvdevFile::EvdevFile(const std::string& path) {
  throw DeviceError(path + ": evdev devices are Linux', and this is another system");
}
EvdevFile::~EvdevFile() = default;
EvdevRead EvdevFile::read(std::span<EvdevEvent>) { return {EvdevRead::Status::gone}; }
int EvdevFile::write(const EvdevEvent&) { return -1; }
int EvdevFile::upload(EvdevEffect&) { return -1; }
int EvdevFile::erase(int) { return -1; }
int EvdevFile::grab() { return -1; }
int EvdevFile::effect_count(int&) { return -1; }
bool EvdevFile::has(int, std::uint16_t) { return false; }
bool EvdevFile::has_axis(std::uint16_t) { return false; }
bool EvdevFile::has_feedback(std::uint16_t) { return false; }
int EvdevFile::axis(std::uint16_t, EvdevAxis&) { return -1; }
int EvdevFile::set_axis(std::uint16_t, const EvdevAxis&) { return -1; }

}  // namespace evenstep
