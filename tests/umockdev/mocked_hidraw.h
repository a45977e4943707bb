#pragma once
/// A hidraw device that exists only in this process: unmodified libhidapi and libudev see it through umockdev. There can be
/// only one per process, and only under umockdev's preloaded library.
///
///   Node::fifo   packet by packet like the kernel's hidraw: 64 reports can wait, one per read; if it is full, the newest
///                report is dropped. poll does not notice when it is unplugged.
///   Node::pty    a byte stream, so at most one report can wait; it is unplugged like a real device.

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
    std::string force_feedback = "0";  ///< "capabilities/ff" of an input device that the kernel made for it; "0": none
  };
  /// False if this does not run under umockdev; then nothing can be tested.
  static bool possible();

  explicit MockedHidraw(Spec spec);
  ~MockedHidraw();

  /// Sends an input report; false if the queue was full and it was dropped.
  bool send(std::span<const std::byte> report);
  void unplug();   ///< Node::pty only
  void plug_in();  ///< plugs it in again after unplug(), as the next hidraw node

  /// The reports that reached the device, in order.
  std::vector<Bytes> outputs() const;
  std::vector<Bytes> features_set() const;
  void answer_feature(Bytes report);  ///< sets the feature report of id report[0]; others are refused (EIO)
  void take_time_to_write(evenstep::Duration each);

  struct State;

 private:
  std::unique_ptr<State> state_;
};
