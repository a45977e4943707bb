// The cycle that is found in the shipped recordings without their visualizations and segments, compared with the files.
#include <algorithm>

#include "evenstep/recordings/timing_csv.h"
#include "evenstep/remap/step_cycle.h"
#include "traces.h"

using namespace evenstep;

namespace {

struct Recorded {
  std::vector<StepTimes> steps;
  std::vector<std::size_t> boundaries;  ///< steps that begin a segment of the file, except the first
};

Recorded recorded(const std::string& name) {
  const TimingCsv csv = read_timing_csv(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/recorded/" + name + ".csv");
  REQUIRE(csv);
  Recorded out;
  for (const SegmentTiming& segment : *csv) {
    if (!out.steps.empty() && !segment.steps.empty()) out.boundaries.push_back(out.steps.size());
    for (const Interval& step : segment.steps) out.steps.push_back({step.begin, step.end, 0, 0});
  }
  return out;
}

}  // namespace

TEST_CASE("the cycle of six recordings and their boundaries are found in the step times alone") {
  for (const char* name : {"small-paced30-basic", "paced30-pthread", "paperlike-free-basic", "regime-free-basic",
                           "contended-free-basic", "coldstart-paced30-basic"}) {
    const Recorded file = recorded(name);
    const StepCycle cycle = find_cycle(file.steps);
    INFO(name << ": " << cycle.reason);
    REQUIRE(cycle.found);
    CHECK(cycle.steps_per_segment == 15);
    CHECK(cycle.confidence > 0.99);
    // A pause in the middle of a segment looks like any other pause. At most one boundary in a hundred is not in the file.
    std::vector<std::size_t> common;
    std::set_intersection(cycle.boundaries.begin(), cycle.boundaries.end(), file.boundaries.begin(), file.boundaries.end(),
                          std::back_inserter(common));
    CHECK(common.size() == file.boundaries.size());
    CHECK(static_cast<double>(cycle.boundaries.size()) < 1.01 * static_cast<double>(file.boundaries.size()));
  }
}

TEST_CASE("the recording whose visualization has a thread of its own has no cycle") {
  const Recorded file = recorded("concurrent-paced30-basic-sub9");
  const StepCycle cycle = find_cycle(file.steps);
  CHECK_FALSE(cycle.found);
  CHECK(cycle.reason == "no pause between steps stands out from the others");
}
