// Positions that no hand can have: not a number in a recorded motion, the ends of a report's range, and positions that no
// report can carry.
#include <cmath>
#include <limits>
#include <map>
#include <mutex>

#include "catch.h"
#include "evenstep/harness/run.h"
#include "support.h"

using namespace evenstep;
using Catch::Contains;

namespace {

constexpr const char* kLoop = R"(format = 1
name = "bad input"
[run]
duration = "0.4 s"
strategies = ["direct"]
[timing]
segment = "30 Hz"
visualization = "11.1 ms"
steps = 15
[scene]
kind = "tissue"
solver = "cpu"
lattice = [4, 4, 4]
[[device]]
name = "left"
grab = { center = ["10 mm", "10 mm", "15 mm"], radius = "6 mm" }
motion = { kind = "recorded", file = "hand.csv" }
)";

ReadResult read_with(const testing::TemporaryFolder& folder, const std::string& rows, const std::string& more = "") {
  folder.write("hand.csv", "t_s,x_m,y_m,z_m\n" + rows);
  return read_scenario(folder.write("scenario.toml", kLoop + more));
}

/// The hand is at rest until just before 0.2 s. From then on it is infinitely far away, where no report can say it is.
Scenario infinite_hand(const std::string& strategy, const std::string& more) {
  const testing::TemporaryFolder folder;
  const ReadResult read = read_with(folder, "0,0,0,0\n", more);
  INFO(test::errors_of(read));
  REQUIRE(read);
  Scenario scenario = *read;
  scenario.strategies = {strategy == "ideal" ? StrategyKind::ideal : StrategyKind::direct};
  // No tick may fall between the two rows, because half an infinite way would be not a number.
  const glm::dvec3 away_m(std::numeric_limits<double>::infinity(), 0, 0);
  scenario.devices[0].motion.shape =
      RecordedMotion{{{{0}, glm::dvec3(0)}, {{199'999'990}, glm::dvec3(0)}, {{199'999'991}, away_m}}};
  return scenario;
}

}  // namespace

TEST_CASE("A recorded motion with a number that is none is refused at its row and column, whatever it is called") {
  for (const char* number :
       {"nan", "-nan", "NaN", "inf", "-inf", "infinity", "1e999", "-1e999", "nan(1)", "1e4", "0x1p3", ""}) {
    for (int column = 0; column < 4; ++column) {
      const testing::TemporaryFolder folder;
      std::string row;
      for (int c = 0; c < 4; ++c) row += (c == 0 ? "" : ",") + std::string(c == column ? number : "1");
      if (column == 0 && std::string(number) == "1e4") continue;  // seconds, not metres
      const ReadResult read = read_with(folder, "0,0,0,0\n" + row + "\n");
      INFO(row);
      REQUIRE_FALSE(read);
      CHECK_THAT(test::errors_of(read),
                 Contains("hand.csv:3:" + std::to_string(1 + 2 * column) + ": error: '" + number + "' is not a number"));
    }
  }
}

TEST_CASE("A position that is not finite stops the run with its reason and its step, and a scenario may expect that") {
  // `ideal` reads the programmed hand itself. 0.2 s is step 90 of 450 per second, and the lead comes before it.
  const RunOutcome outcome = run_scenario(infinite_hand("ideal", ""), {});
  CHECK(outcome.exit == ExitCode::run_failed);
  CHECK_THAT(outcome.failure, Contains("the position of tool 0 is not finite"));
  CHECK_THAT(outcome.remedy, Contains("the device's reports or the recorded motion"));
  const std::size_t at = outcome.failure.find("step ");
  REQUIRE(at != std::string::npos);
  const long step = std::stol(outcome.failure.substr(at + 5));
  CHECK(step >= 90);
  CHECK(step <= 120);
  const auto expecting = [&](const std::string& stop) {
    return run_scenario(infinite_hand("ideal", "[expect_stop]\n" + stop), {}).exit;
  };
  CHECK(expecting("reason = \"bad-input\"\nat_most_step = " + std::to_string(step) + "\n") == ExitCode::pass);
  CHECK(expecting("reason = \"bad-input\"\nat_most_step = " + std::to_string(step - 1) + "\n") ==
        ExitCode::expectation_failed);
  CHECK(expecting("reason = \"diverged\"\n") == ExitCode::run_failed);
}

TEST_CASE(
    "A device's report holds nothing but numbers: a hand beyond its range is at its end, and the tissue stays finite") {
  const std::string expectation = "[[expect]]\nsignal = \"solver.*\"\nmetric = \"non_finite\"\nequals = 0\n";
  const RunOutcome outcome = run_scenario(infinite_hand("direct", expectation), {});
  INFO(outcome.failure);
  CHECK(outcome.exit == ExitCode::pass);
  const DeviceRecord& device = outcome.record.strategies.at(0).devices.at(0);
  double furthest_m = 0, most_N = 0;
  for (const auto& step : device.steps) {
    furthest_m = std::max(furthest_m, step.position_m[0]);
    most_N = std::max(most_N, std::abs(step.force_N[0]));
    REQUIRE(std::isfinite(step.force_N[0]));
  }
  CHECK(furthest_m == 2.147483647);  // int32 nanometres
  CHECK(most_N > 100);               // the hand really was at the end of the range
}

TEST_CASE("Every strategy is reported as done once, though twins of the ideal one run beside it") {
  const testing::TemporaryFolder folder;
  for (const char* strategies : {"[\"ideal\", \"direct\", \"phase_locked\"]", "[\"direct\", \"phase_locked\"]"}) {
    std::string text = kLoop;
    text.replace(text.find("[\"direct\"]"), 10, strategies);
    folder.write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n1,0.01,0,0\n");
    text += "[[expect]]\nsignal = \"left.force.phase_locked\"\nmetric = \"deviation_from_ideal\"\nmax = \"100 N\"\n";
    const ReadResult read = read_scenario(folder.write("scenario.toml", text));
    INFO(test::errors_of(read));
    REQUIRE(read);
    std::map<std::string, int> done;
    std::mutex mutex;
    RunOptions options;
    options.control.progress = [&](const std::string& strategy, double fraction) {
      const std::lock_guard lock(mutex);
      done[strategy] += fraction >= 1;
    };
    CHECK(run_scenario(*read, options).exit == ExitCode::pass);
    CHECK(done.size() == read->strategies.size());
    for (const auto& [strategy, times] : done) {
      INFO(strategy);
      CHECK(times == 1);
    }
  }
}
