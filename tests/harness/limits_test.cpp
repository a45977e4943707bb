// What a run says of the step and the stiffness that its tissue carries.
#include <fmt/format.h>

#include "evenstep/sim/stability.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

std::map<std::string, double> solver_metrics(const std::vector<std::string>& set) {
  std::vector<std::string> all = small_tissue("cpu-double");
  all.insert(all.end(), {"run.duration=\"0.1 s\"", "run.warmup=\"0 s\"", "run.strategies=[\"direct\"]", "expect=[]"});
  all.insert(all.end(), set.begin(), set.end());
  RunOptions options;
  options.allow_no_expectations = true;
  RunOutcome outcome = run_scenario(read("paper/figure-1.toml", all), options);
  INFO(outcome.failure);
  REQUIRE(outcome.exit == ExitCode::pass);
  return outcome.metrics["solver.direct"];
}

}  // namespace

TEST_CASE("a tissue's run reports its step limit, and at the stiffness k_max its substep is that limit") {
  const auto metrics = solver_metrics({"scene.damping=\"1 mN s/m\""});
  CHECK(metrics.at("step_limit") < metrics.at("rest_state_step_limit"));
  CHECK(metrics.at("step_size_over_limit") < kStepSafety);
  CHECK(metrics.at("limit_particle") >= 8 * 7);  // the fixed layer does not move
  CHECK(metrics.count("iterations") == 0);
  const std::string substeps = fmt::format("scene.substeps={}", metrics.at("substeps"));
  // Damping stays as it is, so the limit is not only a matter of k / m. 1e-12: rounding.
  const auto at_k_max = solver_metrics({"scene.damping=\"1 mN s/m\"", substeps, "scene.allow_unstable=true",
                                        fmt::format("scene.stiffness=\"{:.17g} N/m\"", metrics.at("k_max"))});
  CHECK(at_k_max.at("step_size_over_limit") == Approx(1).epsilon(1e-12));
  CHECK(at_k_max.at("k_max") == Approx(metrics.at("k_max")).epsilon(1e-12));
}
