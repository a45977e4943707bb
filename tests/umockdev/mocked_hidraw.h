#pragma once
/// A hidraw device that exists in this process only: unmodified libhidapi and libudev see it through umockdev. One per process
/// (umockdev's rule), and only under its preloaded library.
///
///   Node::fifo   packet for packet as the kernel's hidraw: 64 reports wait, one per read, the newest is dropped when full.
///                Its unplugging cannot be seen by poll.
///   Node::pty    a byte stream, so at most one report may wait; unplugging is seen as on a real device.

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/clock/clock.h"

using Bytes = std::vector<std::byte>;

class MockedHidraw {
 public:
  enum class Node { fifo, pty };
  struct Spec {
    std::string vendor_product = "00001209:00000E57";  ///< as in HID_ID
    std::string name = "evenstep reference device";
    std::string serial = "SN0001";
    Bytes report_descriptor;
    Node node = Node::fifo;
    std::string force_feedback = "0";  ///< "capabilities/ff" of an input device that the kernel made of it; "0": none
  };
  /// False: not under umockdev; nothing may be tested then.
  static bool possible();

  explicit MockedHidraw(Spec spec);
  ~MockedHidraw();

  /// One input report; false: the queue was full and it was dropped.
  bool send(std::span<const std::byte> report);
  void unplug();   ///< Node::pty only
  void plug_in();  ///< again, after unplug(), as the next hidraw node

  /// What reached the device, in order.
  std::vector<Bytes> outputs() const;
  std::vector<Bytes> features_set() const;
  void answer_feature(Bytes report);          ///< the feature report of id report[0]; others are refused (EIO)
  void take_time_to_write(evenstep::Duration each);

  struct State;

 private:
  std::unique_ptr<State> state_;
};
