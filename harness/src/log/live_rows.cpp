#include "live_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <string_view>
#include <utility>

#include "evenstep/harness/strategy_run.h"

namespace evenstep::internal {
namespace {

/// How often the rings are emptied.
constexpr Duration kLookForSlices{5'000'000};
/// Steps may be shorter than programmed (step = "real"); a slice of more of them allocates, which delays no tick.
constexpr std::size_t kStepsOfProgrammed = 4;
constexpr std::size_t kEventsPerStep = 4;  // launch and step; segment and visualization if it has a single step

std::size_t per_slice(Rate rate) {
  return static_cast<std::size_t>(first_tick_at_or_after(rate, RealTime{0} + kRunSlice)) + 2;
}

/// Uses the memory once, so that no tick is the first to touch a page.
template <class List>
void make_room(List& list, std::size_t count) {
  list.resize(count);
  list.clear();
}

/// Reserves the place that a run of this length needs, up to an hour of it at 1 kHz, so that no column is copied to a larger
/// place while the run goes on, and a full disk is noticed before t = 0. Memory that is not used yet costs nothing.
void reserve_for(const Scenario& scenario, StrategyRecord& rows, std::vector<DeviceInputs>& inputs) {
  constexpr std::int64_t kMostExpected = 3'600'000;
  const auto count = [&](Rate rate) {
    return static_cast<std::size_t>(
        std::min(first_tick_at_or_after(rate, RealTime{scenario.run_duration.ns}), kMostExpected));
  };
  const std::size_t steps = count(scenario.scene.step_rate) + 1;
  std::size_t events = kEventsPerStep * steps;
  rows.steps.reserve(steps);
  for (std::size_t tool = 0; tool < inputs.size(); ++tool) {
    const std::size_t ticks = count(scenario.devices[tool].rate);
    events += ticks;
    rows.devices[tool].ticks.reserve(ticks);
    rows.devices[tool].steps.reserve(steps);
    inputs[tool].ticks.reserve(ticks);
    inputs[tool].interaction_heads.reserve(steps);
  }
  rows.events.reserve(events);
}

/// Whether its ticks may have rows of springs.
bool renders_springs(const DeviceSpec& device) {
  const auto* local = std::get_if<LocalRender>(&device.render);
  return local != nullptr && local->by_device;
}

template <class To, class From>
void append(To& to, const From& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// The launch of the step that has not ended after these events; `before` if they do not say. A replay must launch it too.
std::optional<RealTime> unfinished_launch(const std::vector<Event>& events, std::optional<RealTime> before) {
  for (auto event = events.rbegin(); event != events.rend(); ++event) {
    const std::string_view name = event->name.text;
    if (name == "step") return std::nullopt;
    if (name == "launch") return event->time;
  }
  return before;
}

}  // namespace

void LaneSlice::clear() {
  for (Tool& tool : tools) {
    tool.ticks.clear();
    tool.springs.clear();
    tool.inputs.clear();
    tool.rendered.clear();
    tool.steps.clear();
    tool.heads.clear();
  }
  steps.clear();
  segments.clear();
  underruns.clear();
  events.clear();
}

LiveRows::LiveRows(const Scenario& scenario, std::shared_ptr<RowFiles> files, LiveLog* log, std::size_t slots)
    : scenario_(scenario),
      tools_(scenario.devices.size()),
      steps_per_slice_(kStepsOfProgrammed * per_slice(scenario.scene.step_rate)),
      log_(log),
      device_ring_(slots),
      simulation_ring_(slots),
      rows_(empty_record(files)),
      event_recorder_(rows_),
      events_([this](const Event& event) { event_recorder_.keep(event); }),
      clock_(WallEpoch::in(Duration{0}), Duration{0}) {
  std::size_t all_ticks = 0;
  for (const DeviceSpec& device : scenario.devices) {
    ticks_per_slice_.push_back(per_slice(device.rate));
    all_ticks += ticks_per_slice_.back();
    springs_.push_back(renders_springs(device));
    rows_.devices.push_back(empty_device_record(files));
    inputs_.push_back({Rows<TickInput>(files), Rows<std::uint64_t>(files), Rows<DeviceSpring>(files)});
  }
  const auto prepare_device = [&](LaneSlice& slice) {
    slice.tools.resize(tools_);
    make_room(slice.events, all_ticks);
    for (std::size_t tool = 0; tool < tools_; ++tool) {
      make_room(slice.tools[tool].ticks, ticks_per_slice_[tool]);
      make_room(slice.tools[tool].inputs, ticks_per_slice_[tool]);
      if (!springs_[tool]) continue;
      make_room(slice.tools[tool].springs, ticks_per_slice_[tool]);
      make_room(slice.tools[tool].rendered, ticks_per_slice_[tool]);
    }
  };
  const auto prepare_simulation = [&](LaneSlice& slice) {
    slice.tools.resize(tools_);
    make_room(slice.events, kEventsPerStep * steps_per_slice_);
    make_room(slice.steps, steps_per_slice_);
    for (LaneSlice::Tool& tool : slice.tools) {
      make_room(tool.steps, steps_per_slice_);
      make_room(tool.heads, steps_per_slice_);
    }
  };
  for (LaneSlice& slice : device_ring_.slots()) prepare_device(slice);
  for (LaneSlice& slice : simulation_ring_.slots()) prepare_simulation(slice);
  prepare_device(device_lost_);
  prepare_simulation(simulation_lost_);
}

LiveRows::~LiveRows() { ending_.store(true, std::memory_order_release); }

void LiveRows::attach(StrategyLanes& lanes, std::vector<DeviceInputs>& added, Scheduler& device, Scheduler& simulation) {
  lanes_ = &lanes;
  added_ = &added;
  std::size_t all_ticks = 0;
  make_room(lanes.rows().steps, steps_per_slice_);
  for (std::size_t tool = 0; tool < tools_; ++tool) {
    DeviceRecord& rows = lanes.rows().devices[tool];
    make_room(rows.ticks, ticks_per_slice_[tool]);
    make_room(rows.steps, steps_per_slice_);
    make_room(added[tool].ticks, ticks_per_slice_[tool]);
    if (springs_[tool]) {
      make_room(rows.springs, ticks_per_slice_[tool]);
      make_room(added[tool].springs, ticks_per_slice_[tool]);
    }
    make_room(added[tool].interaction_heads, steps_per_slice_);
    all_ticks += ticks_per_slice_[tool];
  }
  device.reserve_events(all_ticks);
  simulation.reserve_events(kEventsPerStep * steps_per_slice_);
  try {
    reserve_for(scenario_, rows_, inputs_);
  } catch (const std::bad_alloc&) {  // columns grow
  }
}

void LiveRows::start() {
  thread_ = std::make_unique<LaneThread>([this] { loop(); });
}

/// A ring that was full once takes nothing more: rows behind a gap are worth nothing.
LaneSlice& LiveRows::begin_slice(SliceRing& ring, LaneSlice& lost, Scheduler& scheduler, RealTime until, bool& full) {
  LaneSlice* const slot = full ? nullptr : ring.free();
  full = slot == nullptr;
  if (full) lost.clear();
  LaneSlice& slice = full ? lost : *slot;
  scheduler.take_events(slice.events);
  slice.check = {until, scheduler.event_count(), scheduler.trace_hash()};
  return slice;
}

void LiveRows::device_slice(Scheduler& device, RealTime until) {
  LaneSlice& slice = begin_slice(device_ring_, device_lost_, device, until, device_full_);
  for (std::size_t tool = 0; tool < tools_; ++tool) {
    LaneSlice::Tool& to = slice.tools[tool];
    to.ticks.swap(lanes_->rows().devices[tool].ticks);
    to.springs.swap(lanes_->rows().devices[tool].springs);
    to.inputs.swap((*added_)[tool].ticks);
    to.rendered.swap((*added_)[tool].springs);
    if (device_full_) lost_ticks_ += std::ssize(to.ticks);
  }
  if (!device_full_) device_ring_.push();
}

void LiveRows::simulation_slice(Scheduler& simulation, RealTime until) {
  LaneSlice& slice = begin_slice(simulation_ring_, simulation_lost_, simulation, until, simulation_full_);
  StrategyRecord& rows = lanes_->rows();
  slice.steps.swap(rows.steps);
  slice.underruns.swap(rows.underruns);
  // The last segment stays: the end of its visualization may still be to come.
  slice.segments.assign(rows.segments.begin(), rows.segments.end());
  if (rows.segments.size() > 1) rows.segments.erase(rows.segments.begin(), rows.segments.end() - 1);
  for (std::size_t tool = 0; tool < tools_; ++tool) {
    slice.tools[tool].steps.swap(rows.devices[tool].steps);
    slice.tools[tool].heads.swap((*added_)[tool].interaction_heads);
  }
  if (simulation_full_)
    lost_steps_ += std::ssize(slice.steps);
  else
    simulation_ring_.push();
}

void LiveRows::loop() {
  while (!ending_.load(std::memory_order_acquire)) {
    clock_.wait_until(clock_.now() + kLookForSlices);
    take();
  }
}

/// After a failure the rings are emptied all the same: the loop, which holds a hand, goes on to its end.
void LiveRows::take() {
  const auto take_from = [&](SliceRing& ring, void (LiveRows::*keep)(const LaneSlice&)) {
    LaneSlice* const slice = ring.next();
    if (slice == nullptr) return false;
    try {
      if (!failure_) (this->*keep)(*slice);
    } catch (...) {
      failure_ = std::current_exception();
    }
    slice->clear();
    ring.pop();
    return true;
  };
  for (bool any = true; any;) {
    any = take_from(device_ring_, &LiveRows::keep_device);
    any = take_from(simulation_ring_, &LiveRows::keep_simulation) || any;
  }
}

void LiveRows::keep_device(const LaneSlice& slice) {
  for (std::size_t tool = 0; tool < tools_; ++tool) {
    const LaneSlice::Tool& from = slice.tools[tool];
    DeviceRecord& rows = rows_.devices[tool];
    if (!from.springs.empty()) {
      rows.springs.resize(rows.ticks.size());  // the ticks so far had no springs
      append(rows.springs, from.springs);
    }
    append(rows.ticks, from.ticks);
    append(inputs_[tool].ticks, from.inputs);
    append(inputs_[tool].springs, from.rendered);
  }
  events_.add_b(slice.events, slice.check.until);
  device_check_ = slice.check;
  if (log_) log_->device_slice(inputs_, rows_, device_check_);
}

void LiveRows::keep_simulation(const LaneSlice& slice) {
  const bool again =
      !rows_.segments.empty() && !slice.segments.empty() && rows_.segments.back().index == slice.segments.front().index;
  if (again) rows_.segments.pop_back();
  append(rows_.segments, slice.segments);
  append(rows_.steps, slice.steps);
  append(rows_.underruns, slice.underruns);
  for (std::size_t tool = 0; tool < tools_; ++tool) {
    append(rows_.devices[tool].steps, slice.tools[tool].steps);
    append(inputs_[tool].interaction_heads, slice.tools[tool].heads);
  }
  events_.add_a(slice.events, slice.check.until);
  simulation_check_ = slice.check;
  unfinished_ = unfinished_launch(slice.events, unfinished_);
  if (log_) log_->simulation_slice(inputs_, rows_, unfinished_, simulation_check_);
}

void LiveRows::fail_for_lost_rows() const {
  throw RunFailure("disk",
                   fmt::format("{} ticks and {} steps of the live run are lost: the thread that keeps their rows fell {} "
                               "slices of 20 ms behind",
                               lost_ticks_, lost_steps_, device_ring_.size()),
                   "the disk below --out is too slow, or the machine too busy: give a place on another disk with --out", -1);
}

void LiveRows::finish(LiveRecording& recording) {
  ending_.store(true, std::memory_order_release);
  thread_.reset();  // joins
  take();
  if (failure_) std::rethrow_exception(failure_);
  if (device_full_ || simulation_full_) fail_for_lost_rows();
  events_.finish();
  StrategyRecord& rows = lanes_->rows();
  rows.steps = std::move(rows_.steps);
  rows.segments = std::move(rows_.segments);
  rows.underruns = std::move(rows_.underruns);
  rows.events = std::move(rows_.events);
  rows.event_names = std::move(rows_.event_names);
  rows.event_counts = std::move(rows_.event_counts);
  rows.trace_hash = rows_.trace_hash;
  for (std::size_t tool = 0; tool < tools_; ++tool) {
    rows.devices[tool].steps = std::move(rows_.devices[tool].steps);
    rows.devices[tool].ticks = std::move(rows_.devices[tool].ticks);
    rows.devices[tool].springs = std::move(rows_.devices[tool].springs);
  }
  recording.inputs = std::move(inputs_);
  recording.device_check = device_check_;
  recording.simulation_check = simulation_check_;
  recording.unfinished = unfinished_;
}

}  // namespace evenstep::internal
