// The closed loop on a lattice: the law of one spring in three dimensions and for two hands, and contact that slides.

#include <fmt/format.h>

#include <cmath>

#include "evenstep/campaigns/stiffness_limit.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// The law's K_max = b / L_e, for the reference timing, 0.2 kg and 1 N s/m.
constexpr double kDelay_s = 15.564444e-3, kLaw_N_per_m = 1 / kDelay_s;

/// A tissue so light that its modes are far above those of the loop. So it answers with its stiffness at rest.
const std::vector<std::string> kLight{"scene.solver=\"cpu-double\"", "scene.mass=\"5 mg\"", "scene.damping=\"0.1 mN s/m\"",
                                      "run.strategies=[\"phase_locked\"]", "expect=[]"};

std::vector<std::string> with(std::vector<std::string> set, const std::vector<std::string>& more) {
  set.insert(set.end(), more.begin(), more.end());
  return set;
}

/// The largest eigenvalue of the settled stiffness of all tools together, at a spring stiffness of 1 N/m, by iteration.
double largest_per_spring(const std::string& file, std::vector<std::string> set, bool both) {
  set.push_back("device.left.render={ kind = \"local\", stiffness = \"settled\" }");
  if (both) set.push_back("device.right.render={ kind = \"local\", stiffness = \"settled\", coupled = true }");
  const Scenario scenario = read(file, set);
  const auto solver = make_solver(SolverKind::cpu_double, scenario.scene);
  const std::array<glm::dvec3, 2> rest{};
  solver->step(std::span(rest.data(), both ? 2 : 1));
  const std::span<const ToolContact> contacts = solver->contacts();
  std::array<glm::dvec3, 2> v{glm::dvec3(1, 2, 3), both ? glm::dvec3(-2, 1, 5) : glm::dvec3(0)};
  double value = 0;
  for (int i = 0; i < 500; ++i) {
    std::array<glm::dvec3, 2> next{};
    for (std::size_t t = 0; t < contacts.size(); ++t)
      next[t] = contacts[t].stiffness_N_per_m * v[t] + contacts[t].coupling_N_per_m * v[1 - t];
    value = std::sqrt(glm::dot(next[0], next[0]) + glm::dot(next[1], next[1]));
    v = {next[0] / value, next[1] / value};
  }
  return value / std::get<TissueScene>(scenario.scene.body).stiffness_N_per_m;
}

double limit_per_spring(const std::string& file, const std::vector<std::string>& set, double from, double to) {
  Scenario scenario = read(file, set);
  scenario.study.stiffness_limit = StiffnessSearch{from, to, 1};
  const StiffnessLimit limit = run_stiffness_limits(scenario).limits.at(0);
  REQUIRE(limit.state == StiffnessLimit::State::found);
  return limit.stable_N_per_m;
}

double furthest_apart(const DeviceRecord& a, const DeviceRecord& b) {
  double most_m = 0;
  REQUIRE(a.ticks.size() == b.ticks.size());
  for (std::size_t k = 0; k < a.ticks.size(); ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      most_m = std::max(most_m, std::abs(a.ticks[k].position_m[axis] - b.ticks[k].position_m[axis]));
  return most_m;
}

}  // namespace

TEST_CASE("along the axis of a light symmetric block the closed loop has the limit and the damper of one spring",
          "[sweep]") {
  const auto set =
      with(kLight, {"device.left.motion={ kind = \"hand\", mass = \"0.2 kg\", damping = \"1 N s/m\", velocity = "
                    "[\"0 mm/s\", \"0 mm/s\", \"-50 mm/s\"] }"});
  const double per_spring = largest_per_spring("closed-loop/block-grab.toml", set, false);
  // For a single spring the law is 0.4 % below what is measured. The tissue adds its drag.
  const double limit = limit_per_spring("closed-loop/block-grab.toml", set, 4, 20) * per_spring;
  CHECK(limit >= 0.99 * kLaw_N_per_m);
  CHECK(limit <= 1.05 * kLaw_N_per_m);
  // The hand swings by millimetres along its axis and leaves it only by rounding.
  const RunRecord run = run_all(read("closed-loop/block-grab.toml", set));
  double aside_m = 0, along_m = 0;
  for (const TickRow& tick : strategy(run, "phase_locked").devices[0].ticks) {
    aside_m = std::max({aside_m, std::abs(tick.position_m[0]), std::abs(tick.position_m[1])});
    along_m = std::max(along_m, std::abs(tick.position_m[2]));
  }
  CHECK(along_m > 2e-3);
  CHECK(aside_m < 1e-8);
  const RunOutcome sine = run_scenario(
      read("closed-loop/block-grab.toml",
           with(kLight, {"run.warmup=\"1 s\"",
                         "device.left.motion={ kind = \"sine\", amplitude = [\"0 mm\", \"0 mm\", \"0.4 mm\"], frequency = "
                         "\"3 Hz\" }",
                         "expect=[{ signal = \"closed_loop.left.phase_locked\", metric = \"rendered_damping\", max = \"0 N "
                         "s/m\" }]"})),
      {});
  // The sine goes 0.2 mm to either side, where the springs are still linear (at 2 mm they are 10 % stiffer). At 3 Hz,
  // sin(w D) / w instead of D is 1.4 % less, and the curve of the springs makes 1 % more.
  CHECK(metric_of(sine, "closed_loop.left.phase_locked", "rendered_damping") ==
        Approx(-8 * per_spring * kDelay_s).epsilon(0.02));
}

TEST_CASE("at a corner, and for two hands, the law holds for the largest eigenvalue of all axes together", "[sweep]") {
  struct Case {
    const char* file;
    bool both;
    double from, to;
  };
  for (const Case& at : {Case{"closed-loop/block-corner.toml", false, 5, 25},
                         Case{"closed-loop/hands-near.toml", true, 1, 8}, Case{"closed-loop/hands-far.toml", true, 3, 15}}) {
    INFO(at.file);
    const double limit = limit_per_spring(at.file, kLight, at.from, at.to) * largest_per_spring(at.file, kLight, at.both);
    CHECK(limit >= 0.99 * kLaw_N_per_m);
    CHECK(limit <= 1.05 * kLaw_N_per_m);
  }
}

TEST_CASE("two hands far apart move as each would alone, within what couples them", "[sweep]") {
  // A long low block, with 36 spacings between the lumps that the hands hold.
  std::vector<std::string> both{"scene.lattice=[40, 4, 4]", "scene.solver=\"cpu-double\"",
                                "run.strategies=[\"phase_locked\"]", "expect=[]"};
  for (const char* hand : {"left", "right"}) {
    both.push_back(fmt::format("device.{}.grab={{ center = [\"{}\", \"12 mm\", \"24 mm\"], radius = \"11 mm\" }}", hand,
                               hand[0] == 'l' ? "12 mm" : "300 mm"));
    both.push_back(fmt::format("device.{}.render={{ kind = \"local\", stiffness = \"settled\" }}", hand));
  }
  const RunRecord together = run_all(read("closed-loop/hands-near.toml", both));
  double share = 0;
  {
    std::vector<std::string> coupled = both;
    coupled.back().insert(coupled.back().size() - 2, ", coupled = true");
    const Scenario scenario = read("closed-loop/hands-near.toml", coupled);
    const auto solver = make_solver(SolverKind::cpu_double, scenario.scene);
    const std::array<glm::dvec3, 2> rest{};
    solver->step(rest);
    const ToolContact& contact = solver->contacts()[0];
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r)
        share = std::max(share, std::abs(contact.coupling_N_per_m[c][r]) / contact.stiffness_N_per_m[2][2]);
  }
  CHECK(share < 1e-4);
  for (std::size_t hand = 0; hand < 2; ++hand) {
    Scenario alone = read("closed-loop/hands-near.toml", both);
    INFO(alone.devices[hand].name);
    alone.devices = {alone.devices[hand]};
    auto& tools = std::get<TissueScene>(alone.scene.body).tools;
    tools = {tools[hand]};
    alone.scene.tool_count = 1;
    const RunRecord single = run_all(alone);
    const DeviceRecord& here = strategy(together, "phase_locked").devices[hand];
    double swing_m = 0;
    for (const TickRow& tick : here.ticks) swing_m = std::max(swing_m, std::abs(tick.position_m[2]));
    REQUIRE(swing_m > 1e-3);
    // The other hand adds at most `share` of the force that this hand's own swing causes. A swing at 4 Hz that decays over
    // seconds adds that up over some tens of turns.
    CHECK(furthest_apart(here, strategy(single, "phase_locked").devices[0]) <= 50 * share * swing_m);
    CHECK(furthest_apart(here, strategy(single, "phase_locked").devices[0]) > 0);
  }
}

TEST_CASE(
    "hands side by side that render their coupling come to rest where hands that do not shake, whichever ticks first") {
  const auto outcome = [](bool coupled, std::optional<std::uint64_t> permute) {
    std::vector<std::string> set{"scene.stiffness=\"40 N/m\"", "run.strategies=[\"phase_locked\"]", "expect=[]"};
    for (const char* hand : {"left", "right"})
      set.push_back(
          fmt::format("device.{}.render={{ kind = \"local\", stiffness = \"settled\", coupled = {} }}", hand, coupled));
    RunOptions options;
    options.control.permute_ties = permute;
    return run_scenario(read("closed-loop/hands-near.toml", set), options);
  };
  const RunOutcome alone = outcome(false, {}), coupled = outcome(true, {});
  for (const char* hand : {"closed_loop.left.phase_locked", "closed_loop.right.phase_locked"}) {
    CHECK(metric_of(alone, hand, "stable") == 0);
    CHECK(metric_of(coupled, hand, "stable") == 1);
  }
  for (const std::uint64_t seed : {1ULL, 2ULL, 3ULL}) {
    const RunOutcome permuted = outcome(true, seed);
    for (std::size_t hand = 0; hand < 2; ++hand)
      CHECK(furthest_apart(strategy(coupled.record, "phase_locked").devices[hand],
                           strategy(permuted.record, "phase_locked").devices[hand]) == 0);
  }
}

TEST_CASE("the cap of two hands that play their coupling limits both together, where each hand's own cap does not") {
  // In units of k = 40 N/m, lambda is 26. The cap is above the K of each hand alone (15) and below that of both together.
  const auto outcome = [](const std::string& cap, bool coupled) {
    std::vector<std::string> set{"scene.stiffness=\"40 N/m\"", "run.strategies=[\"phase_locked\"]", "expect=[]"};
    for (const char* hand : {"left", "right"})
      set.push_back(fmt::format("device.{}.render={{ kind = \"local\", stiffness = \"settled\", coupled = {}{} }}", hand,
                                coupled, cap));
    return run_scenario(read("closed-loop/hands-near.toml", set), {});
  };
  const double lambda_N_per_m = 40 * largest_per_spring("closed-loop/hands-near.toml", {}, true);
  const RunOutcome alone = outcome(", cap = \"800 N/m\"", false), together = outcome(", cap = \"800 N/m\"", true);
  const RunOutcome free = outcome("", true), lesser = outcome(", cap = \"2000 N/m\"", true);
  for (const char* hand : {"left", "right"}) {
    INFO(hand);
    const std::string force = fmt::format("{}.force.phase_locked", hand);
    CHECK(metric_of(alone, force, "softened") == 0);
    CHECK(metric_of(together, force, "softened") > 1000);
    // The swing of the block has changed K a little.
    CHECK(metric_of(together, force, "contact_stiffness") == Approx(lambda_N_per_m).epsilon(0.2));
    CHECK(metric_of(lesser, force, "softened") == 0);
  }
  // A cap that limits nothing does not change a single bit.
  for (std::size_t hand = 0; hand < 2; ++hand)
    CHECK(furthest_apart(strategy(free.record, "phase_locked").devices[hand],
                         strategy(lesser.record, "phase_locked").devices[hand]) == 0);
}

TEST_CASE("a probe that slides off the edge is let go, and its local model errs less along the normal alone", "[sweep]") {
  const auto slid = [](const std::string& render) {
    return run_scenario(
        read("closed-loop/slide.toml", {"device.left.render=" + render, "run.strategies=[\"phase_locked\"]"}), {});
  };
  const std::string at = "left.force.phase_locked";
  const RunOutcome force = slid("{ kind = \"force\" }");
  const RunOutcome all = slid("{ kind = \"local\", stiffness = \"settled\" }");
  const RunOutcome normal = slid("{ kind = \"local\", stiffness = \"settled\", directions = \"normal\" }");
  CHECK(metric_of(force, at, "ghost_force") > 0.02);  // control: the tissue pulls for the latency
  CHECK(metric_of(all, at, "ghost_force") < 1e-3);
  CHECK(metric_of(normal, at, "ghost_force") < 1e-3);
  CHECK(metric_of(all, at, "error_share") > 2 * metric_of(force, at, "error_share"));
  CHECK(metric_of(normal, at, "error_share") < 0.6 * metric_of(all, at, "error_share"));
  CHECK(metric_of(normal, at, "jump_max") < 0.4 * metric_of(all, at, "jump_max"));
}

TEST_CASE("coupling is refused where nothing couples the hands, with the remedy") {
  for (const auto& [file, set] : std::vector<std::pair<std::string, std::string>>{
           {"closed-loop/block-grab.toml", "device.left.render={ kind = \"local\", coupled = true }"},
           {"closed-loop/price-local.toml", "device.left.render={ kind = \"local\", coupled = true }"},
           {"closed-loop/block-probe.toml", "device.left.render={ kind = \"local\", coupled = true }"}}) {
    const ReadResult result = read_scenario(shipped(file), {{set}, std::nullopt});
    REQUIRE_FALSE(result);
    std::string text;
    for (const Diagnostic& error : result.error()) text += error.message;
    CHECK_THAT(text, Catch::Contains("device 'left' renders with coupled = true") && Catch::Contains("or remove 'coupled'"));
  }
}

TEST_CASE("prints the largest eigenvalue of each scene at 1 N/m of a spring, for bench/stiffness_3d.py",
          "[.print-stiffness]") {
  for (const char* file : {"block-grab", "block-corner", "hands-far", "hands-near"}) {
    const std::string path = fmt::format("closed-loop/{}.toml", file);
    fmt::print("{:14} {:.4g}\n", file, largest_per_spring(path, {}, read(path).devices.size() == 2));
  }
}
