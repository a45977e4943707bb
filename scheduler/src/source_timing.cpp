#include "evenstep/scheduler/source_timing.h"

#include <cassert>
#include <utility>

#include "evenstep/scheduler/random.h"

namespace evenstep {
namespace {

constexpr std::int64_t kMillion = 1'000'000;

class SourceTiming final : public StepTiming {
 public:
  SourceTiming(std::unique_ptr<StepTiming> timing, const SourceSpec& source) : timing_(std::move(timing)), source_(source) {
    assert(source.clock_ppm > -kMillion && source.delay.ns >= 0 && source.jitter.ns >= 0 && source.late_by.ns >= 0);
  }

  bool next(SegmentTiming& segment) override {
    if (!timing_->next(segment)) return false;
    segment.begin = on_device_clock(segment.begin);
    segment.end = on_device_clock(segment.end);
    if (segment.visualization) convert(*segment.visualization);
    segment.transports.clear();
    for (Interval& step : segment.steps) {
      convert(step);
      segment.transports.push_back(transport(source_, steps_++));
    }
    return true;
  }

 private:
  RealTime on_device_clock(RealTime at) const {
    if (source_.clock_ppm == 0) return at;
    return RealTime{floor_mul_div(at.ns, kMillion, kMillion + source_.clock_ppm)};
  }
  void convert(Interval& interval) const { interval = {on_device_clock(interval.begin), on_device_clock(interval.end)}; }

  std::unique_ptr<StepTiming> timing_;
  SourceSpec source_;
  std::uint64_t steps_ = 0;
};

}  // namespace

Transport transport(const SourceSpec& source, std::uint64_t n) {
  if (source.lost > 0 && RandomStream(source.seed, "source.lost").uniform(n) < source.lost) return {{}, true};
  Duration delay = source.delay;
  if (source.jitter.ns > 0)
    delay =
        delay + Duration{static_cast<std::int64_t>(
                    RandomStream(source.seed, "source.jitter").below(n, static_cast<std::uint64_t>(source.jitter.ns) + 1))};
  if (source.late > 0 && RandomStream(source.seed, "source.late").uniform(n) < source.late) delay = delay + source.late_by;
  return {delay, false};
}

std::unique_ptr<StepTiming> make_source_timing(std::unique_ptr<StepTiming> timing, const SourceSpec& source) {
  return std::make_unique<SourceTiming>(std::move(timing), source);
}

}  // namespace evenstep
