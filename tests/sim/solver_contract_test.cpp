// What every kind of solver promises.
#include <algorithm>
#include <thread>

#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct Run {
  std::vector<ToolResponse> forces;
  std::vector<std::uint64_t> digests;
  friend bool operator==(const Run& a, const Run& b) {
    return a.digests == b.digests &&
           std::equal(a.forces.begin(), a.forces.end(), b.forces.begin(), b.forces.end(),
                      [](const ToolResponse& x, const ToolResponse& y) { return same_bits(x, y); });
  }
};

Run run(Solver& solver, int steps = 60) {
  Run result;
  for (int n = 0; n < steps; ++n) {
    result.forces.push_back(step(solver, 2, wandering_tools(n)));
    result.digests.push_back(solver.state_digest());
  }
  return result;
}

Scene small_scene(bool energy = true) { return scene_of(small_block(), 1.0 / 450, energy); }

}  // namespace

TEST_CASE("Without motion there is no force at all and the state never changes", "[contract][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    const auto solver = make_solver(kind, small_scene(true));
    const std::uint64_t rest = solver->state_digest();
    const Positions anywhere{glm::dvec3(0.1, -7, 1e-9), glm::dvec3(1e3, 1.0 / 3, 0)};
    for (int n = 0; n < 1000; ++n) {
      const ToolResponse response = step(*solver, 2, anywhere);
      REQUIRE(response.force_N[0] == glm::dvec3(0));
      REQUIRE(response.force_N[1] == glm::dvec3(0));
      REQUIRE(solver->state_digest() == rest);
    }
    CHECK(solver->verdict().energy_J == 0);
  }
}

TEST_CASE("reset brings the whole run back, bit for bit, from any step", "[contract]") {
  for (const SolverKind kind : kEverySolver) {
    const auto solver = make_solver(kind, small_scene(true));
    const Run first = run(*solver);
    for (const int stop : {0, 1, 2, 17}) {
      solver->reset();
      run(*solver, stop);
      solver->reset();
      REQUIRE(run(*solver) == first);
    }
  }
}

TEST_CASE("Only displacements matter: where a tool starts does not", "[contract]") {
  for (const SolverKind kind : kEverySolver) {
    const auto here = make_solver(kind, small_scene()), there = make_solver(kind, small_scene());
    for (int n = 0; n < 60; ++n) {
      // These are multiples of 2^-20 m, so the shifted positions are exact, and the displacements too.
      Positions moved{glm::dvec3(n, -n, 2 * n) * 0x1p-13, glm::dvec3(0, n, -n) * 0x1p-13}, shifted = moved;
      for (glm::dvec3& position_m : shifted) position_m += glm::dvec3(4, -512, 0.5);
      REQUIRE(same_bits(step(*here, 2, moved), step(*there, 2, shifted)));
      REQUIRE(here->state_digest() == there->state_digest());
    }
  }
}

TEST_CASE("Digest and energy watch and do not touch", "[contract][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    Run plain;
    for (const bool energy : {false, true}) {
      for (const bool digest : {false, true}) {
        Scene scene = small_scene(energy);
        scene.needs_state_digest = digest;
        const auto solver = make_solver(kind, scene);
        Run with = run(*solver);
        if (!digest) CHECK(std::all_of(with.digests.begin(), with.digests.end(), [](std::uint64_t d) { return d == 0; }));
        with.digests.clear();
        if (plain.forces.empty()) plain = with;
        REQUIRE(with == plain);
        CHECK((solver->verdict().energy_J > 0) == energy);
      }
    }
  }
}

TEST_CASE("The digest sees a single bit of a single particle's motion", "[contract]") {
  for (const SolverKind kind : kEverySolver) {
    const auto a = make_solver(kind, small_scene()), b = make_solver(kind, small_scene());
    step(*a, 2, {});
    step(*b, 2, {});
    REQUIRE(a->state_digest() == b->state_digest());
    step(*a, 2, {glm::dvec3(1e-30, 0, 0), glm::dvec3(0)});
    step(*b, 2, {});
    CHECK(a->state_digest() != b->state_digest());
  }
}

TEST_CASE("Float follows double to rounding", "[contract]") {
  const auto single = make_solver(SolverKind::cpu_float, small_scene()),
             exact = make_solver(SolverKind::cpu_double, small_scene());
  double largest_N = 0, worst_N = 0;
  for (int n = 0; n < 200; ++n) {
    const ToolResponse a = step(*single, 2, wandering_tools(n)), b = step(*exact, 2, wandering_tools(n));
    for (std::size_t tool = 0; tool < 2; ++tool) {
      largest_N = std::max(largest_N, norm(b.force_N[tool]));
      worst_N = std::max(worst_N, norm(a.force_N[tool] - b.force_N[tool]));
    }
  }
  // 1 - L / len rounds by 6e-8 of a spring's k L = 0.1 N, which is 6e-9 N per spring. With a few hundred springs and a
  // random walk over 800 substeps this makes some 1e-6 N. Forces are of the order of 1 N.
  CHECK(largest_N > 0.1);
  CHECK(worst_N < 1e-5 * largest_N);
  CHECK(worst_N > 0);
}

TEST_CASE("A position that is not finite is refused and leaves the run as it was", "[contract]") {
  const double inf = std::numeric_limits<double>::infinity();
  for (const SolverKind kind : kEverySolver) {
    const auto solver = make_solver(kind, small_scene()), undisturbed = make_solver(kind, small_scene());
    for (int n = 0; n < 10; ++n) {
      for (const double bad : {inf, -inf, std::nan(""), 1e39}) {
        for (int tool = 0; tool < 2; ++tool) {
          Positions positions_m = wandering_tools(n);
          positions_m[static_cast<std::size_t>(tool)][n % 3] = bad;
          REQUIRE_THROWS_AS(step(*solver, 2, positions_m), SolverError);
        }
      }
      REQUIRE(same_bits(step(*solver, 2, wandering_tools(n)), step(*undisturbed, 2, wandering_tools(n))));
      REQUIRE(solver->state_digest() == undisturbed->state_digest());
    }
  }
}

TEST_CASE("What a scene does not need is named, and only that", "[contract]") {
  const auto names = [](const Scene& scene) {
    const auto solver = make_solver(SolverKind::cpu_float, scene);
    std::vector<std::string> found = solver->info().left_out;
    CHECK(found == left_out(scene));
    std::sort(found.begin(), found.end());
    return found;
  };
  using Names = std::vector<std::string>;
  TissueScene everything = small_block();
  everything.damping_per_s = everything.axial_damping_N_s_per_m = 1e-3;
  everything.gravity_m_per_s2.z = -9.81;
  everything.regions = {{{0, 0, 0}, {0.01, 1, 1}, 30, 2e-4}};
  everything.tools[1].kind = CouplingKind::spring;
  everything.tools[1].stiffness_N_per_m = 10;
  Scene all = scene_of(everything, 1e-3, true);
  all.variable_step = true;
  all.local_model = LocalModel::settled;
  CHECK(names(all) == Names{"probe"});
  auto& tools = std::get<TissueScene>(all.body).tools;
  tools[0] = {tools[0].center_m, 1e-3, CouplingKind::probe, 10};
  CHECK(names(all) == Names{"grab"});
  Scene nothing = scene_of(small_block(), 1e-3);
  nothing.needs_state_digest = false;
  CHECK(names(nothing) == Names{"axial damping", "damping", "energy", "gravity", "local model", "probe", "regions",
                                "spring coupling", "state digest", "variable step"});
  TissueScene bare = small_block();
  bare.fixed = FixedFaces::none();
  bare.tools.clear();
  CHECK(names(scene_of(bare, 1e-3)) == Names{"axial damping", "damping", "energy", "fixed particles", "grab", "gravity",
                                             "local model", "probe", "regions", "spring coupling", "tools",
                                             "variable step"});
}

TEST_CASE("A feature that is left out can be compiled in alone, and changes no bit", "[contract][sweep]") {
  for (const SolverKind kind : kAllSolvers) {
    Scene scene = scene_of(small_block(), 1e-3);
    scene.needs_state_digest = false;
    std::vector<std::string> neutral;
    for (const std::string& feature : left_out(scene)) {
      INFO(name_of(kind) << ", " << feature);
      const auto with = make_solver_with(feature, kind, scene);
      if (!with) continue;
      neutral.push_back(feature);
      const auto absent = with->info().left_out;
      CHECK(std::find(absent.begin(), absent.end(), feature) == absent.end());
      CHECK(absent.size() + 1 == left_out(scene).size());
      const auto plain = make_solver(kind, scene);
      for (int n = 0; n < 20; ++n)
        REQUIRE(same_bits(step(*plain, 2, wandering_tools(n)), step(*with, 2, wandering_tools(n))));
      CHECK((with->state_digest() != 0) == (feature == "state digest"));
      CHECK(with->contacts().empty() == (feature != "local model"));
    }
    CHECK(neutral == left_out(scene));
    CHECK_FALSE(make_solver_with("grab", kind, scene));  // the scene has one already
    CHECK_FALSE(make_solver_with("second tool", kind, scene));
    CHECK_FALSE(make_solver_with("state digest", kind, Scene{}));  // a spring has none
  }
}

TEST_CASE("Solvers built and run on four threads at once make the runs that they make alone", "[contract]") {
  TissueScene unlike_others = small_block();
  unlike_others.stiffness_N_per_m = 21;  // not in PoCL's cache in a new build folder, so all four compile
  const Scene scene = scene_of(unlike_others, 1.0 / 450);
  std::array<Run, 4> together;
  {
    std::vector<std::jthread> threads;
    for (Run& result : together) threads.emplace_back([&] { result = run(*make_solver(SolverKind::opencl, scene)); });
  }
  const Run alone = run(*make_solver(SolverKind::opencl, scene));
  for (const Run& result : together) CHECK(result == alone);
}
