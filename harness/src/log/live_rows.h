#pragma once
// The rows of a live run on their way from its lanes to files. After each slice of 20 ms, between two of its events, a lane
// swaps what it has added for empty columns whose memory is already reserved, and goes on: it neither waits nor allocates
// nor copies. A thread appends the rows to those that it has, in files if there are any (RowFiles), merges the events of the
// two lanes and offers the slice to the recording. So the memory of a live run does not depend on how long it is.

#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/live_run.h"
#include "evenstep/harness/strategy_lanes.h"
#include "evenstep/scheduler/live_lanes.h"
#include "live_log.h"

namespace evenstep::internal {

/// What a lane has added in a slice.
struct LaneSlice {
  struct Tool {
    // Of the device lane.
    Rows<TickRow> ticks;
    Rows<SpringRow> springs;
    Rows<TickInput> inputs;
    Rows<DeviceSpring> rendered;
    // Of the simulation lane.
    Rows<StepSample> steps;
    Rows<std::uint64_t> heads;
  };
  std::vector<Tool> tools;
  Rows<StepRow> steps;
  Rows<SegmentRow> segments;  ///< the first one again, as it is known now, if it was the last one of the slice before
  Rows<UnderrunRow> underruns;
  std::vector<Event> events;
  LaneCheck check;

  void clear();
};

/// Slices of a lane: one thread fills them, another one empties them, neither waits.
class SliceRing {
 public:
  explicit SliceRing(std::size_t slots) : slots_(slots) {}
  std::vector<LaneSlice>& slots() { return slots_; }  ///< before the run
  // The lane.
  LaneSlice* free() noexcept {  ///< empty columns; null: the other thread has not come for so long that all are full
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    return head - tail_.load(std::memory_order_acquire) == slots_.size() ? nullptr : &slots_[head % slots_.size()];
  }
  std::size_t size() const { return slots_.size(); }
  void push() noexcept { head_.fetch_add(1, std::memory_order_release); }
  // The other thread.
  LaneSlice* next() noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    return head_.load(std::memory_order_acquire) == tail ? nullptr : &slots_[tail % slots_.size()];
  }
  void pop() noexcept { tail_.fetch_add(1, std::memory_order_release); }

 private:
  std::vector<LaneSlice> slots_;
  alignas(64) std::atomic<std::uint64_t> head_{0};  ///< slices ever pushed
  alignas(64) std::atomic<std::uint64_t> tail_{0};  ///< slices ever popped
};

class LiveRows {
 public:
  /// Ten seconds.
  static constexpr std::size_t kSlots = 512;
  /// Takes its memory. `files` null: rows stay in memory. `log`, which may be null, gets the slices.
  LiveRows(const Scenario& scenario, std::shared_ptr<RowFiles> files, LiveLog* log, std::size_t slots = kSlots);
  ~LiveRows();
  LiveRows(const LiveRows&) = delete;
  LiveRows& operator=(const LiveRows&) = delete;

  /// Where the lanes add their rows and inputs. Makes room there for those of a slice, and in files for all of them. To be
  /// called after MemoryLock, which would read the files in.
  void attach(StrategyLanes& lanes, std::vector<DeviceInputs>& added, Scheduler& device, Scheduler& simulation);
  /// Starts the thread.
  void start();
  // Each is called by its own lane's thread, between two of its events.
  void device_slice(Scheduler& device, RealTime until);
  void simulation_slice(Scheduler& simulation, RealTime until);
  /// After the lanes have ended: gives the rows back to the lanes, and `recording` what a replay needs. Throws RunFailure
  /// ("disk") if there was no room for all of them.
  void finish(LiveRecording& recording);

 private:
  void loop();
  void take();
  void keep_device(const LaneSlice& slice);
  void keep_simulation(const LaneSlice& slice);
  LaneSlice& begin_slice(SliceRing& ring, LaneSlice& lost, Scheduler& scheduler, RealTime until, bool& full);
  [[noreturn]] void fail_for_lost_rows() const;

  const Scenario& scenario_;
  std::size_t tools_;
  std::vector<std::size_t> ticks_per_slice_;
  std::vector<bool> springs_;  ///< whether a device may render them by itself
  std::size_t steps_per_slice_;
  LiveLog* log_;
  StrategyLanes* lanes_ = nullptr;
  std::vector<DeviceInputs>* added_ = nullptr;
  SliceRing device_ring_, simulation_ring_;
  // Where a slice goes that found no room, and how many rows did; each of its own lane.
  LaneSlice device_lost_, simulation_lost_;
  bool device_full_ = false, simulation_full_ = false;
  std::int64_t lost_ticks_ = 0, lost_steps_ = 0;
  // Of the thread that keeps them.
  StrategyRecord rows_;
  std::vector<DeviceInputs> inputs_;
  LaneCheck device_check_, simulation_check_;
  std::optional<RealTime> unfinished_;
  EventRecorder event_recorder_;
  EventMerge events_;
  std::exception_ptr failure_;
  std::atomic<bool> ending_{false};
  WallClock clock_;
  std::unique_ptr<LaneThread> thread_;
};

}  // namespace evenstep::internal
