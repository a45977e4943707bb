#include "core_paths.h"

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <utility>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/loop/loop_watch.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/phase_locked_map.h"
#include "evenstep/remap/sample_buffer.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/step_timing.h"
#include "evenstep/sim/solver.h"

namespace evenstep::bench {
namespace {

template <class Value>
void use(const Value& value) {
  asm volatile("" : : "r,m"(value) : "memory");
}

/// Uniform in [0, 2^20) ns = [0, 1.05) ms.
Duration draw_ms(std::uint64_t& state) {
  state = state * 6364136223846793005ULL + 1442695040888963407ULL;
  return {static_cast<std::int64_t>(state >> 44)};
}

Task hold(Scheduler& scheduler, std::uint64_t seed) {
  for (std::uint64_t state = spread(seed);;) {
    co_await scheduler.until(scheduler.now() + Duration{100'000} + draw_ms(state), Lane::device, "tick");
  }
}

Task work_lane(Scheduler& scheduler, Work& work) {
  for (;;) co_await scheduler.external(scheduler.now() + Duration{1'000'000}, &work, "step");
}

struct NoWork final : Work {
  void run() override {}
};

/// The hold model: every lane waits for a pseudo-random time after its last event, so that the number of pending events
/// does not change.
class TimerEvents final : public CorePath {
 public:
  TimerEvents(int lanes, bool keep_events) : scheduler_(clock_, executor_, {.keep_events = keep_events}) {
    for (int lane = 0; lane < lanes; ++lane) scheduler_.spawn(hold(scheduler_, static_cast<std::uint64_t>(lane)));
  }
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) scheduler_.run_one();
    use(scheduler_.trace_hash());
  }

 private:
  VirtualClock clock_;
  InlineExecutor executor_;
  Scheduler scheduler_;
};

class WorkEvents final : public CorePath {
 public:
  WorkEvents() : scheduler_(clock_, executor_, {.keep_events = false}) { scheduler_.spawn(work_lane(scheduler_, work_)); }
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) scheduler_.run_one();
    use(scheduler_.trace_hash());
  }

 private:
  VirtualClock clock_;
  InlineExecutor executor_;
  NoWork work_;
  Scheduler scheduler_;
};

class ChainedHash final : public CorePath {
 public:
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) {
      event_.time = event_.time + Duration{1'000};
      hash_ = chain(hash_, event_);
    }
    use(hash_);
  }

 private:
  Event event_{{0}, Lane::device, "tick", 0};
  std::uint64_t hash_ = 0;
};

constexpr std::int64_t kSteps = 15;  // in a segment of 33.3 ms, as in the paper
constexpr Duration kSlot{2'222'222};

/// read(n) and emission(n) of a step; before every 15th step also the boundary.
class MapReads final : public CorePath {
 public:
  void run(std::int64_t count) override {
    for (const std::int64_t end = n_ + count; n_ < end; ++n_) {
      const RealTime at{n_ * kSlot.ns};
      if (n_ % kSteps == 0) map_.boundary(n_, at);
      use(map_.read(n_, at).read);
      use(map_.emission(n_, at + kSlot));
    }
  }

 private:
  PhaseLockedMap map_{Duration{12'000'000}, Duration{15'000'000}};
  std::int64_t n_ = 0;
};

/// Times at which a ring is read: between the entries `back` and `back` + 1 before the newest, at a fraction that was drawn
/// earlier. The rings are filled once, because in a run another lane writes an entry for every one that is read.
constexpr Duration kTick{1'000'000};
constexpr std::size_t entries_for(int back) { return std::max<std::size_t>(64, static_cast<std::size_t>(back) + 2); }
class ReadTimes {
 public:
  explicit ReadTimes(int back) {
    const auto interval = static_cast<std::int64_t>(entries_for(back)) - 2 - back;
    std::uint64_t state = 1;
    for (RealTime& at : times_) at = RealTime{interval * kTick.ns + draw_ms(state).ns % kTick.ns};
  }
  RealTime next() { return times_[i_++ % times_.size()]; }

 private:
  std::array<RealTime, 256> times_;
  std::size_t i_ = 0;
};

template <class Ring>
void fill(Ring& ring) {
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(ring.capacity()); ++i)
    ring.push(RealTime{i * kTick.ns}, glm::dvec3(static_cast<double>(i), 1, 2));
}

/// The interaction buffer at a read time that lies `back` samples behind the newest.
class BufferReads final : public CorePath {
 public:
  explicit BufferReads(int back) : buffer_(entries_for(back)), times_(back) { fill(buffer_); }
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) use(buffer_.at(times_.next()));
  }

 private:
  SampleBuffer<glm::dvec3> buffer_;
  ReadTimes times_;
};

/// The force at a device tick that lies `back` emission times behind the newest.
class ForceReads final : public CorePath {
 public:
  explicit ForceReads(int back) : schedule_(entries_for(back), Emission::linear), times_(back) { fill(schedule_); }
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) use(schedule_.at(times_.next()));
  }

 private:
  ForceSchedule<glm::dvec3> schedule_;
  ReadTimes times_;
};

class RingWrites final : public CorePath {
 public:
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) buffer_.push(at_ = at_ + kTick, glm::dvec3(1, 2, 3));
  }

 private:
  SampleBuffer<glm::dvec3> buffer_{64};
  RealTime at_;
};

/// What a watched loop shows of a tick or of a step.
template <class Seen>
class Shown final : public CorePath {
 public:
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) {
      use(seen_);
      ring_.push(seen_);
    }
  }

 private:
  Seen seen_;
  SeenRing<Seen> ring_{LoopWatch::kTicks};
};

/// One segment of 15 steps.
class TimingSegments final : public CorePath {
 public:
  explicit TimingSegments(int percent)
      : timing_(make_programmed_timing({.visualization_variation = percent / 100.0, .step_variation = percent / 100.0})) {}
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) timing_->next(segment_);
    use(segment_.end);
  }

 private:
  std::unique_ptr<StepTiming> timing_;
  SegmentTiming segment_;
};

class SpringSteps final : public CorePath {
 public:
  SpringSteps() : solver_(make_solver(SolverKind::cpu_double, Scene{SpringScene{}})) {}
  void run(std::int64_t count) override {
    for (std::int64_t i = 0; i < count; ++i) {
      const std::array position_m{glm::dvec3(static_cast<double>(i) * 1e-6, 0, 0)};
      use(solver_->step(position_m));
    }
  }

 private:
  std::unique_ptr<Solver> solver_;
};

template <class Path, auto... arguments>
std::unique_ptr<CorePath> make() {
  return std::make_unique<Path>(arguments...);
}

constexpr std::pair<const char*, std::unique_ptr<CorePath> (*)()> kPaths[] = {
    {"timer_event_3_pending", make<TimerEvents, 3, false>},
    {"timer_event_20_pending", make<TimerEvents, 20, false>},
    {"timer_event_20_pending_kept", make<TimerEvents, 20, true>},
    {"work_event", make<WorkEvents>},
    {"chained_hash", make<ChainedHash>},
    {"map_read_and_emission", make<MapReads>},
    {"buffer_read_0_back", make<BufferReads, 0>},
    {"buffer_read_12_back", make<BufferReads, 12>},
    {"buffer_read_18400_back", make<BufferReads, 18'400>},  // 2.3 s at 8 kHz
    {"force_read_0_back", make<ForceReads, 0>},
    {"force_read_6_back", make<ForceReads, 6>},
    {"force_read_920_back", make<ForceReads, 920>},  // 2.3 s at 400 Hz
    {"ring_write", make<RingWrites>},
    {"shown_tick", make<Shown<SeenTick>>},
    {"shown_step", make<Shown<SeenStep>>},
    {"periodic_segment", make<TimingSegments, 0>},
    {"varying_segment", make<TimingSegments, 10>},
    {"spring_step", make<SpringSteps>},
};

}  // namespace

std::vector<std::string> core_path_names() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : kPaths) names.emplace_back(name);
  return names;
}

std::unique_ptr<CorePath> make_core_path(const std::string& name) {
  for (const auto& [known, maker] : kPaths) {
    if (known == name) return maker();
  }
  return nullptr;
}

}  // namespace evenstep::bench
