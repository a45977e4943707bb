#pragma once
/// What a device plays of samples that come one by one, late, in another order or not at all. Each sample has a stamp, and
/// is there from its arrival on. t is the time of a tick, x_i the samples that are there, in the order of their stamps s_i:
///
///   scheduled      a sample is due at its stamp: the line from x_i of the last s_i <= t to the next one; or held, x_i
///   newest         x_i of the largest s_i, however old ("zero-order hold"); one that comes after a newer one is dropped
///   holt_winters   Holt's double exponential smoothing, continued. C. C. Holt, "Forecasting seasonals and trends by
///                  exponentially weighted moving averages" (1957; International Journal of Forecasting 20, 2004); as a
///                  predictor of motion J. J. LaViola, "Double exponential smoothing" (Eurographics VE 2003). For the next
///                  sample x at s, d after the one before:
///                    p = l + b d;   l' = a x + (1 - a) p;   b' = g (l' - l) / d + (1 - g) b;   value l + b (t - s)
///                  from l = x_0, b = 0; on x = v s + c the slope b converges to v geometrically if 0 < a < 1, 0 < g <= 1.
///                  The line stops `furthest` after s.
///   interpolated   what game engines draw: from the last but one towards the last, x_k of the largest s_k,
///                    x_(k-1) + (x_k - x_(k-1)) clamp((t - s_k) / T, 0, 1)
///                  which is one T late (G. Fiedler, "Fix your timestep!", 2004)
///   polyphase      a windowed sinc (J. O. Smith, "Digital audio resampling", CCRMA 2002; the resampler of F. Adriaensen,
///                  "Controlling adaptive resampling", LAC 2012, whose rate a delay-locked loop controls):
///                    sum_i w((t - s_i) / T) x_i / sum_i w((t - s_i) / T),  w(u) = sinc(u) kaiser(u / taps), |u| < taps
///                  with `taps` on each side. The division keeps a constant a constant. The x_i are the samples that are
///                  there, and those missing between them, which are put on the line between their neighbours a and b:
///                    missing(a, b) = max(round((s_b - s_a) / T), n_b - n_a, 1) - 1, evenly spaced,
///                  with the samples' numbers n where the source has them. A number counts only up to two per period, so
///                  that a source that begins anew from another number does no harm. Without this a lost sample is a jolt:
///                  next to it the other weights nearly cancel.
///                  Ahead of the newest sample, where no neighbour has come yet, the line through the last two is continued,
///                  T apart (two that are closer than T count as T apart, so that a burst is no steep line). Behind the
///                  oldest nothing is added. A sample that comes after all replaces its stand-in on the line.
///
/// Late: scheduled and polyphase need samples after t; without them the newest is held, and the status is `underrun`.
/// polyphase underruns as soon as fewer than taps - 1 periods after t are there, because it then plays what it has continued
/// itself. It also underruns where its weights sum up to 1/4 or less, which happens only in bursts of samples: it then plays
/// the line between the two samples around t. holt_winters underruns past `furthest`. Samples that no longer fit (more than
/// `capacity`) are forgotten, oldest first.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "evenstep/remap/sample.h"

namespace evenstep {

enum class Resampling : std::uint8_t { scheduled, scheduled_held, newest, holt_winters, interpolated, polyphase };

struct ResamplerSpec {
  Resampling kind = Resampling::scheduled;
  std::size_t capacity = 64;        ///< >= 2; polyphase: >= 2 taps + 1
  double level = 0.8, trend = 0.2;  ///< a and g
  Duration furthest{100'000'000};
  Duration period{10'000'000};  ///< T of the source, > 0
  int taps = 4;                 ///< >= 1
};

namespace internal {
/// w(u) above: sinc(u) times a Kaiser window of beta 6 (side lobes of the window below -60 dB).
double windowed_sinc(double u, int taps);
}  // namespace internal

template <class Value>
class Resampler {
 public:
  explicit Resampler(const ResamplerSpec& spec) : spec_(spec) { kept_.reserve(spec.capacity + 1); }

  /// A sample has come. Stamps may come in any order. `number` counts the samples that the source has made.
  void arrive(RealTime stamp, const Value& value, std::optional<std::int64_t> number = std::nullopt) {
    const auto later = [](RealTime at, const Sample& sample) { return at < sample.stamp; };
    const auto place = std::upper_bound(kept_.begin(), kept_.end(), stamp, later);
    const bool newest = place == kept_.end();
    overtaken_ += !newest;
    if (newest) smooth(stamp, value);
    kept_.insert(place, {stamp, value, number});
    if (kept_.size() > spec_.capacity) kept_.erase(kept_.begin());
  }
  /// What is played at `at`. `newest` of the reading is the largest stamp.
  Reading<Value> at(RealTime at) const {
    if (kept_.empty()) return {};
    switch (spec_.kind) {
      case Resampling::newest:
        return {kept_.back().value, ReadStatus::inside, kept_.back().stamp};
      case Resampling::holt_winters:
        return continued(at);
      case Resampling::interpolated:
        return between_last_two(at);
      case Resampling::polyphase:
        return filtered(at);
      case Resampling::scheduled:
      case Resampling::scheduled_held:
        break;
    }
    return scheduled(at);
  }
  std::int64_t overtaken() const { return overtaken_; }  ///< came after one with a later stamp
  const Value& trend_per_s() const { return trend_; }    ///< b of holt_winters

 private:
  struct Sample {
    RealTime stamp;
    Value value;
    std::optional<std::int64_t> number;
  };
  /// The weighted sum of `polyphase`.
  struct Sum {
    Value value{};
    double weights = 0;
  };

  void smooth(RealTime stamp, const Value& value) {
    if (kept_.empty()) {
      level_ = value;
      trend_ = value - value;
      return;
    }
    const double d = seconds(stamp - kept_.back().stamp);
    if (d <= 0) return;
    const Value before = level_;
    level_ = lerp(before + trend_ * d, value, spec_.level);
    trend_ = lerp(trend_, (level_ - before) * (1 / d), spec_.trend);
  }

  /// The first sample whose stamp is after `at`.
  auto after(RealTime at) const {
    return std::upper_bound(kept_.begin(), kept_.end(), at, [](RealTime t, const Sample& s) { return t < s.stamp; });
  }

  Reading<Value> scheduled(RealTime at) const {
    const auto later = after(at);
    const RealTime newest = kept_.back().stamp;
    if (later == kept_.begin()) return {Value{}, ReadStatus::empty, newest};
    const Sample& earlier = *(later - 1);
    if (spec_.kind == Resampling::scheduled_held) return {earlier.value, ReadStatus::inside, newest};
    if (later == kept_.end())
      return {earlier.value, earlier.stamp == at ? ReadStatus::inside : ReadStatus::underrun, newest};
    return {lerp(earlier.value, later->value, ratio(at - earlier.stamp, later->stamp - earlier.stamp)), ReadStatus::inside,
            newest};
  }

  Reading<Value> continued(RealTime at) const {
    const RealTime newest = kept_.back().stamp;
    const Duration ahead = at - newest;
    const ReadStatus status = ahead > spec_.furthest ? ReadStatus::underrun : ReadStatus::inside;
    return {level_ + trend_ * seconds(std::min(ahead, spec_.furthest)), status, newest};
  }

  /// 1 plus the number of samples missing between two neighbours: see above.
  std::int64_t parts(const Sample& a, const Sample& b) const {
    const std::int64_t gap = (b.stamp - a.stamp).ns, period = spec_.period.ns;
    std::int64_t parts = std::max<std::int64_t>((gap + period / 2) / period, 1);
    if (a.number && b.number && *b.number > *a.number && *b.number - *a.number <= 2 * gap / period + 1)
      parts = std::max(parts, *b.number - *a.number);
    return parts;
  }

  void weigh(Sum& sum, RealTime at, RealTime stamp, const Value& value) const {
    const double w = internal::windowed_sinc(ratio(at - stamp, spec_.period), spec_.taps);
    sum.value = sum.value + value * w;
    sum.weights += w;
  }
  /// The samples missing between a and b, as far as the window around `at` reaches.
  void weigh_missing(Sum& sum, RealTime at, const Sample& a, const Sample& b) const {
    const std::int64_t parts = this->parts(a, b), gap = (b.stamp - a.stamp).ns;
    if (parts == 1) return;
    const Duration reach = spec_.period * spec_.taps;
    const std::int64_t first = floor_mul_div((at - reach - a.stamp).ns, parts, gap) + 1;
    for (std::int64_t j = std::max<std::int64_t>(first, 1); j < parts; ++j) {
      const RealTime stamp = a.stamp + Duration{floor_mul_div(gap, j, parts)};
      if (stamp >= at + reach) return;
      weigh(sum, at, stamp, lerp(a.value, b.value, static_cast<double>(j) / static_cast<double>(parts)));
    }
  }
  /// The samples that have not come yet, on the line through the last two.
  void weigh_ahead(Sum& sum, RealTime at) const {
    const Sample& last = kept_.back();
    Value per_period = last.value - last.value;
    if (kept_.size() > 1) {
      const Sample& before = kept_[kept_.size() - 2];
      per_period = (last.value - before.value) * ratio(spec_.period, std::max(last.stamp - before.stamp, spec_.period));
    }
    for (std::int64_t j = 1; last.stamp + spec_.period * j < at + spec_.period * spec_.taps; ++j)
      weigh(sum, at, last.stamp + spec_.period * j, last.value + per_period * static_cast<double>(j));
  }

  Reading<Value> between_last_two(RealTime at) const {
    const Sample& last = kept_.back();
    const Sample& before = kept_.size() > 1 ? kept_[kept_.size() - 2] : last;
    const double w = ratio(std::clamp(at - last.stamp, Duration{}, spec_.period), spec_.period);
    return {lerp(before.value, last.value, w), ReadStatus::inside, last.stamp};
  }

  Reading<Value> filtered(RealTime at) const {
    const RealTime newest = kept_.back().stamp;
    if (at < kept_.front().stamp) return {Value{}, ReadStatus::empty, newest};
    if (newest < at) return {kept_.back().value, ReadStatus::underrun, newest};
    // All taps that lie ahead must be there, but for the last, whose weight is next to nothing.
    const bool short_of = newest < at + spec_.period * (spec_.taps - 1);
    Sum sum;
    auto one = after(at - spec_.period * spec_.taps);
    for (const auto end = after(at + spec_.period * spec_.taps); one != end; ++one) {
      if (one != kept_.begin()) weigh_missing(sum, at, *(one - 1), *one);
      weigh(sum, at, one->stamp, one->value);
    }
    if (one == kept_.end())
      weigh_ahead(sum, at);
    else if (one != kept_.begin())
      weigh_missing(sum, at, *(one - 1), *one);
    if (!(sum.weights > 0.25)) return {between(at), ReadStatus::underrun, newest};
    return {sum.value * (1 / sum.weights), short_of ? ReadStatus::underrun : ReadStatus::inside, newest};
  }

  /// The line between the two samples around `at`, which must lie between the first and the last.
  Value between(RealTime at) const {
    const auto later = after(at);
    const Sample& earlier = *(later - 1);
    if (later == kept_.end()) return earlier.value;
    return lerp(earlier.value, later->value, ratio(at - earlier.stamp, later->stamp - earlier.stamp));
  }

  ResamplerSpec spec_;
  std::vector<Sample> kept_;  // by stamp
  Value level_{}, trend_{};   // l and b, per s
  std::int64_t overtaken_ = 0;
};

}  // namespace evenstep
