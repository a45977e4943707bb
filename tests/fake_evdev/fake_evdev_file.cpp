// An EvdevFile whose kernel has dropped events before the run began, as a kernel does if nobody reads them while a solver
// starts. From then on, each time that it is read until nothing is left, there is one report. So what is read does not
// depend on how fast this machine is.
#include <array>
#include <cerrno>

#include "evenstep/device/evdev/evdev_file.h"

namespace evenstep {
namespace {

/// The kernel's side of the device. One thread at a time reads it: first the one that starts the run, then the device lane.
struct Kernel {
  std::int32_t x = 0;
  bool drops = true;     ///< the next read says that events were dropped
  bool has_more = true;  ///< the next read gives a report; after it nothing is left
};
Kernel kernel;

}  // namespace

std::vector<EvdevListing> evdev_devices() { return {}; }
std::vector<std::unique_ptr<EvdevNode>> open_again(const EvdevInfo&) { return {}; }

EvdevFile::EvdevFile(const std::string& path) : info_{path, "fake", 1, 2, ""} { kernel = {}; }
EvdevFile::~EvdevFile() = default;

EvdevRead EvdevFile::read(std::span<EvdevEvent> events) {
  kernel.has_more = !kernel.has_more;
  if (kernel.has_more) return {};
  std::size_t count = 0;
  if (kernel.drops) events[count++] = {evdev::kSyn, evdev::kSynDropped, 0};
  kernel.drops = false;
  events[count++] = {evdev::kAbs, 0, ++kernel.x};
  events[count++] = {evdev::kSyn, evdev::kSynReport, 0};
  return {EvdevRead::Status::events, count};
}

int EvdevFile::write(const EvdevEvent&) { return 0; }
int EvdevFile::upload(EvdevEffect& effect) {
  effect.id = 0;
  return 0;
}
int EvdevFile::erase(int) { return 0; }
int EvdevFile::grab() { return 0; }
int EvdevFile::effect_count(int& count) {
  count = 16;
  return 0;
}
bool EvdevFile::has(int, std::uint16_t) { return true; }
bool EvdevFile::has_axis(std::uint16_t code) { return code < 2; }
bool EvdevFile::has_feedback(std::uint16_t) { return true; }
int EvdevFile::axis(std::uint16_t code, EvdevAxis& axis) {
  axis = {code == 0 ? kernel.x : 0, -100'000, 100'000};
  return 0;
}
int EvdevFile::set_axis(std::uint16_t, const EvdevAxis&) { return 0; }

}  // namespace evenstep
