#pragma once
/// A node of Linux' input core as a live run drives it: uploads and plays are made by a thread of its own, because an upload
/// is a system call that may wait for the device; and a device that was unplugged is looked for. It works with a wall clock
/// only, which the type of the constructor's clock enforces.
///
/// upload() of an effect that is there already, and write(), return 0 at once. While such a call waits to be sent, a later
/// one for the same effect takes its place. All other calls go to the kernel on the caller's thread; a new effect and
/// erase() wait first until all is sent, so do not use them in a tick. axis() answers EAGAIN while something is being sent,
/// because it would wait for that.
///
/// Times of events are converted from CLOCK_MONOTONIC, in which the node has them, to the clock of the run.
///
/// While the device is away, reads are `away`, and calls give ENXIO. When it is back, the thread grabs it and makes the
/// effects anew under the numbers that they had, without force and not playing; then one read is `returned`.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/evdev/evdev_node.h"
#include "evenstep/device/write_times.h"

namespace evenstep {

using EvdevNodes = std::vector<std::unique_ptr<EvdevNode>>;

class LiveEvdev final : public EvdevNode {
 public:
  /// `find` opens the device again after it was unplugged, and all that look like it; empty: it is not there (yet). The
  /// first one that can be grabbed for us alone and accepts our effects is used. It is called by another thread, four times
  /// a second for `patience`. After that (at once if `patience` is 0) the device is gone for ever.
  LiveEvdev(std::unique_ptr<EvdevNode> node, std::function<EvdevNodes()> find, const WallClock& clock,
            Duration patience = {});
  /// Goes on sending what waits for at most a second, then closes.
  ~LiveEvdev() override;

  EvdevRead read(std::span<EvdevEvent> events) override;
  bool tells_times() const override;
  int write(const EvdevEvent& event) override;
  int upload(EvdevEffect& effect) override;
  Upload uploaded(int id) override;
  int erase(int id) override;
  int grab() override;
  int effect_count(int& count) override;
  bool has_axis(std::uint16_t code) override;
  bool has_feedback(std::uint16_t code) override;
  int axis(std::uint16_t code, EvdevAxis& axis) override;
  int set_axis(std::uint16_t code, const EvdevAxis& axis) override;
  const EvdevInfo& info() const override;

  WriteTimes write_times() const;        ///< so far; callable from any thread
  std::int64_t times_unplugged() const;  ///< callable from any thread

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace evenstep
