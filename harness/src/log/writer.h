#pragma once
// Writes a recording while the run goes on, on a thread of its own. The slices of each lane come through a ring, whose
// writer never waits, whatever the disk does: a slice that finds no room is refused, and whoever keeps the rows
// (live_rows.h) offers it again later. A write that fails is tried again and again until the run is over.

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "codec.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/input_log.h"
#include "evenstep/scheduler/live_lanes.h"
#include "evenstep/time/result.h"
#include "src/live/message_ring.h"

namespace evenstep::internal {

class InputLogWriter {
 public:
  /// Creates the file and writes the head, and the files of the scenario behind it. An error if the file exists (a device
  /// such as /dev/full may), or cannot be made.
  static Result<std::unique_ptr<InputLogWriter>> create(const std::string& path, const InputLogHead& head,
                                                        const std::vector<EmbeddedFile>& files = {});
  /// A file that has nothing but a head is removed.
  ~InputLogWriter();
  InputLogWriter(const InputLogWriter&) = delete;
  InputLogWriter& operator=(const InputLogWriter&) = delete;

  /// Called by one thread for each kind. False: no room now, and nothing was taken.
  bool offer(BlockKind lane, std::span<const std::byte> content);

  /// How many blocks the kernel has as a whole: no kill of this process can lose them any more.
  std::uint64_t blocks_kept() const { return blocks_kept_.load(std::memory_order_acquire); }

  /// After the lanes have ended. Writes what is still in the rings.
  void stop();
  /// After stop(): writes a block at once. False if that failed, now or before.
  bool write_now(BlockKind kind, std::span<const std::byte> content);
  /// After stop(): waits until everything is on the disk. Returns why the file is not complete; empty if it is.
  std::string finish();

 private:
  InputLogWriter(std::string path, int file);
  void loop();
  void take_from_rings();
  void next_block(BlockKind kind, std::span<const std::byte> content);
  bool write_pending();
  void flush_to_disk();

  std::string path_;
  int file_;
  bool is_new_ = false;  // there was no such file
  MessageRing device_ring_, simulation_ring_;
  std::vector<std::byte> message_, pending_;  // the block that is being written
  std::size_t sent_ = 0;                      // bytes of it that the kernel has
  std::uint64_t sequence_ = 0;
  std::string write_error_;  // of the write that failed last; empty if it could be made up for since
  std::string disk_error_;   // that data which the kernel had did not reach the disk
  bool dirty_ = false;
  std::atomic<std::uint64_t> blocks_kept_{0};
  std::atomic<bool> ending_{false};
  WallClock clock_;
  RealTime flushed_;
  std::unique_ptr<LaneThread> thread_;
};

}  // namespace evenstep::internal
