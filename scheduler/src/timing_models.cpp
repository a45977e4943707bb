#include "timing_models.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>
#include <utility>

#include "evenstep/time/reproducible_math.h"

namespace evenstep {
namespace internal {
namespace {

double power(double base, double exponent) { return reproducible::exp(exponent * reproducible::log(base)); }

Duration rounded(double ns) { return {static_cast<std::int64_t>(std::clamp(ns + 0.5, 1.0, 0x1p62))}; }

double mean_count(const std::vector<int>& steps) {
  return static_cast<double>(std::accumulate(steps.begin(), steps.end(), std::int64_t{0})) /
         static_cast<double>(steps.size());
}

/// (T - V) / mean(N) to the nearest ns; with T = 1e9 den / num that is (1e9 den - V num) count / (num sum).
Duration filling_step(const ProgrammedTiming& timing) {
  const std::int64_t sum = std::accumulate(timing.steps.begin(), timing.steps.end(), std::int64_t{0});
  if (sum == 0) return {0};  // no segment has a step
  const auto count = static_cast<std::int64_t>(timing.steps.size());
  const __int128 numerator = (static_cast<__int128>(1'000'000'000) * timing.segment.den -
                              static_cast<__int128>(timing.visualization.ns) * timing.segment.num) *
                             count;
  const __int128 denominator = static_cast<__int128>(timing.segment.num) * sum;
  return {static_cast<std::int64_t>((2 * numerator + denominator) / (2 * denominator))};
}

/// The length of a segment of a concurrent schedule: the grid's period, or the length of its visualization.
double concurrent_segment_ns(const ProgrammedTiming& timing, double visualization_ns) {
  const double grid_ns = 1e9 * static_cast<double>(timing.segment.den) / static_cast<double>(timing.segment.num);
  return timing.paced ? grid_ns : visualization_ns;
}

/// The time that the steps of a segment would need without slowdown: V / slowdown + T - V.
double concurrent_room_ns(const ProgrammedTiming& timing, double visualization_ns) {
  return visualization_ns / timing.slowdown + concurrent_segment_ns(timing, visualization_ns) - visualization_ns;
}

/// What hitches add to the mean visualization. A share T / every of the segments has one, so without a grid
/// T = usual + extra T / every.
double hitches_ns(const ProgrammedTiming& timing, double usual_segment_ns) {
  if (!timing.hitch) return 0;
  const double times = 1.0 - timing.dropped_visualization + timing.merged_visualization;
  const double extra = times * static_cast<double>((timing.hitch->visualization - timing.visualization).ns);
  const double every = static_cast<double>(timing.hitch->every.ns);
  const double grid_ns = 1e9 * static_cast<double>(timing.segment.den) / static_cast<double>(timing.segment.num);
  const double segment_ns = timing.paced ? grid_ns : usual_segment_ns / (1.0 - extra / every);
  return extra * std::min(segment_ns / every, 1.0);
}

}  // namespace

Interval Turns::append(Duration duration) {
  const RealTime begin = std::exchange(end, end + duration);
  return {begin, end};
}

void Turns::append_visualization(SegmentTiming& segment, std::optional<Duration> length) {
  if (!length) return;
  segment.visualization = append(*length);
  after_visualization_ = true;
}

void Turns::append_step(SegmentTiming& segment, Duration mean, double drift) {
  const bool first = std::exchange(after_visualization_, false);
  segment.steps.push_back(append(steps_.next(segment.begin, mean, first ? drift * (1.0 + first_step_) : drift)));
}

double drift_factor(double drift_per_s, RealTime begin) { return 1.0 + drift_per_s * seconds(begin); }

Duration scaled(Duration duration, double factor) {
  if (factor == 1) return duration;
  return rounded(static_cast<double>(duration.ns) * factor);
}

MeansInForce::MeansInForce(const ProgrammedTiming& timing)
    : disturbed_(timing.disturbed),
      means_{timing.visualization, starting_step(timing), timing.steps},
      visualization_(timing.visualization),
      changes_(timing.changes),
      hitch_(timing.hitch),
      next_hitch_{timing.hitch ? timing.hitch->every.ns : 0} {}

const MeansInForce::Means& MeansInForce::at(RealTime begin) {
  for (; next_change_ < changes_.size() && changes_[next_change_].at <= begin; ++next_change_) {
    const TimingChange& change = changes_[next_change_];
    if (change.visualization) visualization_ = *change.visualization;
    if (change.step) means_.step = *change.step;
    if (!change.steps.empty()) means_.steps = change.steps;
  }
  means_.visualization = hitches(begin) ? hitch_->visualization : visualization_;
  return means_;
}

bool MeansInForce::hitches(RealTime begin) {
  if (!hitch_ || begin < next_hitch_) return false;
  const std::int64_t every = hitch_->every.ns;
  next_hitch_ = RealTime{(begin.ns / every + 1) * every};
  return !disturbed_ || disturbed_->holds(begin);
}

Duration varied(const RandomStream& stream, std::uint64_t n, Duration mean, JitterLaw law, double variation) {
  if (law == JitterLaw::log_normal) return log_normal(stream, n, mean, variation);
  return scaled(mean, 1.0 + variation * (2.0 * stream.uniform(n) - 1.0));
}

double hit_probability(double rate_Hz, Duration work) {
  return 1.0 - reproducible::exp(-std::min(rate_Hz * seconds(work), 700.0));
}

Duration bounded_pareto(const Preemption& preemption, double u) {
  const double least = static_cast<double>(preemption.least.ns), most = static_cast<double>(preemption.most.ns);
  const double above_most = power(least / most, preemption.tail);
  const double ns = least * power(1.0 - u * (1.0 - above_most), -1.0 / preemption.tail);
  return std::clamp(rounded(ns), preemption.least, preemption.most);
}

/// The mean, the integral of x dF: least a / (a - 1) (1 - q^(a-1)) / (1 - q^a) with q = least / most; for a = 1 its limit.
double mean_of(const Preemption& preemption) {
  const double least = static_cast<double>(preemption.least.ns), most = static_cast<double>(preemption.most.ns);
  const double q = least / most, a = preemption.tail;
  if (q == 1) return least;
  if (a == 1) return -least * reproducible::log(q) / (1.0 - q);
  return least * a / (a - 1.0) * (1.0 - power(q, a - 1.0)) / (1.0 - power(q, a));
}

SpikeCost::SpikeCost(const ProgrammedTiming& timing) : spikes_(timing.spikes), hits_(timing.seed, "timing.spike") {}

Duration SpikeCost::of(std::uint64_t n, Duration work) const {
  if (!spikes_ || hits_.uniform(n) >= hit_probability(spikes_->rate_Hz, work)) return {};
  return spikes_->cost;
}

PreemptionCost::PreemptionCost(const ProgrammedTiming& timing, const std::string& component)
    : preemption_(timing.preemption), hits_(timing.seed, component), costs_(timing.seed, component + ".cost") {}

Duration PreemptionCost::of(std::uint64_t n, Duration work) const {
  if (!preemption_ || hits_.uniform(n) >= hit_probability(preemption_->rate_Hz, work)) return {};
  return bounded_pareto(*preemption_, costs_.uniform(n));
}

RegimeChain::RegimeChain(const ProgrammedTiming& timing) : regimes_(timing.regimes), stream_(timing.seed, "timing.regime") {}

double RegimeChain::next_factor() {
  if (!regimes_) return 1;
  const auto& [factor, mean_length, p] = *regimes_;
  const double mean_stay = 2.0 * mean_length * (slow_ ? p : 1.0 - p);
  const double change = k_ == 0 ? p : 1.0 / mean_stay;
  if (stream_.uniform(k_++) < change) slow_ = !slow_;
  return 1.0 / (1.0 - p + p * factor) * (slow_ ? factor : 1.0);
}

VisualizationCost::VisualizationCost(const ProgrammedTiming& timing)
    : law_(timing.visualization_law),
      variation_(timing.visualization_variation),
      dropped_(timing.dropped_visualization),
      merged_(timing.merged_visualization),
      disturbed_(timing.disturbed),
      lengths_(timing.seed, "timing.visualization"),
      counts_(timing.seed, "timing.visualization_count"),
      regime_(timing),
      preemption_(timing, "timing.preemption.visualization") {}

int VisualizationCost::count(std::uint64_t k) const {
  const double u = counts_.uniform(k);
  return u < dropped_ ? 0 : u < dropped_ + merged_ ? 2 : 1;
}

std::optional<Duration> VisualizationCost::next(RealTime segment, Duration mean, double drift) {
  const std::uint64_t k = k_++;
  const bool calm = disturbed_ && !disturbed_->holds(segment);
  const double factor = regime_.next_factor();
  const Duration in_regime = calm ? mean : scaled(mean, factor);
  const int times = calm ? 1 : count(k);
  if (mean.ns == 0 || times == 0) return std::nullopt;
  const Duration work = scaled(varied(lengths_, k, in_regime, law_, variation_), drift * times);
  return calm ? work : work + preemption_.of(k, work);
}

StepCost::StepCost(const ProgrammedTiming& timing)
    : law_(timing.step_law),
      variation_(timing.step_variation),
      disturbed_(timing.disturbed),
      lengths_(timing.seed, "timing.step"),
      spikes_(timing),
      preemption_(timing, "timing.preemption.step") {}

Duration StepCost::next(RealTime segment, Duration mean, double factor) {
  const std::uint64_t n = n_++;
  const Duration work = scaled(varied(lengths_, n, mean, law_, variation_), factor);
  if (disturbed_ && !disturbed_->holds(segment)) return work;
  return work + spikes_.of(n, work) + preemption_.of(n, work);
}

}  // namespace internal

double shortest_mean_stay(const Regimes& regimes) {
  return 2.0 * regimes.mean_length * std::min(regimes.slow_share, 1.0 - regimes.slow_share);
}

bool is_periodic(const ProgrammedTiming& timing) {
  const bool steady_visualization = timing.visualization_variation == 0 && !timing.regimes && !timing.hitch &&
                                    timing.dropped_visualization == 0 && timing.merged_visualization == 0;
  const bool steady_steps = timing.step_variation == 0 && timing.first_step == 0 && !timing.spikes;
  return !timing.accumulator && timing.order != SegmentOrder::concurrent && timing.steps.size() == 1 &&
         steady_visualization && steady_steps && !timing.preemption && timing.drift_per_s == 0 && timing.changes.empty();
}

Duration starting_step(const ProgrammedTiming& timing) {
  if (timing.step) return *timing.step;
  if (timing.order != SegmentOrder::concurrent) return internal::filling_step(timing);
  return internal::rounded(internal::concurrent_room_ns(timing, static_cast<double>(timing.visualization.ns)) /
                           internal::mean_count(timing.steps));
}

MeanTiming mean_timing(const ProgrammedTiming& timing) {
  using namespace internal;
  if (timing.disturbed) {
    ProgrammedTiming calm = timing;
    calm.disturbed.reset();
    calm.spikes.reset();
    calm.preemption.reset();
    calm.hitch.reset();
    calm.dropped_visualization = calm.merged_visualization = 0;
    return mean_timing(calm);  // regimes do not change the mean
  }
  const double single = 1.0 - timing.dropped_visualization - timing.merged_visualization;
  const Duration visualization = timing.visualization, step = starting_step(timing);
  MeanTiming mean;
  mean.visualization_ns = static_cast<double>(visualization.ns) * (single + 2.0 * timing.merged_visualization);
  mean.step_ns = static_cast<double>(step.ns);
  mean.steps = mean_count(timing.steps);
  if (timing.preemption) {
    const double rate = timing.preemption->rate_Hz, cost = mean_of(*timing.preemption);
    mean.visualization_ns += cost * (single * hit_probability(rate, visualization) +
                                     timing.merged_visualization * hit_probability(rate, visualization * 2));
    mean.step_ns += cost * hit_probability(rate, step);
  }
  if (timing.spikes) {
    mean.step_ns += static_cast<double>(timing.spikes->cost.ns) * hit_probability(timing.spikes->rate_Hz, step);
  }
  if (timing.order == SegmentOrder::concurrent) {
    mean.visualization_ns += hitches_ns(timing, mean.visualization_ns);
    mean.segment_ns = mean.visualization_ns;
    mean.steps = concurrent_room_ns(timing, mean.visualization_ns) / mean.step_ns;
    return mean;
  }
  const double after_visualization = 1.0 - timing.dropped_visualization;
  if (timing.accumulator) {
    const double steps_per_ns = 1e-9 * static_cast<double>(timing.accumulator->step_rate.num) /
                                static_cast<double>(timing.accumulator->step_rate.den);
    const double drawn_ns = mean.visualization_ns + after_visualization * timing.first_step * static_cast<double>(step.ns);
    const double grid_ns = 1e9 * static_cast<double>(timing.segment.den) / static_cast<double>(timing.segment.num);
    const double most = timing.accumulator->max_steps.value_or(std::numeric_limits<int>::max());
    const auto steps_with = [&](double more_ns) {
      const double load = mean.step_ns * steps_per_ns;  // the share of the time that the steps take
      if (timing.paced) return std::min(steps_per_ns * grid_ns, most);
      return load < 1 ? std::min(steps_per_ns * (drawn_ns + more_ns) / (1 - load), most) : most;
    };
    const double hitches = hitches_ns(timing, drawn_ns + steps_with(0) * mean.step_ns);
    mean.visualization_ns += hitches;
    mean.steps = steps_with(hitches);
    mean.segment_ns = drawn_ns + hitches + mean.steps * mean.step_ns;
    return mean;
  }
  mean.segment_ns = mean.visualization_ns + mean.steps * mean.step_ns +
                    after_visualization * timing.first_step * static_cast<double>(step.ns);
  const double hitches = hitches_ns(timing, mean.segment_ns);
  mean.visualization_ns += hitches;
  mean.segment_ns += hitches;
  return mean;
}

}  // namespace evenstep
