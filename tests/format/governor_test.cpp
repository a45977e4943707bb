// [timing] governor, which shortens the pauses.
#include "catch.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

const std::string kProgrammed = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1-spring.toml";
const std::string kRecorded = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/pauses/regime.toml";

ReadResult read_governed(const std::string& governor, const std::string& file = kProgrammed) {
  return read_scenario(file, {{"timing.governor=" + governor}, {}, {}});
}

}  // namespace

TEST_CASE("A governor goes with programmed and with recorded timing, and has defaults") {
  for (const std::string& file : {kProgrammed, kRecorded}) {
    const ReadResult plain = read_governed("{}", file);
    REQUIRE(plain);
    REQUIRE(plain->timing.governor);
    CHECK(plain->timing.governor->split == 1);
    CHECK_FALSE(plain->timing.governor->budget);
    CHECK_FALSE(plain->timing.governor->pace);
    const ReadResult all =
        read_governed("{ split = 3, budget = \"5 ms\", over_budget = \"hold\", forecast = 4, pace = \"20 ms\" }", file);
    REQUIRE(all);
    CHECK(all->timing.governor->split == 3);
    CHECK(all->timing.governor->budget == Duration{5'000'000});
    CHECK(all->timing.governor->over_budget == OverBudget::hold);
    CHECK(all->timing.governor->forecast == 4);
    CHECK(all->timing.governor->pace == Duration{20'000'000});
  }
  CHECK(read_governed("{ budget = \"5 ms\" }")->timing.governor->over_budget == OverBudget::merge);
  CHECK(read_governed("{ budget = \"5 ms\", over_budget = \"skip\" }")->timing.governor->over_budget == OverBudget::skip);
  CHECK(read_governed("{ pace = \"30 Hz\" }")->timing.governor->pace == Duration{33'333'333});
  CHECK_FALSE(read_governed("{}")->timing.governor->spread);
  CHECK(read_governed("{ steps = \"spread\", split = 2 }")->timing.governor->spread);
  CHECK_FALSE(read_scenario(kProgrammed, {})->timing.governor);
}

TEST_CASE("What is no governor is an error that says what is one") {
  const auto [written, error] = GENERATE(
      std::pair("{ split = 0 }", "at least 1"), std::pair("{ split = 1001 }", "at most 1000"),
      std::pair("{ budget = \"0 ms\" }", "above 0 s"), std::pair("{ budget = 20 }", "20 has no unit"),
      std::pair("{ forecast = 0, budget = \"5 ms\", over_budget = \"hold\" }", "at least 1"),
      std::pair("{ over_budget = \"drop\", budget = \"5 ms\" }", "\"merge\", \"skip\" or \"hold\""),
      std::pair("{ over_budget = \"hold\" }", "is about a 'budget', and there is none"),
      std::pair("{ forecast = 3 }", "is about a 'budget', and there is none"),
      std::pair("{ forecast = 3, budget = \"5 ms\" }", "\"merge\" cuts a drawing off"),
      std::pair("{ pace = \"1 us\" }", "between 10 us and 9 s"), std::pair("{ pace = \"10 s\" }", "between 10 us and 9 s"),
      std::pair("{ bugdet = \"5 ms\" }", "did you mean 'budget'?"));
  INFO(written);
  CHECK_THAT(errors_of(read_governed(written)), Contains(error));
}

TEST_CASE("Visualizations that stop no step need no governor") {
  const std::string beside = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/recorded/concurrent-paced30-basic-sub9.toml";
  const std::string programmed = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/timing/no-cycle.toml";
  for (const std::string& file : {beside, programmed})
    CHECK_THAT(errors_of(read_governed("{ split = 2 }", file)), Contains("have a lane of their own and stop no step"));
}
