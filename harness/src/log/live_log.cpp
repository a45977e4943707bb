#include "live_log.h"

#include <fmt/format.h>

#include <algorithm>

namespace evenstep::internal {
namespace {

/// The most rows of a kind in a block. What was held back while the disk was slow follows in pieces.
constexpr std::size_t kMostRows = 512;

std::size_t next_of(std::size_t taken, std::size_t there) { return std::min(there, taken + kMostRows); }

glm::dvec3 vector_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

std::size_t ticks_of(const std::vector<DeviceInputs>& inputs) {
  std::size_t ticks = 0;
  for (const DeviceInputs& one : inputs) ticks += one.ticks.size();
  return ticks;
}

}  // namespace

/// True if that is all there is.
bool LiveLog::fill_device(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record, const LaneCheck& check) {
  device_taken_.resize(inputs.size());
  device_next_ = device_taken_;
  device_slice_.tools.resize(inputs.size());
  bool all = true;
  for (std::size_t tool = 0; tool < inputs.size(); ++tool) {
    const DeviceInputs& from = inputs[tool];
    ToolSlice& slice = device_slice_.tools[tool];
    Taken& next = device_next_[tool];
    slice.ticks.clear();
    for (std::size_t k = next.ticks; k < next_of(device_taken_[tool].ticks, from.ticks.size()); next.ticks = ++k) {
      const TickRow& row = record.devices[tool].ticks[k];
      slice.ticks.push_back({from.ticks[k], {row.lateness, vector_of(row.force_N)}});
    }
    next.springs = next_of(next.springs, from.springs.size());
    slice.springs.assign(from.springs.begin() + static_cast<std::ptrdiff_t>(device_taken_[tool].springs),
                         from.springs.begin() + static_cast<std::ptrdiff_t>(next.springs));
    all = all && next.ticks == from.ticks.size() && next.springs == from.springs.size();
  }
  device_slice_.check = all ? std::optional(check) : std::nullopt;
  device_bytes_.clear();
  encode(device_slice_, device_bytes_);
  return all;
}

bool LiveLog::fill_simulation(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record,
                              std::optional<RealTime> unfinished, const LaneCheck& check) {
  simulation_taken_.resize(inputs.size());
  simulation_next_ = simulation_taken_;
  SimulationSlice& slice = simulation_slice_;
  slice.heads.resize(inputs.size());
  segments_next_ = next_of(segments_taken_, record.segments.size());
  steps_next_ = next_of(steps_taken_, record.steps.size());
  slice.last.reset();
  if (segments_taken_ > 0) {
    last_next_ = known_at(record.segments[segments_taken_ - 1], check.until);
    if (last_next_ != last_taken_) slice.last = last_next_;
  }
  slice.segments.clear();
  for (std::size_t n = segments_taken_; n < segments_next_; ++n)
    slice.segments.push_back(last_next_ = known_at(record.segments[n], check.until));
  bool all = segments_next_ == record.segments.size() && steps_next_ == record.steps.size();
  slice.steps.clear();
  // No step of a segment that comes only later.
  const std::int64_t last = segments_next_ > 0 ? record.segments[segments_next_ - 1].index : -1;
  while (steps_next_ > steps_taken_ && record.steps[steps_next_ - 1].segment > last) --steps_next_;
  for (std::size_t n = steps_taken_; n < steps_next_; ++n)
    slice.steps.push_back({record.steps[n].segment, record.steps[n].begin, record.steps[n].end});
  for (std::size_t tool = 0; tool < inputs.size(); ++tool) {
    const auto& heads = inputs[tool].interaction_heads;
    Taken& next = simulation_next_[tool];
    next.heads = next_of(next.heads, heads.size());
    slice.heads[tool].assign(heads.begin() + static_cast<std::ptrdiff_t>(simulation_taken_[tool].heads),
                             heads.begin() + static_cast<std::ptrdiff_t>(next.heads));
    all = all && next.heads == heads.size();
  }
  all = all && steps_next_ == record.steps.size();
  slice.unfinished = all ? unfinished : std::nullopt;
  slice.check = all ? std::optional(check) : std::nullopt;
  simulation_bytes_.clear();
  encode(slice, simulation_bytes_);
  return all;
}

void LiveLog::device_slice(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record, const LaneCheck& check) {
  fill_device(inputs, record, check);
  if (writer_->offer(BlockKind::device, device_bytes_)) device_taken_ = device_next_;
}

void LiveLog::simulation_slice(const std::vector<DeviceInputs>& inputs, const StrategyRecord& record,
                               std::optional<RealTime> unfinished, const LaneCheck& check) {
  fill_simulation(inputs, record, unfinished, check);
  if (!writer_->offer(BlockKind::simulation, simulation_bytes_)) return;
  simulation_taken_ = simulation_next_;
  segments_taken_ = segments_next_;
  last_taken_ = last_next_;
  steps_taken_ = steps_next_;
}

bool LiveLog::write_rest(const LiveRecording& recording) {
  for (bool all = false; !all; device_taken_ = device_next_) {
    all = fill_device(recording.inputs, recording.record, recording.device_check);
    if (!writer_->write_now(BlockKind::device, device_bytes_)) return false;
  }
  for (bool all = false; !all;) {
    all = fill_simulation(recording.inputs, recording.record, recording.unfinished, recording.simulation_check);
    if (!writer_->write_now(BlockKind::simulation, simulation_bytes_)) return false;
    simulation_taken_ = simulation_next_;
    segments_taken_ = segments_next_;
    last_taken_ = last_next_;
    steps_taken_ = steps_next_;
  }
  InputLogEnd end{.trace_hash = recording.record.trace_hash,
                  .forces_digest = digest_of_forces(recording.record),
                  .interrupted = recording.record.interrupted,
                  .real_time_granted = recording.rights.fifo(),
                  .counters = {},
                  .steps_due = recording.record.steps_due};
  for (const DeviceRecord& device : recording.record.devices) end.counters.push_back(device.counters);
  std::vector<std::byte> bytes;
  encode(end, bytes);
  return writer_->write_now(BlockKind::end, bytes);
}

std::string LiveLog::finish(const LiveRecording& recording, const std::string& path) {
  writer_->stop();
  const bool written = write_rest(recording);
  const std::string error = writer_->finish();
  if (written && error.empty()) return {};
  const InputLogResult read = read_input_log(path);
  const std::size_t ticks = ticks_of(recording.inputs), steps = recording.record.steps.size();
  if (!read) return fmt::format("{}: the recording is lost: {} ({} ticks, {} steps)", path, error, ticks, steps);
  return fmt::format(
      "{}: the recording is not complete: {}; {} of {} ticks and {} of {} steps are not in it, and it replays until {:.6g} "
      "s",
      path, error, ticks - ticks_of(read->inputs), ticks, steps - read->rows.steps.size(), steps, seconds(read->until()));
}

}  // namespace evenstep::internal
