#pragma once
/// How long a piece of work takes: the models of step_timing.h, one class each. No model knows when anything runs.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/scheduler/random.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

/// floor(duration * factor + 1/2), at least 1 ns and at most 2^62 ns. factor = 1 gives the duration.
Duration scaled(Duration duration, double factor);

/// V, s and N after the changes so far; in a hitch, V is the hitch's.
class MeansInForce {
 public:
  struct Means {
    Duration visualization;
    Duration step;
    std::vector<int> steps;
  };
  explicit MeansInForce(const ProgrammedTiming& timing);
  /// The means of a segment that begins at `begin`. Call in order of time.
  const Means& at(RealTime begin);

 private:
  bool hitches(RealTime begin);

  std::optional<Disturbed> disturbed_;

  Means means_;
  Duration visualization_;  // outside of hitches
  std::vector<TimingChange> changes_;
  std::size_t next_change_ = 0;
  std::optional<Hitch> hitch_;
  RealTime next_hitch_;
};

/// Draw n of a length that varies by this law; `variation` 0 gives the mean.
Duration varied(const RandomStream& stream, std::uint64_t n, Duration mean, JitterLaw law, double variation);

/// The probability that a piece of work of length d is hit: 1 - exp(-rate d).
double hit_probability(double rate_Hz, Duration work);
/// The cost that belongs to a uniform draw u in (0, 1), by the inverse CDF.
Duration bounded_pareto(const Preemption& preemption, double u);
double mean_of(const Preemption& preemption);

/// The time that spikes add to step n of length d.
class SpikeCost {
 public:
  explicit SpikeCost(const ProgrammedTiming& timing);
  Duration of(std::uint64_t n, Duration work) const;

 private:
  std::optional<Spikes> spikes_;
  RandomStream hits_;
};

/// The time that pre-emption adds to piece of work n of length d. Steps and visualizations have separate streams.
class PreemptionCost {
 public:
  PreemptionCost(const ProgrammedTiming& timing, const std::string& component);
  Duration of(std::uint64_t n, Duration work) const;

 private:
  std::optional<Preemption> preemption_;
  RandomStream hits_, costs_;
};

/// The factor on V that `regimes` gives segment k. Call once per segment, in order.
class RegimeChain {
 public:
  explicit RegimeChain(const ProgrammedTiming& timing);
  double next_factor();

 private:
  std::optional<Regimes> regimes_;
  RandomStream stream_;
  std::uint64_t k_ = 0;
  bool slow_ = false;
};

/// The length of visualization k; empty if it is dropped or there is none. Call once per segment, in order.
class VisualizationCost {
 public:
  explicit VisualizationCost(const ProgrammedTiming& timing);
  std::optional<Duration> next(RealTime segment, Duration mean, double drift);

 private:
  int count(std::uint64_t k) const;  ///< 0 dropped, 2 merged

  JitterLaw law_;
  double variation_, dropped_, merged_;
  std::optional<Disturbed> disturbed_;
  RandomStream lengths_, counts_;
  RegimeChain regime_;
  PreemptionCost preemption_;
  std::uint64_t k_ = 0;
};

/// The length of step n = 0, 1, ...; call once per step, in order.
class StepCost {
 public:
  explicit StepCost(const ProgrammedTiming& timing);
  /// `segment`: when its segment begins. `factor` is that of drift times that of the step's place in the segment.
  Duration next(RealTime segment, Duration mean, double factor);

 private:
  JitterLaw law_;
  double variation_;
  std::optional<Disturbed> disturbed_;
  RandomStream lengths_;
  SpikeCost spikes_;
  PreemptionCost preemption_;
  std::uint64_t n_ = 0;
};

/// Visualizations and steps that take turns: each begins when the one before it ends.
class Turns {
 public:
  explicit Turns(const ProgrammedTiming& timing) : steps_(timing), first_step_(timing.first_step) {}
  void append_visualization(SegmentTiming& segment, std::optional<Duration> length);
  void append_step(SegmentTiming& segment, Duration mean, double drift);
  RealTime end;  ///< of what has been appended, and of the wait after it

 private:
  Interval append(Duration duration);

  StepCost steps_;
  double first_step_;
  bool after_visualization_ = false;
};

/// 1 + r B: the factor of drift on a duration in a segment that begins at B.
double drift_factor(double drift_per_s, RealTime begin);

/// The schedule of a loop with ProgrammedTiming::accumulator.
std::unique_ptr<StepTiming> make_accumulator_timing(const ProgrammedTiming& timing);

}  // namespace evenstep::internal
