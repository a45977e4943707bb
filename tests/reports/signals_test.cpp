#include <algorithm>
#include <fstream>
#include <sstream>

#include "catch.h"
#include "evenstep/reports/measures.h"
#include "synthetic.h"

using namespace evenstep;

TEST_CASE("every form of a signal is known and every other is not") {
  for (const char* signal : {"left.interaction.direct", "left.force.paper", "*.force.*", "left.buffers.ideal",
                             "solver.paper", "solver.*", "events.device.tick", "events.*.step", "run", "left.*.direct"}) {
    CAPTURE(signal);
    CHECK(metrics_of_signal(signal).has_value());
  }
  for (const char* signal :
       {"", ".", "..", "run.x", "left", "left.interaction", "left.interaction.direct.x", "left.motion.direct", "solver",
        "solver.", "events.tick", "events.gpu.tick", ".interaction.direct", "left.interaction."}) {
    CAPTURE(signal);
    CHECK_FALSE(metrics_of_signal(signal).has_value());
  }
}

TEST_CASE("step is v * slot for interaction, k * v * slot for a spring's force, and an error elsewhere") {
  Nominal nominal = synthetic::nominal({1'000'000'000});
  CHECK(step_unit(nominal, "left.interaction.direct").value() == Approx(0.1 / 450).epsilon(1e-15));
  CHECK(step_unit(nominal, "left.force.direct").value() == Approx(200 * 0.1 / 450).epsilon(1e-15));
  CHECK_FALSE(step_unit(nominal, "left.buffers.direct"));
  CHECK_FALSE(step_unit(nominal, "right.interaction.direct"));
  CHECK_FALSE(step_unit(nominal, "run"));
  nominal.devices[0].speed_m_per_s = -0.1;
  CHECK(step_unit(nominal, "left.interaction.direct").value() > 0);
  nominal.devices[0].stiffness_N_per_m.reset();  // tissue
  CHECK_FALSE(step_unit(nominal, "left.force.direct"));
  CHECK(step_unit(nominal, "left.interaction.direct"));
  nominal.devices[0].speed_m_per_s = 0;
  CHECK_FALSE(step_unit(nominal, "left.interaction.direct"));
  nominal.devices[0].speed_m_per_s.reset();  // a sine has no one speed
  CHECK_FALSE(step_unit(nominal, "left.interaction.direct"));
}

TEST_CASE("every metric that a run gives is known, has a unit and stands in docs/reference/metrics.md") {
  std::ifstream file(EVENSTEP_SOURCE_DIR "/docs/reference/metrics.md");
  std::stringstream page;
  page << file.rdbuf();
  RunRecord run = synthetic::reference_run();
  run.clock = "wall";
  run.nominal.devices[0].sine = Nominal::Sine{{0.01, 0, 0}, 2, 0};
  for (StrategyRecord& strategy : run.strategies) {
    strategy.event_counts["device.tick"] = 2000;
    strategy.solver.has_energy = true;
    strategy.solver.step_limit_s = 0.1;
    strategy.solver.rest_state_step_limit_s = 0.1;
    strategy.solver.iterations = 3;
    strategy.solver.variable_step = true;
    strategy.devices[0].steps.back().true_position_m = Vec3{};
    strategy.devices[0].counters = {{"reports", 1},        {"lost", 0},    {"malformed", 0}, {"stale", 0},
                                    {"write_failures", 0}, {"clamped", 0}, {"slewed", 0},    {"non_finite", 0}};
  }
  for (const auto& [signal, values] : measure(run)) {
    const auto known = metrics_of_signal(signal);
    REQUIRE(known);
    for (const auto& [metric, value] : values) {
      CAPTURE(signal, metric);
      CHECK(std::count(known->begin(), known->end(), metric) == 1);
      CHECK_FALSE(base_unit(signal, metric).empty());
    }
    for (const std::string& metric : *known) {
      CAPTURE(signal, metric);
      CHECK(page.str().find("`" + metric + "`") != std::string::npos);
    }
  }
}
