#pragma once
// What a live run adds to its recording for each slice, lane by lane, and what it writes when it is over.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/harness/live_run.h"
#include "writer.h"

namespace evenstep::internal {

class LiveLog {
 public:
  explicit LiveLog(std::unique_ptr<InputLogWriter> writer) : writer_(std::move(writer)) {}

  // Called by the thread that keeps the rows (live_rows.h). Those that find no room are offered again next time.
  void device_slice(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record, const LaneCheck& check);
  void simulation_slice(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record,
                        std::optional<RealTime> unfinished, const LaneCheck& check);

  /// After the run, when no device is driven any more, because it waits for the disk. Writes what is left and the last
  /// block. Returns what is missing in the file, and why; empty if nothing is.
  std::string finish(const LiveRecording& recording, const std::string& path);

 private:
  bool fill_device(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record, const LaneCheck& check);
  bool fill_simulation(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record,
                       std::optional<RealTime> unfinished, const LaneCheck& check);
  bool write_rest(const LiveRecording& recording);

  std::unique_ptr<InputLogWriter> writer_;
  struct Taken {
    std::size_t ticks = 0, springs = 0, heads = 0;
  };
  // Of the device lane.
  std::vector<Taken> device_taken_, device_next_;
  DeviceSlice device_slice_;
  std::vector<std::byte> device_bytes_;
  // Of the simulation lane.
  std::vector<Taken> simulation_taken_, simulation_next_;
  std::size_t segments_taken_ = 0, steps_taken_ = 0, segments_next_ = 0, steps_next_ = 0;
  SegmentRow last_taken_, last_next_;  // the last segment of segments_taken_, as it was known then
  SimulationSlice simulation_slice_;
  std::vector<std::byte> simulation_bytes_;
};

}  // namespace evenstep::internal
