// A recording needs the same latency whether it is sized by itself or replayed by a scenario, including its last step.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/run.h"
#include "evenstep/recordings/timing_csv.h"
#include "temporary_folder.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::testing;
namespace fs = std::filesystem;

namespace {

/// A folder with a recording and a scenario that replays it with a device of 1 kHz and held forces, as `size` assumes.
class Replay {
 public:
  explicit Replay(const std::string& csv) {
    folder_.write("t.csv", csv);
    folder_.write(
        "replay.toml",
        "format = 1\n[run]\nstrategies = [\"phase_locked\"]\n[timing]\ntrace = \"t.csv\"\n[scene]\nkind = \"spring\"\n"
        "[[device]]\nname = \"left\"\nrender = { kind = \"force\", emission = \"hold\" }\n");
  }
  std::string recording() const { return folder_ / "t.csv"; }
  Scenario scenario() const {
    const ReadResult read = read_scenario(folder_ / "replay.toml");
    INFO((read ? "" : text(read.error().front())));
    REQUIRE(read);
    return *read;
  }

 private:
  TemporaryFolder folder_;
};

Duration least_latency(const SizeResult& result) {
  REQUIRE(result.errors.empty());
  return result.record.strategies.back().any_phase.latency;
}

}  // namespace

TEST_CASE("the last step of a recording counts in its replay: 18 ms more for it are 18 ms more of latency") {
  auto segments = play({.segment = {30, 1}, .visualization = {11'100'000}, .steps = {15}}, 40);
  Interval& last = segments.back().steps.back();
  last.end = segments.back().end = last.end + Duration{18 * ms};
  const Replay replay(format_timing_csv(segments));
  const Scenario scenario = replay.scenario();
  const Duration recorded = least_latency(size_recording(replay.recording(), {}));
  // Step 14 ends 2.222 ms after the begin of its slot. 18 ms later it is 20.222 ms, and with a lead of 0.26 ms 20.482 ms.
  CHECK(std::abs(recorded.ns - 20'482'221) <= 2);
  CHECK(least_latency(size_scenario(scenario, {})) == recorded);
  const RunOutcome run = run_scenario(scenario, {});
  REQUIRE(run.record.strategies.size() == 1);
  CHECK(run.record.strategies.front().steps.size() == 600);
  CHECK(run.record.strategies.front().steps.back().end == last.end);
  CHECK(run.record.strategies.front().latency.least_any_phase == recorded);
}

TEST_CASE("100 random recordings need the same sized by themselves and replayed, and so does each 1 s before zero") {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    auto segments = play(random_timing(seed), 20);
    const Replay replay(format_timing_csv(segments));
    INFO("seed " << seed);
    const Scenario scenario = replay.scenario();
    const Duration recorded = least_latency(size_recording(replay.recording(), {}));
    CHECK(least_latency(size_scenario(scenario, {})) == recorded);
    const auto earlier = [](Interval& interval) {
      interval = {interval.begin - Duration{1000 * ms}, interval.end - Duration{1000 * ms}};
    };
    for (SegmentTiming& segment : segments) {
      segment.begin = segment.begin - Duration{1000 * ms};
      segment.end = segment.end - Duration{1000 * ms};
      if (segment.visualization) earlier(*segment.visualization);
      for (Interval& step : segment.steps) earlier(step);
    }
    const TimingCsv shifted = parse_timing_csv(format_timing_csv(segments), "t.csv");
    REQUIRE(shifted);
    CHECK(format_timing_csv(*shifted) == format_timing_csv(scenario.timing.trace));
  }
}
