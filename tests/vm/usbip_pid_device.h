#pragma once
/// A simulated force feedback board (simulated_board.h) as a full-speed USB device of this machine. It is served to the
/// kernel's vhci_hcd over USB/IP, through a socket pair. So usbcore, usbhid and hid-pidff bind to it as to a real device. (A
/// uhid device does not get hid-pidff, which is a part of usbhid.) Its interrupt endpoints pass one report a millisecond
/// each way, like those of every full-speed device. It needs the modules vhci-hcd and usbhid and the right to write to the
/// `attach` file of vhci_hcd.

#include <array>
#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hid/simulated_board.h"

class UsbipPidDevice {
 public:
  /// Why there cannot be such a device here; empty if there can.
  static std::string refusal();

  UsbipPidDevice(const evenstep::WallClock& clock, const evenstep::SimulatedBoardOptions& options,
                 const evenstep::Motion& motion = evenstep::Still{});
  ~UsbipPidDevice();
  UsbipPidDevice(const UsbipPidDevice&) = delete;
  UsbipPidDevice& operator=(const UsbipPidDevice&) = delete;

  std::string hidraw_node() const;  ///< "/dev/hidraw0"; empty after a generous wait
  std::string event_node() const;   ///< "/dev/input/event1", with force feedback; empty after a generous wait
  glm::dvec3 force_N() const;       ///< the force that it renders now
  /// When the force that the device renders last changed, and when it last sent a position.
  evenstep::RealTime force_changed_at() const;
  evenstep::RealTime reported_at() const;
  /// The output reports with this id among the first hundred.
  std::vector<std::vector<std::uint8_t>> outputs(std::uint8_t id) const;

 private:
  struct Submit {
    std::uint32_t sequence = 0, endpoint = 0, length = 0;
    bool in = false;
    std::array<std::uint8_t, 8> setup{};
    std::vector<std::uint8_t> data;
  };
  void serve();
  bool receive();
  void unlink(std::uint32_t sequence, std::uint32_t victim);
  void control(const Submit& submit);
  std::vector<std::uint8_t> descriptor(const std::array<std::uint8_t, 8>& setup) const;
  void transfer();
  void note_force();
  void reply(std::uint32_t sequence, std::int32_t status, const std::vector<std::uint8_t>& data, std::uint32_t length);

  const evenstep::WallClock& clock_;
  mutable std::mutex mutex_;
  mutable evenstep::SimulatedBoard firmware_;
  int socket_ = -1;
  std::deque<Submit> in_, out_;
  glm::dvec3 force_N_{0};
  evenstep::RealTime force_changed_at_, reported_at_;
  std::vector<std::vector<std::uint8_t>> outputs_;
  std::thread thread_;
};
