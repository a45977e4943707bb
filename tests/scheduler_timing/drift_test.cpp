// 10^7 steps of the periodic schedule end at the exact rational instants. The expected instants are counted up in whole
// numbers with a carried remainder, unlike the divisions of tick_time and of the schedule.
#include "catch.h"
#include "evenstep/scheduler/step_timing.h"

using namespace evenstep;

namespace {

/// k * numerator / denominator for k = 0, 1, 2, ..., floored.
class CountedFloors {
 public:
  CountedFloors(__int128 numerator, std::int64_t denominator)
      : whole_(numerator / denominator), rest_(numerator % denominator), denominator_(denominator) {}
  std::int64_t next() {
    const std::int64_t value = static_cast<std::int64_t>(at_);
    at_ += whole_;
    carried_ += rest_;
    if (carried_ >= denominator_) {
      carried_ -= denominator_;
      ++at_;
    }
    return value;
  }

 private:
  __int128 whole_, rest_, denominator_;
  __int128 at_ = 0, carried_ = 0;
};

/// For steps of "fill" after the visualization, checks the boundary, the visualization, and the begin and end of every step.
/// Returns how many instants are wrong.
std::int64_t wrong_instants(const ProgrammedTiming& programmed, std::int64_t steps_wanted) {
  const auto timing = make_programmed_timing(programmed);
  const int count = programmed.steps.front();
  CountedFloors boundaries(static_cast<__int128>(programmed.segment.den) * 1'000'000'000, programmed.segment.num);
  std::int64_t wrong = 0, steps = 0;
  RealTime begin{boundaries.next()};
  SegmentTiming segment;
  while (steps < steps_wanted) {
    const RealTime end{boundaries.next()};
    timing->next(segment);
    const RealTime first_step = begin + programmed.visualization;
    wrong += segment.begin != begin || segment.end != end || segment.visualization->end != first_step;
    CountedFloors in_segment((end - first_step).ns, count);
    RealTime at = first_step + Duration{in_segment.next()};
    for (const Interval& step : segment.steps) {
      wrong += step.begin != at;
      at = first_step + Duration{in_segment.next()};
      wrong += step.end != at;
      ++steps;
    }
    wrong += at != end;  // the last step ends with the segment, to the ns
    begin = end;
  }
  return wrong;
}

}  // namespace

TEST_CASE("10^7 periodic steps begin and end on the floors of their exact instants", "[sweep]") {
  constexpr std::int64_t kSteps = 10'000'000;
  CHECK(wrong_instants({}, kSteps) == 0);  // 450 steps/s
  CHECK(wrong_instants({.segment = {1'000'003, 30'011}, .visualization = {1'234'567}, .steps = {13}}, kSteps) == 0);
}
