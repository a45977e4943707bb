#include "evenstep/scheduler/timing_fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "fit_statistics.h"

namespace evenstep {
namespace {

using namespace internal;

/// The share of segments that must show something before it counts as a rule.
constexpr double kRule = 0.1;
/// Two levels count as two if they are this many deviations apart, and by this factor.
constexpr double kLeastSeparation = 2.0, kLeastFactor = 1.1;
/// The gain of log-likelihood that justifies the second level: the BIC of 3 more parameters for 10 000 values.
constexpr double kLeastGain = 14;
/// Levels that last longer than this share of the recording were seen too rarely to come and go at random.
constexpr double kMostLength = 0.2;
/// A level that has less than this share of the segments must last this many times as long as it would by chance.
constexpr double kRare = 0.3, kLasting = 1.3;
/// The least numbers of hits from which the shape of a tail, and the size of a spike, can be determined.
constexpr std::int64_t kLeastTail = 10, kLeastSpikes = 5;
/// To be a spike, the commonest excess must exceed the least excess that counts as a hit by this factor: close to that
/// least one, a tail is densest as well.
constexpr double kSpikeAboveLeast = 1.5;
/// A step was hit if it is above the median by this many deviations of the logarithm and by this factor.
constexpr double kHitDeviations = 6, kLeastHitFactor = 1.2;
/// Visualizations are hitches if this many are alike and come at equal intervals of at least this many segments. By chance,
/// three intervals that long are equal to within a segment in only one of a thousand recordings.
constexpr std::size_t kLeastHitches = 4;
constexpr double kLeastHitchInterval = 8;
/// A slope is clear if it is this many errors from 0 and makes this difference over the recording.
constexpr double kClearDrift = 4, kLeastDrift = 0.02;
/// A drift that shortens all lengths must leave at least this share of them at the end.
constexpr double kLeastDrifted = 0.1;
/// A timing is paced by a grid if T varies by at most this share of what its work varies by, or by this share of T itself.
constexpr double kPacedVariation = 0.5, kPacedSteadiness = 0.005, kPacedIdle = 0.02;
constexpr double kSpreadShare = 0.5;  // of the idle time; a burst has none of it between its steps

struct Step {
  double begin_s = 0, ns = 0;
  double factor = 1;    ///< by how much it is longer than the usual step for a known reason; hits are not scaled by it
  bool first = false;   ///< after a visualization
  bool beside = false;  ///< begins while a visualization runs
};

/// The recording without its last segment, which may have been cut off.
struct Recording {
  Sample begins_s;           ///< per segment
  Sample lengths_ns;         ///< T
  Sample visualizations_ns;  ///< of the segments that have one
  Sample visualization_begins_s;
  std::vector<bool> has_visualization;
  std::vector<int> counts;
  std::vector<Step> steps;
  double idle_ns = 0, between_ns = 0;  // of idle_ns: between the steps of a segment
};

double ns(const Interval& interval) { return static_cast<double>((interval.end - interval.begin).ns); }

template <class Predicate>
double share_of(std::span<const SegmentTiming> segments, Predicate holds) {
  return static_cast<double>(std::count_if(segments.begin(), segments.end(), holds)) / static_cast<double>(segments.size());
}

SegmentOrder order_of(std::span<const SegmentTiming> segments) {
  if (share_of(segments, [](const SegmentTiming& s) { return s.overlaps(); }) > kRule) return SegmentOrder::concurrent;
  const auto steps_lead = [](const SegmentTiming& s) {
    return s.visualization && !s.steps.empty() && s.visualization->begin >= s.steps.back().end;
  };
  return share_of(segments, steps_lead) > 0.5 ? SegmentOrder::steps_first : SegmentOrder::visualization_first;
}

Recording gather(std::span<const SegmentTiming> segments, SegmentOrder order) {
  Recording out;
  bool after_visualization = false;
  for (std::size_t k = 0; k + 1 < segments.size(); ++k) {
    const SegmentTiming& segment = segments[k];
    out.begins_s.push_back(seconds(segment.begin));
    out.lengths_ns.push_back(static_cast<double>((segments[k + 1].begin - segment.begin).ns));
    out.has_visualization.push_back(segment.visualization.has_value());
    out.counts.push_back(static_cast<int>(segment.steps.size()));
    double idle = out.lengths_ns.back();
    if (segment.visualization) {
      out.visualizations_ns.push_back(ns(*segment.visualization));
      out.visualization_begins_s.push_back(out.begins_s.back());
      idle -= out.visualizations_ns.back();
      after_visualization = after_visualization || order == SegmentOrder::visualization_first;
    }
    const Interval* before = nullptr;
    for (const Interval& step : segment.steps) {
      if (before != nullptr && order != SegmentOrder::concurrent) out.between_ns += ns({before->end, step.begin});
      before = &step;
      const bool beside =
          segment.visualization && step.begin >= segment.visualization->begin && step.begin < segment.visualization->end;
      out.steps.push_back({seconds(step.begin), ns(step), 1, after_visualization, beside});
      after_visualization = false;
      if (order != SegmentOrder::concurrent) idle -= ns(step);
    }
    if (order == SegmentOrder::steps_first) after_visualization = segment.visualization.has_value();
    out.idle_ns += std::max(idle, 0.0);
  }
  return out;
}

/// Each segment is represented by its median step, so that hits do not count. `drift` scales visualizations and steps
/// alike, so it is proposed only if both show about the same.
void fit_drift(std::span<const SegmentTiming> segments, Recording& recording, TimingFit& fit) {
  Sample times, visualizations, steps;
  for (const SegmentTiming& segment : segments.first(segments.size() - 1)) {
    const bool usual = segment.visualization || recording.visualizations_ns.empty();
    if (!usual || segment.steps.empty()) continue;
    Sample own;
    for (const Interval& step : segment.steps) own.push_back(ns(step));
    times.push_back(seconds(segment.begin));
    visualizations.push_back(segment.visualization ? ns(*segment.visualization) : 0);
    steps.push_back(median(own));
  }
  fit.step_drift_per_s = relative_slope(times, steps);
  if (!recording.visualizations_ns.empty()) fit.visualization_drift_per_s = relative_slope(times, visualizations);
  const auto is_clear = [&](FittedNumber slope) {
    return std::abs(slope.value) > kClearDrift * slope.error && std::abs(slope.value) * fit.seconds > kLeastDrift;
  };
  const FittedNumber v = fit.visualization_drift_per_s, s = fit.step_drift_per_s;
  if (recording.visualizations_ns.empty()) {
    fit.timing.drift_per_s = is_clear(s) ? s.value : 0;
  } else if ((is_clear(v) || is_clear(s)) && std::abs(v.value - s.value) <= 3 * std::hypot(v.error, s.error)) {
    // The mean of the two, weighted by the inverse squares of their errors.
    const double errors2 = v.error * v.error + s.error * s.error;
    const double weight = errors2 > 0 ? v.error * v.error / errors2 : 0.5;
    fit.timing.drift_per_s = (1 - weight) * v.value + weight * s.value;
  }
  // The line need not stay above 0 to the end of a recording that is not straight.
  if (1 + fit.timing.drift_per_s * fit.seconds < kLeastDrifted) fit.timing.drift_per_s = 0;
  const double drift = fit.timing.drift_per_s;
  for (std::size_t i = 0; i < recording.visualizations_ns.size(); ++i)
    recording.visualizations_ns[i] /= 1 + drift * recording.visualization_begins_s[i];
  for (Step& step : recording.steps) step.factor = 1 + drift * step.begin_s;
}

/// The shortest list of counts that gives the shares to within two standard errors, for example 14, 15, 15, 16.
std::vector<int> list_of(const std::vector<int>& counts) {
  std::map<int, double> shares;
  for (const int count : counts) shares[count] += 1.0 / static_cast<double>(counts.size());
  const double n = static_cast<double>(counts.size());
  std::vector<int> sorted = counts;
  std::sort(sorted.begin(), sorted.end());
  std::vector<int> list;
  for (std::size_t size = 1; size <= 20; ++size) {
    list.clear();
    for (std::size_t i = 0; i < size; ++i) list.push_back(sorted[(2 * i + 1) * sorted.size() / (2 * size)]);
    const bool close = std::all_of(shares.begin(), shares.end(), [&](const auto& each) {
      const double said = static_cast<double>(std::count(list.begin(), list.end(), each.first)) / static_cast<double>(size);
      return std::abs(said - each.second) <= 2 * std::sqrt(std::max(each.second * (1 - each.second), 0.0) / n) + 0.01;
    });
    if (close) break;
  }
  return list;
}

void fit_counts(const Recording& recording, TimingFit& fit) {
  const auto [least, most] = std::minmax_element(recording.counts.begin(), recording.counts.end());
  fit.least_steps = *least;
  fit.most_steps = *most;
  fit.mean_steps = static_cast<double>(recording.steps.size()) / static_cast<double>(recording.counts.size());
  fit.timing.steps = list_of(recording.counts);
  for (int& count : fit.timing.steps) count = std::max(count, 1);  // a scenario has a step in every segment
}

/// The visualizations of about twice the usual length, if there are clearly more of them than just below and above that.
std::vector<bool> merged_ones(const Sample& logs, double deviation) {
  const double twice = median(logs) + std::log(2.0), width = std::max(3 * deviation, 0.06);
  const auto within = [&](double from, double to) {
    return std::count_if(logs.begin(), logs.end(), [&](double x) { return x >= from && x < to; });
  };
  const auto inside = within(twice - width, twice + width);
  const auto beside = within(twice - 2 * width, twice - width) + within(twice + width, twice + 2 * width);
  const bool clear = width < 0.35 && inside >= 3 && inside > 3 * beside;
  std::vector<bool> merged;
  for (const double x : logs) merged.push_back(clear && std::abs(x - twice) < width);
  return merged;
}

bool are_two(const TwoLevels& levels) {
  const double distance = std::abs(levels.high - levels.low);
  const double share = static_cast<double>(std::count(levels.is_high.begin(), levels.is_high.end(), true)) /
                       static_cast<double>(levels.is_high.size());
  const double length = 1 / levels.leave;
  // Where a value's level does not depend on the value before, it changes at a rate of 2 p (1 - p): such values are hits.
  const double lasts = 2 * share * (1 - share) * length;
  if (std::min(share, 1 - share) < kRare && lasts > 1 / kLasting && lasts < kLasting) return false;
  return length < kMostLength * static_cast<double>(levels.is_high.size()) && levels.gain > kLeastGain &&
         distance > kLeastSeparation * levels.deviation && distance > std::log(kLeastFactor) && share > kRule &&
         share < 1 - kRule;
}

void put_jitter(const FittedLength& length, JitterLaw& law, double& variation) {
  law = length.is_uniform() ? JitterLaw::uniform : JitterLaw::log_normal;
  variation = std::min(length.is_uniform() ? length.half_width : length.variation, 1.0);
}

/// Removes the levels: both become V of the model, which is the mean over the segments.
void fit_regimes(const TwoLevels& levels, Sample& visualizations, TimingFit& fit) {
  const double low = std::exp(std::min(levels.low, levels.high)), high = std::exp(std::max(levels.low, levels.high));
  const bool named_rightly = levels.high > levels.low;
  const auto slow = std::count(levels.is_high.begin(), levels.is_high.end(), named_rightly);
  fit.slow_share = static_cast<double>(slow) / static_cast<double>(visualizations.size());
  fit.regime_separation = std::abs(levels.high - levels.low) / levels.deviation;
  // A stay has at least one segment; 1 % more, because the share and the length are written with three digits.
  const double least_length = 1.01 / (2 * std::min(fit.slow_share, 1 - fit.slow_share));
  fit.timing.regimes = Regimes{high / low, std::max(least_length, 1 / levels.leave), fit.slow_share};
  const double mean = (1 - fit.slow_share) * low + fit.slow_share * high;
  for (std::size_t i = 0; i < visualizations.size(); ++i)
    visualizations[i] *= mean / (levels.is_high[i] == named_rightly ? high : low);
}

/// The period of hitches that begin at `times`: the roundest period for which they are the first visualizations at or after
/// its multiples; if there is none, their mean distance.
double hitch_period_s(const Sample& times, double segment_s) {
  const double longest_s = 1.1 * segment_s;  // a hitch may come that long after its multiple
  const double mean = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  double least = 0, most = times.back();
  for (const double time : times) {
    const double multiple = std::max(std::round((time - 0.5 * segment_s) / mean), 1.0);
    least = std::max(least, (time - longest_s) / multiple);
    most = std::min(most, time / multiple);
  }
  for (double step = 10; step > 1e-6 && least < most; step /= 10) {
    const double round = std::floor(most / step + 1e-9) * step;
    if (round > least) return round;
  }
  return mean;
}

/// Finds hitches and removes them from the recording.
void fit_hitch(Recording& recording, TimingFit& fit) {
  Sample& lengths = recording.visualizations_ns;
  const double bound =
      median(lengths) * std::max(kLeastHitFactor, std::exp(kHitDeviations * robust_deviation(logarithms(lengths))));
  Sample longer;
  for (const double length : lengths) {
    if (length > bound) longer.push_back(length);
  }
  std::sort(longer.begin(), longer.end());
  const Cluster cluster = densest(longer);
  Sample times, alike, others, begins;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const bool hitch = lengths[i] > bound && std::abs(lengths[i] - cluster.center) <= 0.2 * cluster.center;
    (hitch ? alike : others).push_back(lengths[i]);
    (hitch ? times : begins).push_back(recording.visualization_begins_s[i]);
  }
  if (times.size() < kLeastHitches) return;
  Sample intervals;
  for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  const double usual = median(intervals), segment_s = median(recording.lengths_ns) * 1e-9;
  const double longest_s = segment_s + median(alike) * 1e-9;  // the segment beside a hitch, and the hitch itself
  const auto differs = [&](double interval) { return std::abs(interval - usual) > longest_s; };
  if (usual < kLeastHitchInterval * segment_s || std::any_of(intervals.begin(), intervals.end(), differs)) return;
  const Duration every{std::llround(1e9 * hitch_period_s(times, segment_s))};
  fit.timing.hitch = Hitch{every, {std::llround(median(alike))}};
  fit.hitches = static_cast<std::int64_t>(alike.size());
  lengths = std::move(others);
  recording.visualization_begins_s = std::move(begins);
}

/// Whether neighbours are at the same level no more often than by chance: then a single wide law describes them as well.
bool come_by_chance(const TwoLevels& levels) {
  const double share = static_cast<double>(std::count(levels.is_high.begin(), levels.is_high.end(), true)) /
                       static_cast<double>(levels.is_high.size());
  return 2 * share * (1 - share) / levels.leave < kLasting;
}

void fit_visualization(Recording& recording, TimingFit& fit) {
  const auto all = static_cast<double>(recording.has_visualization.size());
  fit.dropped = std::count(recording.has_visualization.begin(), recording.has_visualization.end(), false);
  if (recording.visualizations_ns.empty()) {
    fit.timing.visualization = {0};
    return;
  }
  fit.timing.dropped_visualization = static_cast<double>(fit.dropped) / all;
  fit_hitch(recording, fit);
  Sample durations = recording.visualizations_ns;
  const Sample logs = logarithms(durations);
  fit.lag_1 = lag_correlation(logs, 1);
  const TwoLevels levels = fit_two_levels(logs);
  if (are_two(levels) && !(come_by_chance(levels) && fit_length(durations).is_uniform())) {
    fit_regimes(levels, durations, fit);
  } else {
    const std::vector<bool> merged = merged_ones(logs, robust_deviation(logs));
    fit.merged = std::count(merged.begin(), merged.end(), true);
    fit.timing.merged_visualization = static_cast<double>(fit.merged) / all;
    Sample single;
    for (std::size_t i = 0; i < durations.size(); ++i) {
      if (!merged[i]) single.push_back(durations[i]);
    }
    durations = std::move(single);
  }
  fit.visualization = fit_length(durations);
  fit.timing.visualization = {std::llround(fit.visualization.mean_ns)};
  put_jitter(fit.visualization, fit.timing.visualization_law, fit.timing.visualization_variation);
}

/// The ratio of the median of the steps that `chosen` selects to that of the others, with its standard error.
template <class Chosen>
FittedNumber ratio_of(const std::vector<Step>& steps, Chosen chosen) {
  Sample in, out;
  for (const Step& step : steps) (chosen(step) ? in : out).push_back(std::log(std::max(step.ns / step.factor, 1.0)));
  if (in.size() < 10 || out.size() < 10) return {1, 0};
  const double ratio = std::exp(median(in) - median(out));
  // The standard error of a median is 1.25 times that of a mean.
  return {ratio, 1.25 * ratio * robust_deviation(in) / std::sqrt(static_cast<double>(in.size()))};
}

/// Decides what hits are. If most of them add the same time they are spikes, and the others a tail; otherwise all are a
/// tail.
void fit_hits(TimingFit& fit) {
  std::sort(fit.excess_ns.begin(), fit.excess_ns.end());
  const auto hits = static_cast<std::int64_t>(fit.excess_ns.size());
  const Cluster cluster = densest(fit.excess_ns);
  const auto alike = [&](double x) { return std::abs(x - cluster.center) <= 0.2 * cluster.center; };
  fit.alike = std::count_if(fit.excess_ns.begin(), fit.excess_ns.end(), alike);
  if (!(fit.work_s > 0)) return;  // most steps take no time: there is nothing that a hit could come during
  const bool spikes =
      2 * fit.alike >= hits && fit.alike >= kLeastSpikes && cluster.center > kSpikeAboveLeast * fit.hit_above_ns;
  Sample others;
  for (const double excess : fit.excess_ns) {
    if (!spikes || !alike(excess)) others.push_back(excess);
  }
  // For steps of mean length d, rate = -log(1 - hits / steps) / d, which also holds if hits are not rare.
  const auto rate = [&](double count) {
    const double steps = static_cast<double>(fit.step.count + hits);
    return -std::log1p(-std::min(count / steps, 0.999)) * steps / fit.work_s;
  };
  if (spikes) fit.timing.spikes = Spikes{rate(static_cast<double>(fit.alike)), {std::llround(cluster.center)}};
  if (static_cast<std::int64_t>(others.size()) < kLeastTail) return;
  // Steps longer by less than half a nanosecond would give a cost of 0, of which there is no Pareto law.
  const double least = std::max(others.front(), 1.0), most = std::max(others.back(), least);
  const double tail = fit_tail(others, least, most);
  fit.timing.preemption =
      Preemption{rate(static_cast<double>(others.size())), {std::llround(least)}, {std::llround(most)}, tail};
  const double q = std::pow(least / most, tail);
  if (most <= least) return;
  fit.tail_distance = kolmogorov_distance(others, [&](double x) { return (1 - std::pow(least / x, tail)) / (1 - q); });
}

/// Pre-emption hits visualizations too. Hits small enough to lie within 5 deviations are contained in the fitted mean, and
/// the model adds them once more; returns how much it adds.
double added_by_preemption_ns(const TimingFit& fit) {
  if (!fit.timing.preemption || fit.visualization.count == 0) return 0;
  const Preemption all = *fit.timing.preemption;
  const double deviation = std::sqrt(std::log1p(fit.visualization.variation * fit.visualization.variation));
  const double within = fit.visualization.median_ns * std::expm1(5 * deviation);
  const double least = static_cast<double>(all.least.ns), most = static_cast<double>(all.most.ns);
  if (within <= least) return 0;
  Preemption small = all;
  small.most = {std::llround(std::min(within, most))};
  const double share =
      within >= most ? 1 : (1 - std::pow(least / within, all.tail)) / (1 - std::pow(least / most, all.tail));
  const ProgrammedTiming one{.visualization = fit.timing.visualization, .step = fit.timing.step, .preemption = small};
  const double added = share * (mean_timing(one).visualization_ns - static_cast<double>(one.visualization.ns));
  return std::min(added, 0.5 * fit.visualization.mean_ns);
}

void fit_steps(Recording& recording, TimingFit& fit) {
  if (fit.timing.order == SegmentOrder::concurrent) {
    fit.slowdown = ratio_of(recording.steps, [](const Step& step) { return step.beside; });
    if (fit.slowdown.value - 1 > std::max(0.02, 3 * fit.slowdown.error)) fit.timing.slowdown = fit.slowdown.value;
  } else {
    fit.first_step = ratio_of(recording.steps, [](const Step& step) { return step.first; });
    fit.first_step.value -= 1;
    if (fit.first_step.value > std::max(0.02, 3 * fit.first_step.error)) fit.timing.first_step = fit.first_step.value;
  }
  Sample all, usual;
  for (Step& step : recording.steps) {
    step.factor *= step.beside ? fit.timing.slowdown : step.first ? 1 + fit.timing.first_step : 1;
    all.push_back(step.ns / step.factor);
  }
  const Sample logs = logarithms(all);
  const double center = median(all);
  fit.hit_above_ns = center * (std::max(kLeastHitFactor, std::exp(kHitDeviations * robust_deviation(logs))) - 1);
  for (const Step& step : recording.steps) {
    if (step.ns / step.factor <= center + fit.hit_above_ns) {
      usual.push_back(step.ns / step.factor);
    } else {
      fit.excess_ns.push_back(step.ns - center * step.factor);
    }
  }
  fit.step = fit_length(usual);
  fit.timing.step = Duration{std::max<std::int64_t>(std::llround(fit.step.mean_ns), 1)};
  put_jitter(fit.step, fit.timing.step_law, fit.timing.step_variation);
  fit.work_s = fit.step.mean_ns * 1e-9 * static_cast<double>(all.size());
  fit_hits(fit);
  fit.timing.visualization = {std::llround(fit.visualization.mean_ns - added_by_preemption_ns(fit))};
}

/// The rate as a whole number of Hz if that is right to 0.1 %, otherwise its period as a whole number of us.
Rate named_rate(double length_ns) {
  const double Hz = 1e9 / length_ns, whole = std::round(Hz);
  if (whole >= 1 && std::abs(Hz - whole) < 1e-3 * Hz) return {static_cast<std::int64_t>(whole), 1};
  return {1'000'000, std::max<std::int64_t>(std::llround(length_ns / 1000), 1)};
}

void fit_pace(const Recording& recording, TimingFit& fit) {
  const Sample logs = logarithms(recording.lengths_ns);
  fit.segment_median_ns = median(recording.lengths_ns);
  fit.segment_variation = robust_deviation(logs);
  double all = 0;
  for (const double length : recording.lengths_ns) all += length;
  fit.idle_share = recording.idle_ns / all;
  if (recording.idle_ns > 0) fit.between_share = recording.between_ns / recording.idle_ns;
  for (const double length : recording.lengths_ns) fit.late += length > 1.01 * fit.segment_median_ns;
  const ProgrammedTiming& timing = fit.timing;
  const double regimes = timing.regimes ? (timing.regimes->factor - 1) / (timing.regimes->factor + 1) : 0;
  const double lane = timing.order == SegmentOrder::concurrent ? 0 : fit.mean_steps;
  const double spread = static_cast<double>(timing.visualization.ns) * std::hypot(timing.visualization_variation, regimes);
  fit.work_variation =
      std::hypot(spread, fit.step.mean_ns * timing.step_variation * std::sqrt(lane)) / fit.segment_median_ns;
  const bool steady = fit.segment_variation < std::max(kPacedVariation * fit.work_variation, kPacedSteadiness);
  if (!steady || fit.idle_share <= kPacedIdle) return;
  const Rate grid = named_rate(fit.segment_median_ns);
  // Hits may use up the idle time: a timing that can never catch up with its grid is not paced.
  fit.timing.paced = mean_timing(timing).segment_ns <= 1e9 * period_s(grid);
  if (fit.timing.paced) fit.timing.segment = grid;
  fit.spread = fit.timing.paced && fit.between_share >= kSpreadShare;
}

}  // namespace

bool FittedLength::is_uniform() const {
  return half_width > 0 && uniform_distance < distance && uniform_distance < 1.63 / std::sqrt(static_cast<double>(count));
}

std::string fit_objection(std::span<const SegmentTiming> segments) {
  if (segments.size() < kLeastSegmentsToFit)
    return "holds " + std::to_string(segments.size()) + " segments; a fit needs at least " +
           std::to_string(kLeastSegmentsToFit);
  if (share_of(segments, [](const SegmentTiming& s) { return !s.steps.empty(); }) < kRule)
    return "has a step in fewer than one segment of ten; there is nothing to fit";
  return {};
}

TimingFit fit_timing(std::span<const SegmentTiming> segments) {
  assert(fit_objection(segments).empty());
  TimingFit fit;
  fit.timing.order = order_of(segments);
  Recording recording = gather(segments, fit.timing.order);
  fit.segments = static_cast<std::int64_t>(recording.counts.size());
  fit.seconds = seconds(segments.back().begin);
  fit_counts(recording, fit);
  fit_drift(segments, recording, fit);
  fit_visualization(recording, fit);
  fit_steps(recording, fit);
  fit_pace(recording, fit);
  return fit;
}

}  // namespace evenstep
