#pragma once
/// The exchange between the device lane and the simulation lane. Each device has one ring of samples that leads to the
/// simulation (Figure 3 a) and one ring of forces, or of contact records, that leads back (Figure 4 e), each with one writer
/// and one reader. Everything that a lane learns and that the schedule does not determine passes through here: the samples
/// of the device, live reads of the clock, and the head that each read of a ring saw. On a wall clock these inputs are kept
/// (`DeviceInputs`); a run that is given the same inputs again is an exact replay.

#include <array>
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
#include "evenstep/remap/chunk_player.h"
#include "evenstep/remap/filters.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/latency_budget.h"
#include "evenstep/remap/remap_steps.h"
#include "evenstep/remap/resampler.h"
#include "evenstep/remap/sample_buffer.h"
#include "evenstep/remap/slot_map.h"
#include "evenstep/reports/rows.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/sim/scene.h"

namespace evenstep {

/// What a device tick took from outside.
struct TickInput {
  DeviceSample sample;
  RealTime played_at;            ///< clock time at which the force was looked up
  std::uint64_t force_head = 0;  ///< number of forces visible then
  std::uint64_t order = 0;       ///< counts the ticks of all devices in the order in which they ran
};

/// The recorded inputs of one device: enough for an exact virtual twin of a live run.
struct DeviceInputs {
  Rows<TickInput> ticks;                  ///< in the order in which they ran
  Rows<std::uint64_t> interaction_heads;  ///< per step
  Rows<DeviceSpring> springs;             ///< the springs that the device rendered, for each time it was asked to
};

/// The force of one tick as it was rendered from the schedule, before the guard.
struct Played {
  RealTime at;
  Reading<glm::dvec3> force_N;         ///< the whole force
  std::optional<DeviceSpring> spring;  ///< the part that the device may render as springs; empty: it is not asked to

  /// The force of these springs on a hand at `hand_m`.
  glm::dvec3 sprung_N(const glm::dvec3& hand_m) const { return spring ? evenstep::force_N(*spring, hand_m) : glm::dvec3(0); }
  /// When the newest force of the schedule was due; empty before the first.
  std::optional<RealTime> due() const {
    return force_N.status == ReadStatus::empty ? std::nullopt : std::optional(force_N.newest);
  }
};

/// A summary of the contacts that a local model was given in a run.
struct RenderedContactsSummary {
  double stiffest_N_per_m = 0;  ///< in the stiffest direction, before any cap
  std::int64_t softened = 0;    ///< records that the cap made softer
};

/// The forces of a source: how the device plays them (resampler.h, chunk_player.h). They may come late, in another order or
/// not at all (StepEmission::arrives), and are played as forces only. Those of a map are stamped with their emission time,
/// those that an engine interpolates with the loop's own time at the end of their step, if it knows one, all others with the
/// begin of their step. A chunk continues the line through the forces of its step and the one before.
struct SourceForces {
  std::variant<ResamplerSpec, ChunkSpec> play;
};
/// How many of these forces a device was never given, or was given out of order.
struct SourceCounts {
  std::int64_t lost = 0;       ///< never came
  std::int64_t reordered = 0;  ///< came after one that was made later
};

/// What became of the forces (or contact records) of a device, and what its ticks found, so far.
struct ForceCounts {
  std::int64_t sent = 0;                ///< at some tick the newest that was due
  std::int64_t overtaken = 0;           ///< at the first tick at which it was due, a newer one was due as well
  std::int64_t dropped = 0;             ///< left the ring before a tick at which it was due
  std::array<std::int64_t, 4> ticks{};  ///< by the ReadStatus of their force
};

namespace internal {
class RenderedSchedule;
}

/// How the force of a tick is computed from its scheduled record (device/renderer.h).
struct RenderForce {};
struct RenderLocal {
  double alpha = 1;
  bool knows_gap = true;
  StiffnessPart part = StiffnessPart::all;
  bool coupled = false;    ///< the coupling to the other hand is played as well
  bool by_device = false;  ///< rendered as springs by the device itself as far as it can
  double most_N_per_m = std::numeric_limits<double>::infinity();  ///< stiffer contacts are played as stiff as this
  bool capped_together = false;  ///< the cap limits both hands' stiffness as one matrix (softened_together)
};
struct RenderSmith {
  SpringMode mode;
  Duration memory;  ///< how long a record's read time stays within reach
};

/// The two rings of a device, and what happens to their contents on the way.
struct LinkSpec {
  std::size_t samples = 0;  ///< capacity of the ring of samples
  std::size_t forces = 0;   ///< capacity of the ring of forces
  std::size_t spare = 0;    ///< for both: how far a lane may run ahead while the other reads at an older head
  Emission emission = Emission::linear;
  std::variant<RenderForce, RenderLocal, RenderSmith> render;
  SamplingGrid ticks;         ///< when its samples are due
  Extrapolation interaction;  ///< for reads newer than the newest sample; default: clamp
  Extrapolation force;        ///< for ticks past the last emission time; default: hold. RenderForce only
  bool gate = false;          ///< a step waits for its sample
  /// For strategy `filtered`: a filter on what the steps read (at the step rate), or on what the ticks play (at the rate of
  /// the device).
  std::optional<FilterSpec> interaction_filter, force_filter;
  Rate step_rate{450, 1};
  std::optional<SourceForces> source;  ///< RenderForce only
};

class Exchange {
 public:
  explicit Exchange(const std::vector<LinkSpec>& links);
  virtual ~Exchange();
  int tool_count() const { return static_cast<int>(links_.size()); }

  // Device lane.
  /// Reads the device, looks which forces are there, and then makes the sample visible to the simulation lane.
  DeviceSample sense(int tool, const Scheduler& scheduler);
  /// The force to play for a hand at the position of `sample`, from the forces that were there at the last sense().
  Played play(int tool, const DeviceSample& sample);
  /// Asks the device to render these springs, which must have passed the guard. Returns the springs that it does render.
  virtual DeviceSpring render(int tool, const DeviceSpring& wanted) = 0;

  // Simulation lane.
  /// The hand's position at the time of a slot, or the newest sample if the slot is not mapped.
  virtual Reading<glm::dvec3> hand(int tool, const Slot& slot);
  /// Policy `gate`: whether the step has to wait for a better reading than this.
  bool must_wait(int tool, const Reading<glm::dvec3>& hand) const;
  /// When a waiting step should look again: at the tick that would bring its sample if it had no age, then at each tick.
  RealTime next_sample(int tool, const Slot& slot, RealTime now) const;
  void respond(int tool, const StepEmission& emission, const ContactRecord& record);

  std::uint64_t samples(int tool) const { return links_[static_cast<std::size_t>(tool)].interaction.head(); }
  std::uint64_t forces(int tool) const;
  // Call these after the run.
  std::int64_t repeated_samples(int tool) const { return links_[static_cast<std::size_t>(tool)].repeated_samples; }
  std::int64_t pending_forces(int tool) const;  ///< due at none of the ticks
  const ForceCounts& force_counts(int tool) const { return links_[static_cast<std::size_t>(tool)].counts; }
  /// Empty unless the device renders a local model.
  std::optional<RenderedContactsSummary> contacts(int tool) const;
  /// Empty without a source.
  std::optional<SourceCounts> source_counts(int tool) const;

 protected:
  virtual DeviceSample read_device(int tool, const Scheduler& scheduler) = 0;
  virtual TickInput look(int tool, const Scheduler& scheduler);
  virtual std::uint64_t interaction_head(int tool);

 private:
  /// Where the other hand was at its last tick before this sample was read; nullptr if there is none. A tick at the same
  /// instant does not count, because it must not matter which of the two runs first.
  const glm::dvec3* other_hand_m(int tool, const DeviceSample& sample) const;

  struct Link {
    explicit Link(const LinkSpec& spec);
    void count(const TickInput& tick, ReadStatus found);
    LinkSpec spec;
    SampleBuffer<glm::dvec3> interaction;
    std::unique_ptr<internal::RenderedSchedule> forces;
    std::optional<Filter<glm::dvec3>> interaction_filter, force_filter;
    // Of the device lane:
    ForceCounts counts;
    std::uint64_t next_due = 0;  // the first force that was not due at the ticks so far
    std::int64_t repeated_samples = 0;
    std::array<std::optional<DeviceSample>, 2> sensed;  // the last two, the newest first
    TickInput looked;                                   // what the last sense() found
  };
  std::deque<Link> links_;  // a Link does not move: its rings are shared between threads
};

/// Reads real (or simulated) devices, and keeps their inputs if `keep` is given.
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

/// The exchange of the reference twin: its steps read the programmed motion itself, without buffer or sampling.
class IdealExchange final : public DeviceExchange {
 public:
  IdealExchange(const std::vector<LinkSpec>& links, std::vector<HapticDevice*> devices,
                std::vector<ProgrammedMotion> motions);
  Reading<glm::dvec3> hand(int tool, const Slot& slot) override;

 private:
  std::vector<ProgrammedMotion> motions_;
};

/// Plays back recorded inputs. With heads the run is an exact twin of the recorded one; its lanes must then run on two
/// schedulers, in an order that the heads allow (`next_*_ready`). Without heads it is a shadow: another strategy over the
/// same samples and completions.
class RecordedExchange final : public Exchange {
 public:
  RecordedExchange(const std::vector<LinkSpec>& links, const std::vector<DeviceInputs>& inputs, bool use_heads);
  /// Whether all forces that the next tick saw according to its recorded head are there; false if there is no next one. The
  /// next tick is that of the device whose turn it is.
  bool next_tick_ready() const;
  /// Whether all samples that the next step saw according to its recorded heads are there.
  bool next_step_ready() const;
  /// Whether some device has `by` samples more than the next step saw: in the recorded run, that step read before they came.
  bool samples_ahead(std::uint64_t by) const;
  /// The springs that the device rendered in the recorded run. For a shadow there are none, because the device was never
  /// asked; the whole force is the same without them.
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
