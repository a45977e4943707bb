#include "evenstep/remap/adaptive_latency.h"

#include <algorithm>
#include <cassert>

namespace evenstep {

TrailingMaximum::TrailingMaximum(Duration window)
    : block_length_{std::max<std::int64_t>((window.ns + kBlocks - 1) / kBlocks, 1)} {}

void TrailingMaximum::add(RealTime time, Duration value) {
  if (!origin_) origin_ = time;
  const std::int64_t block = newest_block_ = std::max((time - *origin_).ns / block_length_.ns, newest_block_);
  const auto at = [&](std::size_t i) -> Kept& { return kept_[(first_ + i) % kept_.size()]; };
  while (count_ > 0 && at(count_ - 1).value <= value) --count_;
  while (count_ > 0 && at(0).block < block - kBlocks) {
    first_ = (first_ + 1) % kept_.size();
    --count_;
  }
  // The block already holds a larger value, so this one can never be the largest.
  if (count_ > 0 && at(count_ - 1).block == block) return;
  at(count_++) = {block, value};
}

AdaptiveLatency::AdaptiveLatency(const AdaptiveLatencyOptions& options)
    : options_(options), latency_(options.start), target_(options.start), needs_(options.window) {
  assert(options.least <= options.start && options.start <= options.most && options.margin.ns >= 0);
  assert(options.slew_ppm >= 0 && options.slew_ppm <= kMostSlew_ppm && options.window.ns > 0);
}

RealTime AdaptiveLatency::emission(RealTime read, RealTime ended) {
  if (!moves()) return in_order(read + latency_);
  if (last_read_) move(read - *last_read_);
  const RealTime emission = in_order(read + latency_);
  // in_order() can move the first emission only because of a force without a slot, which the sizing pass does not know.
  const RealTime effective_read = last_read_ ? emission - latency_ : read;
  const bool interpolated = options_.emission == Emission::linear && last_read_;
  learn(interpolated ? *last_read_ : effective_read, ended);
  last_read_ = effective_read;
  return emission;
}

RealTime AdaptiveLatency::emission(RealTime ended) { return in_order(ended); }

/// Moves L towards the target by at most slew * elapsed; the part below 1 ns is kept for the next step.
void AdaptiveLatency::move(Duration elapsed) {
  if (latency_ == target_ || elapsed.ns <= 0) return;
  constexpr std::int64_t kMillion = 1'000'000;
  const __int128 allowed = static_cast<__int128>(elapsed.ns) * options_.slew_ppm + carry_;
  carry_ = static_cast<std::int64_t>(allowed % kMillion);
  const Duration most{std::min(static_cast<std::int64_t>(allowed / kMillion), elapsed.ns - 1)};  // F(n) > F(n-1)
  latency_ += std::clamp(target_ - latency_, -most, most);
  if (latency_ == target_) carry_ = 0;
}

void AdaptiveLatency::learn(RealTime due_read, RealTime ended) {
  const Duration need = ended - due_read;
  needs_.add(due_read, need);
  target_ = std::clamp(needs_.largest() + options_.margin, options_.least, options_.most);
  if (need <= latency_ || target_ <= latency_) return;
  latency_ = target_;
  carry_ = 0;
  ++growths_;
}

RealTime AdaptiveLatency::in_order(RealTime emission) {
  if (last_emission_ && emission <= *last_emission_) {
    emission = *last_emission_ + Duration{1};
    ++repairs_;
  }
  last_emission_ = emission;
  return emission;
}

}  // namespace evenstep
