#pragma once
/// What a device plays of samples that come one by one, late, in another order or not at all. Each has a stamp, and is
/// there from its arrival on. t is the time of a tick, x_i the samples that are there, in the order of their stamps s_i:
///
///   scheduled      s is when it is due: the line between the last s_i <= t and the next one; or held, x_i
///   newest         x_i of the largest s_i, whenever that was ("zero-order hold"); one that comes after a newer one is
///   dropped holt_winters   Holt's double exponential smoothing, continued. C. C. Holt, "Forecasting seasonals and trends by
///                  exponentially weighted moving averages" (1957; International Journal of Forecasting 20, 2004); as a
///                  predictor of motion J. J. LaViola, "Double exponential smoothing" (Eurographics VE 2003). For the next
///                  sample x at s, d after the one before:
///                    p = l + b d;   l' = a x + (1 - a) p;   b' = g (l' - l) / d + (1 - g) b;   value l + b (t - s)
///                  from l = x_0, b = 0; on x = v s + c the slope b converges to v geometrically if 0 < a < 1, 0 < g <= 1.
///                  It stops `furthest` after s.
///   polyphase      a windowed sinc (J. O. Smith, "Digital audio resampling", CCRMA 2002; the resampler of F. Adriaensen,
///                  "Controlling adaptive resampling", LAC 2012, whose rate a delay-locked loop controls):
///                    sum_i w((t - s_i) / T) x_i / sum_i w((t - s_i) / T),  w(u) = sinc(u) kaiser(u / taps), |u| < taps
///                  with `taps` on each side. The division keeps a constant a constant where one is lost.
///
/// Late: scheduled and polyphase need samples after t; without them the newest is held, and the status is `underrun`.
/// holt_winters past `furthest` is one, too. Samples that no longer fit (more than `capacity`) are forgotten, oldest first.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "evenstep/remap/sample.h"

namespace evenstep {

enum class Resampling : std::uint8_t { scheduled, scheduled_held, newest, holt_winters, polyphase };

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

  /// A sample has come. Stamps may come in any order.
  void arrive(RealTime stamp, const Value& value) {
    const auto later = [](RealTime at, const Sample& sample) { return at < sample.stamp; };
    const auto place = std::upper_bound(kept_.begin(), kept_.end(), stamp, later);
    const bool newest = place == kept_.end();
    overtaken_ += !newest;
    if (newest) smooth(stamp, value);
    kept_.insert(place, {stamp, value});
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
      case Resampling::polyphase:
        return interpolated(at);
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

  Reading<Value> interpolated(RealTime at) const {
    const RealTime newest = kept_.back().stamp;
    if (at < kept_.front().stamp) return {Value{}, ReadStatus::empty, newest};
    if (newest < at) return {kept_.back().value, ReadStatus::underrun, newest};
    // All taps that lie ahead must be there, but for the last, whose weight is next to nothing.
    const bool short_of = newest < at + spec_.period * (spec_.taps - 1);
    Value sum{};
    double weights = 0;
    const auto end = after(at + spec_.period * spec_.taps);
    for (auto one = after(at - spec_.period * spec_.taps); one != end; ++one) {
      const double w = internal::windowed_sinc(ratio(at - one->stamp, spec_.period), spec_.taps);
      sum = sum + one->value * w;
      weights += w;
    }
    if (!(weights > 0.25)) return {kept_.back().value, ReadStatus::underrun, newest};  // too few samples around `at`
    return {sum * (1 / weights), short_of ? ReadStatus::underrun : ReadStatus::inside, newest};
  }

  ResamplerSpec spec_;
  std::vector<Sample> kept_;  // by stamp
  Value level_{}, trend_{};   // l and b, per s
  std::int64_t overtaken_ = 0;
};

}  // namespace evenstep
