#pragma once
/// Where the device lane and the simulation lane meet: per device one ring of samples down (Figure 3 a) and one ring of
/// forces, or of contact records, back (Figure 4 e), each with one writer and one reader. Everything a lane learns that the schedule does not
/// determine passes through here: the device's samples, live reads of the clock, and the head each ring read saw. On a wall
/// clock these are kept (`DeviceInputs`); giving the same back replays the run exactly.

#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "evenstep/device/device_spring.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/motion.h"
#include "evenstep/device/renderer.h"
#include "evenstep/remap/filters.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/latency_budget.h"
#include "evenstep/remap/sample_buffer.h"
#include "evenstep/remap/slot_map.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/sim/scene.h"

namespace evenstep {

/// What one device tick took from outside.
struct TickInput {
  DeviceSample sample;
  RealTime played_at;            ///< live clock when the force was looked up
  std::uint64_t force_head = 0;  ///< forces visible then
  std::uint64_t order = 0;       ///< counts the ticks of all devices in the order they ran
};

/// One device's recorded inputs: enough for an exact virtual twin of a live run.
struct DeviceInputs {
  std::vector<TickInput> ticks;                  ///< in order of ticks run
  std::vector<std::uint64_t> interaction_heads;  ///< per step
  std::vector<DeviceSpring> springs;             ///< what the device rendered by itself, each time it was asked to
};

/// The force of one tick as it was rendered from the schedule, before the guard.
struct Played {
  RealTime at;
  Reading<glm::dvec3> force_N;           ///< all of it
  std::optional<DeviceSpring> spring;    ///< what of it the device may render by itself; none: it is not asked

  /// What the device renders by itself, of a hand at `hand_m`.
  glm::dvec3 sprung_N(const glm::dvec3& hand_m) const {
    return spring ? evenstep::force_N(*spring, hand_m) : glm::dvec3(0);
  }
  /// When the newest force of the schedule was due; none before the first.
  std::optional<RealTime> due() const {
    return force_N.status == ReadStatus::empty ? std::nullopt : std::optional(force_N.newest);
  }
};

/// The contacts that a local model was given in a run.
struct RenderedContactsSummary {
  double stiffest_N_per_m = 0;            ///< in the stiffest direction, before any cap
  std::int64_t softened = 0;              ///< records that the cap made softer
};

namespace internal {
class RenderedSchedule;
}

/// How a tick's force is made of its scheduled record (device/renderer.h).
struct RenderForce {};
struct RenderLocal {
  double alpha = 1;
  bool knows_gap = true;
  bool by_device = false;                 ///< as springs of the device, as far as it can
  double most_N_per_m = std::numeric_limits<double>::infinity();  ///< stiffer contacts are played as stiff as this
};
struct RenderSmith {
  SpringMode mode;
  Duration memory;                        ///< how long a record's read time stays within reach
};

/// One device's two rings and what happens on their way.
struct LinkSpec {
  std::size_t samples = 0;                ///< capacity of the ring of samples
  std::size_t forces = 0;                 ///< capacity of the ring of forces
  std::size_t spare = 0;                  ///< of both: how far a lane may go on while the other one reads at an earlier head
  Emission emission = Emission::linear;
  std::variant<RenderForce, RenderLocal, RenderSmith> render;
  SamplingGrid ticks;                     ///< when its samples are due
  Extrapolation interaction;              ///< a read newer than the newest sample; default: clamp
  Extrapolation force;                    ///< a tick past the last emission time; default: hold. RenderForce only
  bool gate = false;                      ///< a step waits for its sample
  /// Strategy `filtered`: of what the steps read (at the step rate), or of what the ticks play (at the device's rate).
  std::optional<FilterSpec> interaction_filter, force_filter;
  Rate step_rate{450, 1};
};

class Exchange {
 public:
  explicit Exchange(const std::vector<LinkSpec>& links);
  virtual ~Exchange();
  int tool_count() const { return static_cast<int>(links_.size()); }

  // Device lane.
  /// Reads the device and makes its sample visible to the simulation lane.
  DeviceSample sense(int tool, const Scheduler& scheduler);
  /// The force to play now, under the hand as `sample` has it.
  Played play(int tool, const DeviceSample& sample, const Scheduler& scheduler);
  /// Asks the device for springs of its own, which the guard has seen; what it does render of them.
  virtual DeviceSpring render(int tool, const DeviceSpring& wanted) = 0;

  // Simulation lane.
  /// The hand at a slot's time, or the newest sample where the slot is not mapped.
  virtual Reading<glm::dvec3> hand(int tool, const Slot& slot);
  /// Policy `gate`: the step may not begin with this reading.
  bool must_wait(int tool, const Reading<glm::dvec3>& hand) const;
  /// When to look again: at the tick that brings the sample; where that one is late, soon after `now`.
  RealTime next_sample(int tool, const Slot& slot, RealTime now) const;
  void respond(int tool, RealTime emission, const ContactRecord& record);

  std::uint64_t samples(int tool) const { return links_[static_cast<std::size_t>(tool)].interaction.head(); }
  std::uint64_t forces(int tool) const;
  /// After the run; nothing of a device that plays forces or a mode.
  std::optional<RenderedContactsSummary> contacts(int tool) const;

 protected:
  virtual DeviceSample read_device(int tool, const Scheduler& scheduler) = 0;
  virtual TickInput look(int tool, const Scheduler& scheduler);
  virtual std::uint64_t interaction_head(int tool);

 private:
  struct Link {
    explicit Link(const LinkSpec& spec);
    LinkSpec spec;
    SampleBuffer<glm::dvec3> interaction;
    std::unique_ptr<internal::RenderedSchedule> forces;
    std::optional<Filter<glm::dvec3>> interaction_filter, force_filter;
  };
  std::deque<Link> links_;  // a Link does not move: its rings are shared between threads
};

/// Reads real (or simulated) devices; keeps what it learnt when asked to.
class DeviceExchange : public Exchange {
 public:
  DeviceExchange(const std::vector<LinkSpec>& links, std::vector<HapticDevice*> devices,
                 std::vector<DeviceInputs>* keep = nullptr);
  DeviceSpring render(int tool, const DeviceSpring& wanted) override;

 protected:
  DeviceSample read_device(int tool, const Scheduler& scheduler) override;
  TickInput look(int tool, const Scheduler& scheduler) override;
  std::uint64_t interaction_head(int tool) override;

 private:
  std::vector<HapticDevice*> devices_;
  std::vector<DeviceInputs>* keep_;
  std::uint64_t ticks_run_ = 0;
};

/// The reference twin: reads the programmed motion itself, so that no buffer and no sampling stands between.
class IdealExchange final : public DeviceExchange {
 public:
  IdealExchange(const std::vector<LinkSpec>& links, std::vector<HapticDevice*> devices,
                std::vector<ProgrammedMotion> motions);
  Reading<glm::dvec3> hand(int tool, const Slot& slot) override;

 private:
  std::vector<ProgrammedMotion> motions_;
};

/// Gives recorded inputs back. With heads: an exact twin (the lanes must then run on two schedulers, in an order that the
/// heads allow: `next_*_ready`). Without: a shadow, another strategy over the same samples and completions.
class RecordedExchange final : public Exchange {
 public:
  RecordedExchange(const std::vector<LinkSpec>& links, const std::vector<DeviceInputs>& inputs, bool use_heads);
  /// The next tick (of the device whose turn it is) finds the forces that its recorded head names.
  bool next_tick_ready() const;
  /// The next step finds the samples that its recorded heads name.
  bool next_step_ready() const;
  /// Of a shadow nothing: nobody asked the device, and the force is the same without.
  DeviceSpring render(int tool, const DeviceSpring& wanted) override;

 protected:
  DeviceSample read_device(int tool, const Scheduler& scheduler) override;
  TickInput look(int tool, const Scheduler& scheduler) override;
  std::uint64_t interaction_head(int tool) override;

 private:
  const std::vector<DeviceInputs>& inputs_;
  bool use_heads_;
  std::vector<std::size_t> next_tick_;
  std::vector<std::size_t> next_step_;
  std::vector<std::size_t> next_spring_;
};

}  // namespace evenstep
