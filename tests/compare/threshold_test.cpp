#include "evenstep/campaigns/threshold.h"
#include "cases.h"

#include "catch.h"

using namespace evenstep;
using Catch::Contains;

namespace {

const std::string kForce = "left.force.paper", kHand = "left.interaction.paper", kBuffers = "left.buffers.phase_locked";

Threshold of(const std::string& text) {
  const Result<Threshold, Diagnostic> threshold = parse_threshold(text);
  INFO(text << ": " << threshold.error_or({}).message);
  REQUIRE(threshold.ok());
  return *threshold;
}

/// "8: expected ..."
std::string threshold_error(const std::string& text) {
  const Result<Threshold, Diagnostic> threshold = parse_threshold(text);
  INFO(text);
  REQUIRE_FALSE(threshold.ok());
  CHECK(threshold.error().file == "--fail-if");
  CHECK(threshold.error().line == 1);
  return std::to_string(threshold.error().column) + ": " + threshold.error().message;
}

}  // namespace

TEST_CASE("a relative threshold counts from A, in the direction of its sign") {
  const Threshold grows = of("latency > +5 %");
  CHECK_FALSE(grows.exceeded(kBuffers, "latency", 0.100, 0.105, false));
  CHECK(grows.exceeded(kBuffers, "latency", 0.100, 0.1051, false));
  CHECK_FALSE(grows.exceeded(kBuffers, "latency", 0.100, 0.05, false));
  CHECK(grows.exceeded(kBuffers, "latency", -0.100, -0.09, false));
  CHECK(grows.exceeded(kBuffers, "latency", 0, 1e-9, false));  // any growth is more than 5 % of 0
  CHECK_FALSE(grows.exceeded(kBuffers, "latency", 0, 0, false));
  const Threshold shrinks = of("stable < -1%");
  CHECK(shrinks.exceeded("closed_loop.left.paper", "stable", 1, 0, true));
  CHECK_FALSE(shrinks.exceeded("closed_loop.left.paper", "stable", 0, 1, true));
}

TEST_CASE("an absolute threshold has the unit of its metric, and where that is another one it does not count") {
  const Threshold length = of("velocity_jump>+0.1mm");
  CHECK(length.covers(kHand, "velocity_jump"));
  CHECK_FALSE(length.covers(kForce, "velocity_jump"));
  CHECK(length.exceeded(kHand, "velocity_jump", 1e-3, 1.2e-3, false));
  CHECK_FALSE(length.exceeded(kHand, "velocity_jump", 1e-3, 1.05e-3, false));
  CHECK(of("velocity_jump > +5 %").covers(kForce, "velocity_jump"));
  CHECK(of("underruns > +0").exceeded(kForce, "underruns", 3, 4, false));
  CHECK_FALSE(of("underruns > +0").exceeded(kForce, "underruns", 3, 3, false));
}

TEST_CASE("of several changes all must be exceeded") {
  const Threshold both = of("*.force.* velocity_jump > +5 % and > +1 mN");
  CHECK(both.covers(kForce, "velocity_jump"));
  CHECK_FALSE(both.exceeded(kForce, "velocity_jump", 1e-14, 3e-14, false));
  CHECK_FALSE(both.exceeded(kForce, "velocity_jump", 1, 1.01, false));
  CHECK(both.exceeded(kForce, "velocity_jump", 0.01, 0.012, false));
  CHECK(of("velocity_jump > +5 % and +1 mN").changes.size() == 2);
}

TEST_CASE("a threshold is about all signals, a strategy, or a pattern") {
  CHECK(of("velocity_jump > +5 %").covers(kHand, "velocity_jump"));
  CHECK(of("paper velocity_jump > +5 %").covers(kHand, "velocity_jump"));
  CHECK_FALSE(of("direct velocity_jump > +5 %").covers(kHand, "velocity_jump"));
  CHECK_FALSE(of("left velocity_jump > +5 %").covers(kHand, "velocity_jump"));  // a device is no strategy
  CHECK(of("left.*.paper velocity_jump > +5 %").covers(kHand, "velocity_jump"));
  CHECK_FALSE(of("right.*.paper velocity_jump > +5 %").covers(kHand, "velocity_jump"));
  CHECK(of("run judged_s < -1 %").covers("run", "judged_s"));
  CHECK(of("paper margin < -10 %").covers(kHand, "margin"));
}

TEST_CASE("worse counts in the direction in which a metric gets worse, and leaves out what has none") {
  const Threshold worse = of("worse > +5 %");
  CHECK(worse.covers(kForce, "velocity_jump"));
  CHECK_FALSE(worse.covers(kForce, "judged"));
  CHECK_FALSE(worse.covers("solver.paper", "solver_seconds"));
  CHECK(worse.exceeded("solver.paper", "k_max", 100, 90, true));
  CHECK_FALSE(worse.exceeded("solver.paper", "k_max", 100, 110, true));
  CHECK_FALSE(of("worse > +50 %").exceeded("solver.paper", "k_max", 100, 90, true));
}

TEST_CASE("an error names the column, what was expected, and the word that is near") {
  CHECK_THAT(threshold_error("latncy > +5 %"), Contains("1: 'latncy' is no metric; did you mean 'latency'?, in \"latncy"));
  CHECK_THAT(threshold_error("left.frce.paper late > +5 %"), Contains("1: 'left.frce.paper' is no signal"));
  CHECK_THAT(threshold_error("left.force.paper lead > +5 %"), Contains("18: 'lead' is no metric of 'left.force.paper'"));
  CHECK_THAT(threshold_error("latency > 5 %"), Contains("11: expected a change with its sign, such as '> +5 %'"));
  CHECK_THAT(threshold_error("latency < +5 %"), Contains("11: expected a change with its sign, such as '< -5 %'"));
  CHECK_THAT(threshold_error("latency = 5 %"), Contains("9: "));
  CHECK_THAT(threshold_error("latency > +5 mN"), Contains("11: 'mN' is a unit of force, not of time"));
  CHECK_THAT(threshold_error("latency > +5"), Contains("needs a unit, such as 's'"));
  CHECK_THAT(threshold_error("velocity_jump > +0.1 step"), Contains("17: a 'step' is another length in each scenario"));
  CHECK_THAT(threshold_error("latency > +-5 %"), Contains("one sign"));
  CHECK_THAT(threshold_error("latency > +1/3 %"), Contains("one sign"));
  CHECK_THAT(threshold_error("latency > +nan %"), Contains("11: "));
  CHECK_THAT(threshold_error("latency > +5 % and"), Contains("11: "));
  CHECK_THAT(threshold_error("latency > +5 % and < -5 %"), Contains("20: expected '> +' or '< -', the same one"));
  CHECK_THAT(threshold_error("latency"), Contains("8: expected a change behind 'latency'"));
  CHECK_THAT(threshold_error("verdict > +5 %"), Contains("9: 'verdict' stands alone"));
  CHECK_THAT(threshold_error("worse < -5 %"), Contains("7: expected '> +'"));
  CHECK_THAT(threshold_error("worse > +1 ms"), Contains("9: expected a change in %"));
  CHECK_THAT(threshold_error("a b c > +5 %"), Contains("5: 'c' is too much"));
  CHECK_THAT(threshold_error(""), Contains("1: expected a metric"));
  CHECK_THAT(threshold_error(" > +5 %"), Contains("1: expected a metric"));
}

TEST_CASE("20,000 damaged thresholds are read or refused, with a column inside of the text") {
  const std::vector<std::string> good{"latency > +5 %", "*.force.* velocity_jump > +5 % and > +1 mN", "worse > +5 %",
                                      "verdict", "paper margin < -0.1"};
  std::mt19937 random(7);
  const std::string letters = "abz.*<>=+-%0159 \tmN/and\xc3\xa4";
  std::size_t refused = 0;
  for (std::uint64_t i = 0; i < evenstep::testing::cases(20'000); ++i) {
    std::string text = good[random() % good.size()];
    for (std::size_t changes = 1 + random() % 3; changes > 0; --changes) {
      const std::size_t at = random() % (text.size() + 1);
      if (random() % 2 == 0 && at < text.size())
        text.erase(at, 1 + random() % 3);
      else
        text.insert(at, 1, letters[random() % letters.size()]);
    }
    const Result<Threshold, Diagnostic> threshold = parse_threshold(text);
    if (threshold) {
      threshold->exceeded(kForce, "velocity_jump", 1, 2, false);
      continue;
    }
    ++refused;
    CHECK(threshold.error().column >= 1);
    CHECK(threshold.error().column <= static_cast<std::int64_t>(text.size()) + 1);
  }
  CHECK(refused > evenstep::testing::cases(20'000) / 20);
}
